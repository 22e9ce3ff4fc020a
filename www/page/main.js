/** The page: starts every part, opens a mesher and names its device. It uses the public interface of the package only. */
import { createMesher, version } from 'hexcast';

import { byId } from './dom.js';
import { clearPrivate } from './private_files.js';
import { startDownloads } from './downloads.js';
import { startEstimate } from './estimate.js';
import { startFields } from './fields.js';
import { addSample, readAgain, startFiles } from './files.js';
import { startFindings } from './findings.js';
import { startGeometries } from './geometries.js';
import { startLeaks } from './leaks.js';
import { clearMessages, showError } from './messages.js';
import { startResults } from './results.js';
import { startRun } from './run.js';
import { startSettings } from './settings.js';
import { isForeignHash, readHash, startSharing } from './share.js';
import { startSlices } from './slices.js';
import { startStale } from './stale.js';
import { change, on, set, state } from './state.js';
import { startTabs } from './tabs.js';
import { startView3d } from './view3d.js';

/** @typedef {import('hexcast').BackendChoice} BackendChoice */

/** The backend that was asked for last. @type {BackendChoice | null} */
let opened = null;

/** Opens a mesher in place of the last, and reads the files again. @param {BackendChoice} backend */
async function open(backend) {
  opened = backend;
  state.mesher?.dispose();
  // the mesh was disposed of with its mesher
  change('mesh', { mesh: null, skin: null });
  change('phase', { mesher: null, phase: 'starting' });
  byId('device').textContent = 'Looking for a GPU …';
  byId('device').dataset.backend = '';
  try {
    const mesher = await createMesher({ backend });
    if (opened !== backend) return mesher.dispose();
    change('mesher', { mesher });
    showDevice(mesher);
    await readAgain(mesher);
    change('phase', { phase: 'idle' });
  } catch (error) {
    if (opened !== backend) return undefined;
    change('phase', { phase: 'failed' });
    byId('device').textContent = 'hexcast could not start';
    showError(
      error,
      undefined,
      backend === 'cpu' ? undefined : { label: 'Use the processor', act: () => set({ backend: 'cpu' }) },
    );
  }
  return undefined;
}

/** @param {import('hexcast').Mesher} mesher */
function showDevice({ backend, adapter, fallback }) {
  const name = adapter?.name;
  const device = byId('device');
  device.dataset.backend = backend;
  device.dataset.software = String(Boolean(adapter?.software));
  if (backend === 'gpu' && adapter?.software)
    device.textContent = `Software GPU${name ? ` (${name})` : ''}: slower than a real one`;
  else if (backend === 'gpu') device.textContent = name ? `GPU: ${name}` : 'GPU; the browser does not name it';
  else
    device.textContent = fallback ? 'No GPU found: meshing on the processor, with the same result' : 'Meshing on the processor';
  device.title = fallback ?? adapter?.driver ?? '';
}

async function start() {
  /** @type {HTMLOutputElement} */ (byId('version')).value = version;
  startTabs();
  startFiles();
  startGeometries();
  startSettings();
  startFields();
  startEstimate();
  startRun(restart);
  startResults();
  startFindings();
  startLeaks();
  startStale();
  startDownloads();
  startSharing();
  startSlices();
  startView3d();
  const sample = readHash();
  addEventListener('hashchange', () => {
    if (isForeignHash()) takeSample(readHash());
  });
  on('settings', () => {
    if (state.settings.backend !== opened) open(state.settings.backend);
  });
  // the mesher may have lost its GPU
  on('mesh', () => state.mesh && state.mesher && showDevice(state.mesher));
  await open(state.settings.backend);
  takeSample(sample);
}

/** Opens another mesher after a failure; nothing else is lost. @param {BackendChoice} backend */
function restart(backend) {
  clearMessages();
  if (state.settings.backend === backend) open(backend);
  else set({ backend });
}

/** @param {string | null} sample */
function takeSample(sample) {
  if (sample) addSample(sample);
}

/** Registers the service worker, which keeps the page for when there is no network. */
function keepOffline() {
  // private windows may refuse
  if (isSecureContext) navigator.serviceWorker?.register('offline.js').catch(() => {});
}

start();
addEventListener('load', () => setTimeout(keepOffline, 1000));
clearPrivate();

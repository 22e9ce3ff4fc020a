/** The mesher: opened for the backend that is chosen. Until another is open, the last one and its mesh stay. */
import { createMesher } from 'hexcast';

import { byId } from '../elements/dom.js';
import { readAgain } from '../geometries/files.js';
import { clearMessages, showError } from '../elements/messages.js';
import { change, on, set, state } from '../state/state.js';

/** @typedef {import('hexcast').BackendChoice} BackendChoice @typedef {import('hexcast').Mesher} Mesher */

/** The backend that was asked for last. @type {BackendChoice | null} */
let wanted = null;
/** The backend of the mesher. @type {BackendChoice | null} */
let opened = null;
/** Meshers that are kept for the mesh that is shown. @type {Mesher[]} */
let retired = [];

/** Follows the choice of the backend. */
export function startDevice() {
  on('settings', () => {
    if (state.settings.backend !== wanted) openMesher(state.settings.backend);
  });
  on('mesh', () => {
    for (const mesher of retired) mesher.dispose();
    retired = [];
    // the mesher may have lost its GPU
    if (state.mesh && state.mesher) showDevice(state.mesher);
  });
}

/** Opens a mesher in place of the last, and reads the files again. @param {BackendChoice} backend */
export async function openMesher(backend) {
  wanted = backend;
  change('phase', { phase: 'starting' });
  say('Looking for a GPU …', '');
  try {
    const mesher = await createMesher({ backend });
    if (wanted !== backend) return mesher.dispose();
    const before = state.mesher;
    opened = backend;
    change('mesher', { mesher });
    showDevice(mesher);
    await readAgain(mesher);
    if (before && state.mesh) retired.push(before);
    else before?.dispose();
    change('phase', { phase: 'idle' });
  } catch (error) {
    if (wanted === backend) failed(error, backend);
  }
  return undefined;
}

/** Goes on with the mesher that there was, if there was one. @param {unknown} error @param {BackendChoice} backend */
function failed(error, backend) {
  const remedy = { label: 'Use the processor', act: () => set({ backend: 'cpu' }) };
  showError(error, undefined, backend === 'cpu' || opened === 'cpu' ? undefined : remedy);
  if (!state.mesher || !opened) {
    change('phase', { phase: 'failed' });
    say('hexcast could not start', '');
    return;
  }
  wanted = opened;
  showDevice(state.mesher);
  change('phase', { phase: 'idle' });
  set({ backend: opened });
}

/** @param {Mesher} mesher */
function showDevice({ backend, adapter, fallback }) {
  const name = adapter?.name;
  const device = byId('device');
  device.dataset.software = String(Boolean(adapter?.software));
  device.title = fallback ?? adapter?.driver ?? '';
  const cpu = fallback ? 'No GPU found: meshing on the processor, with the same result' : 'Meshing on the processor';
  const gpu = name ? `GPU: ${name}` : 'GPU; the browser does not name it';
  const software = `Software GPU${name ? ` (${name})` : ''}: slower than a real one`;
  say(backend === 'cpu' ? cpu : adapter?.software ? software : gpu, backend);
}

/** @param {string} text @param {string} backend */
function say(text, backend) {
  byId('device').textContent = text;
  byId('device').dataset.backend = backend;
}

/** Opens another mesher after a failure; nothing else is lost. @param {BackendChoice} backend */
export function restart(backend) {
  clearMessages();
  if (state.settings.backend === backend) openMesher(backend);
  else set({ backend });
}

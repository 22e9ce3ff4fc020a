/** The page: starts every part, opens a mesher and takes what the address and the last visit have. */
import { version } from 'hexcast';

import { startCompare } from './compare.js';
import { startConverge } from './converge.js';
import { openMesher, restart, startDevice } from './device.js';
import { byId } from './dom.js';
import { clearPrivate } from './private_files.js';
import { startDownloads } from './downloads.js';
import { startExports } from './exports.js';
import { startEstimate } from './estimate.js';
import { startFields } from './fields.js';
import { addSample, startFiles } from './files.js';
import { startFindings } from './findings.js';
import { startFocus } from './focus.js';
import { startGeometries } from './geometries.js';
import { startHistory } from './history.js';
import { startLeaks } from './leaks.js';
import { startPatches } from './patches.js';
import { LICENCES } from './real_models.js';
import { startResults } from './results.js';
import { startRun } from './run.js';
import { startSession } from './session.js';
import { startSettings } from './settings.js';
import { isForeignHash, readHash, startSharing } from './share.js';
import { startSlices } from './slices.js';
import { startStale } from './stale.js';
import { state } from './state.js';
import { startSurfaces } from './surfaces.js';
import { startTabs } from './tabs.js';
import { startTasks } from './tasks.js';
import { startView3d } from './view3d.js';

async function start() {
  /** @type {HTMLOutputElement} */ (byId('version')).value = version;
  byId('help-open').addEventListener('click', () => /** @type {HTMLDialogElement} */ (byId('help')).showModal());
  /** @type {HTMLAnchorElement} */ (byId('licences')).href = LICENCES;
  startFocus();
  startTabs();
  startFiles();
  startTasks();
  startSurfaces();
  startGeometries();
  startPatches();
  startSettings();
  startFields();
  startEstimate();
  startRun(restart);
  startConverge();
  startResults();
  startFindings();
  startLeaks();
  startCompare();
  startStale();
  startDownloads();
  startExports();
  startSharing();
  startSlices();
  startView3d();
  const sample = readHash();
  addEventListener('hashchange', () => {
    if (isForeignHash()) takeSample(readHash());
  });
  startDevice();
  startHistory();
  startSession(sample !== null);
  await openMesher(state.settings.backend);
  takeSample(sample);
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

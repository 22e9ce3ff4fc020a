/** The page: starts every part, opens a mesher and takes what the address and the last visit have. */
import { version } from 'hexcast';

import { startCadAgain } from './geometries/cad_again.js';
import { startCompare } from './results/compare.js';
import { startConverge } from './results/converge.js';
import { openMesher, restart, startDevice } from './run/device.js';
import { byId } from './elements/dom.js';
import { clearPrivate } from './downloads/private_files.js';
import { startFileList } from './downloads/file_list.js';
import { startLeave } from './downloads/leave.js';
import { startEstimate } from './run/estimate.js';
import { startFields } from './settings/wrong_fields.js';
import { addSample, arrive, startFiles } from './geometries/files.js';
import { startFindings } from './results/findings.js';
import { startFocus } from './elements/focus.js';
import { startGeometries } from './geometries/geometries.js';
import { startHistory } from './session/history.js';
import { startFineness } from './settings/fineness.js';
import { startLive } from './run/live.js';
import { startLeaks } from './results/leaks.js';
import { startPatches } from './geometries/patches.js';
import { LICENCES } from './geometries/real_models.js';
import { startResults } from './results/results.js';
import { startRun } from './run/run.js';
import { startSession } from './session/session.js';
import { startSettings } from './settings/settings.js';
import { isForeignHash, readHash, startSharing } from './settings/share.js';
import { startCrosshair } from './view/crosshair.js';
import { startClaims } from './view/claims.js';
import { startInspector } from './view/inspector.js';
import { startMeasure } from './view/measure.js';
import { startPanes } from './view/panes.js';
import { startSlices } from './view/slice/slices.js';
import { startStretch } from './view/stretch.js';
import { startStale } from './run/stale_notice.js';
import { state } from './state/state.js';
import { startSurfaces } from './geometries/surfaces.js';
import { startTasks } from './elements/tasks.js';
import { startView3d } from './view/view3d.js';

async function start() {
  /** @type {HTMLOutputElement} */ (byId('version')).value = version;
  byId('help-open').addEventListener('click', () => /** @type {HTMLDialogElement} */ (byId('help')).showModal());
  /** @type {HTMLAnchorElement} */ (byId('licences')).href = LICENCES;
  startFocus();
  startFiles();
  startTasks();
  startSurfaces();
  startCadAgain();
  startGeometries();
  startPatches();
  startSettings();
  startFields();
  startEstimate();
  startRun(restart);
  startLive();
  startFineness();
  startConverge();
  startResults();
  startFindings();
  startLeaks();
  startCompare();
  startStale();
  startLeave();
  startFileList();
  startSharing();
  startCrosshair();
  startMeasure();
  startStretch();
  startPanes();
  startInspector();
  startClaims();
  startSlices();
  startView3d();
  const sample = readHash();
  addEventListener('hashchange', () => {
    if (isForeignHash()) takeSample(readHash());
  });
  startDevice();
  startHistory();
  const isPlain = location.hash === '';
  const session = startSession(sample !== null);
  await openMesher(state.settings.backend);
  takeSample(sample);
  await session;
  const isAsked = document.querySelector('[data-about=session]') !== null;
  if (isPlain && state.live && state.mesher && !isAsked && state.geometries.length === 0) arrive();
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

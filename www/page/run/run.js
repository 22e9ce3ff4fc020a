/** Run and Cancel, with progress in words and as a bar. */
import { HexcastError } from 'hexcast';

import { buttonOf, byId, oncePerFrame } from '../elements/dom.js';
import { count, duration, roughly } from '../text/format.js';
import { currentJob } from '../state/job.js';
import { wrongField } from '../settings/wrong_fields.js';
import { clearMessages, showError } from '../elements/messages.js';
import { change, on, set, state } from '../state/state.js';
import { runsOf } from '../view/view3d.js';

/** @typedef {import('hexcast').BackendChoice} BackendChoice */

const STAGES = { read: 'Reading', check: 'Checking', preview: 'Drawing', mesh: 'Meshing', write: 'Writing' };

/** @type {AbortController | null} */
let stop = null;

/**
 * Connects the buttons.
 *
 * @param {(backend: BackendChoice) => void} restart starts another mesher, where the device was lost
 */
export function startRun(restart) {
  byId('run').addEventListener('click', () => run(restart));
  byId('cancel').addEventListener('click', () => stop?.abort());
  document.addEventListener('keydown', (event) => {
    if (event.key === 'Enter' && (event.ctrlKey || event.metaKey) && !buttonOf('run').disabled) run(restart);
    if (event.key === 'Escape') stop?.abort();
  });
  on(['phase', 'geometries', 'settings', 'fields', 'mesher', 'estimate'], show);
  show();
}

function show() {
  const isMeshing = state.phase === 'meshing';
  byId('run').hidden = isMeshing;
  byId('cancel').hidden = !isMeshing;
  byId('progress').hidden = !isMeshing;
  buttonOf('run').disabled =
    !state.mesher ||
    state.phase !== 'idle' ||
    state.geometries.length === 0 ||
    Boolean(state.estimate?.error) ||
    wrongField() !== null;
  document.body.dataset.phase = state.phase;
}

/** @param {(backend: BackendChoice) => void} restart */
async function run(restart) {
  const { mesher } = state;
  if (!mesher) return;
  clearMessages();
  const job = currentJob();
  const expected = state.estimate?.result ?? null;
  const status = byId('status');
  const start = performance.now();
  stop = new AbortController();
  byId('progress').removeAttribute('value');
  status.textContent = 'Meshing …';
  // a screen reader speaks the beginning and the end; for the rest there is the progress bar
  status.ariaLive = 'off';
  change('phase', { phase: 'meshing' });
  const hadFocus = document.activeElement === document.body || document.activeElement === byId('run');
  if (hadFocus) byId('cancel').focus({ preventScroll: true });
  try {
    const mesh = await mesher.mesh(job, { signal: stop.signal, onProgress: watch(start, expected?.cells ?? 0) });
    state.mesh?.dispose();
    // requested before listeners request anything, so that the worker copies them first
    const runs = runsOf(mesh);
    const seconds = (performance.now() - start) / 1000;
    status.ariaLive = 'polite';
    status.textContent = `Meshed ${count(mesh.report.cells)} cells in ${duration(seconds)}.`;
    change('phase', { phase: 'idle' });
    change('mesh', { mesh, job, runs, expected });
  } catch (error) {
    // another mesher may be starting: then the page is not idle yet
    if (state.phase === 'meshing') change('phase', { phase: 'idle' });
    const isAbort = stop.signal.aborted;
    status.ariaLive = 'polite';
    status.textContent = isAbort ? 'Cancelled; nothing was lost.' : '';
    if (!isAbort) showError(error, undefined, remedy(error, restart));
  } finally {
    stop = null;
    if (hadFocus) byId('run').focus({ preventScroll: true });
  }
}

/** What the user can do about a lost or failing device, or an open surface. @param {unknown} error @param {(backend: BackendChoice) => void} restart */
function remedy(error, restart) {
  const code = error instanceof HexcastError ? error.code : null;
  if (code === 'device-lost') return { label: 'Open the GPU again', act: () => restart(state.settings.backend) };
  if (code === 'device-failed' || code === 'no-adapter') return { label: 'Use the processor', act: () => restart('cpu') };
  if (code === 'surface-open') return { label: 'Use the winding number', act: () => set({ open: 'winding' }) };
  return undefined;
}

/**
 * Shows progress once a frame: stage, percent, cells a second, time left.
 *
 * @param {number} start
 * @param {number} cells
 */
function watch(start, cells) {
  /** @type {import('hexcast').Progress | null} */
  let last = null;
  let stageStart = start;
  const draw = oncePerFrame(() => {
    if (!stop || !last) return;
    const share = last.total > 0 ? last.done / last.total : 0;
    const seconds = (performance.now() - stageStart) / 1000;
    /** @type {HTMLProgressElement} */ (byId('progress')).value = share;
    const words = [`${STAGES[last.stage]}: ${Math.floor(100 * share)} %`];
    if (last.stage === 'mesh' && cells && seconds > 0.2) words.push(`${roughly((cells * share) / seconds)} cells/s`);
    if (share > 0.02 && seconds > 0.5) words.push(`${duration((seconds * (1 - share)) / share)} left`);
    byId('status').textContent = words.join(', ');
  });
  return (/** @type {import('hexcast').Progress} */ progress) => {
    if (last?.stage !== progress.stage) stageStart = performance.now();
    last = progress;
    draw();
  };
}

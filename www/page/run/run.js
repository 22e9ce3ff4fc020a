/** A mesh is made, with progress in words and as a bar; Run and Cancel. */
import { HexcastError } from 'hexcast';

import { buttonOf, byId, oncePerFrame } from '../elements/dom.js';
import { count, duration, roughly } from '../text/format.js';
import { currentJob, keyOfCells } from '../state/job.js';
import { release } from '../state/held.js';
import { comesByItself } from './live_rule.js';
import { wrongField } from '../settings/wrong_fields.js';
import { clearMessages, showError } from '../elements/messages.js';
import { change, on, set, state } from '../state/state.js';
import { runsOf } from '../view/view3d.js';

/** @typedef {import('hexcast').BackendChoice} BackendChoice */

const STAGES = { read: 'Reading', check: 'Checking', preview: 'Drawing', mesh: 'Meshing', write: 'Writing' };

/** Milliseconds after which a mesh that nobody asked for has a bar and a button that cancels it. */
const PATIENCE = 300;

/** Why a mesh that nobody asked for was ended by the page. */
const SUPERSEDED = 'superseded';

/** @type {AbortController | null} */
let stop = null;
/** Whether the mesh that is made has its bar. */
let isSeen = false;
/** Resolves once the mesh that is made last is there, or is not. @type {Promise<unknown>} */
let end = Promise.resolve();
/** Starts another mesher, where the device was lost. @type {(backend: BackendChoice) => void} */
let restart;

/**
 * Connects the buttons.
 *
 * @param {(backend: BackendChoice) => void} restarting starts another mesher, where the device was lost
 */
export function startRun(restarting) {
  restart = restarting;
  byId('run').addEventListener('click', run);
  byId('cancel').addEventListener('click', () => stop?.abort());
  document.addEventListener('keydown', (event) => {
    if (event.key === 'Enter' && (event.ctrlKey || event.metaKey) && !buttonOf('run').disabled) run();
    // what is not seen is no mesh that somebody cancels
    if (event.key === 'Escape' && isSeen) stop?.abort();
  });
  on(['phase', 'geometries', 'settings', 'fields', 'mesher', 'estimate', 'live', 'mesh'], show);
  show();
}

function show() {
  byId('run').hidden = isSeen || (state.geometries.length > 0 && comesByItself(currentJob()));
  byId('cancel').hidden = !isSeen;
  byId('progress').hidden = !isSeen;
  buttonOf('run').disabled =
    !state.mesher ||
    state.phase !== 'idle' ||
    state.geometries.length === 0 ||
    Boolean(state.estimate?.error) ||
    wrongField() !== null;
  document.body.dataset.phase = state.phase;
}

async function run() {
  await endUpdate();
  if (state.phase === 'idle') await makeMesh('meshing', currentJob(), state.estimate?.result ?? null);
}

/** Ends a mesh that nobody asked for: something else comes first. */
export async function endUpdate() {
  if (state.phase !== 'updating') return;
  stop?.abort(SUPERSEDED);
  await end;
}

/**
 * Makes a mesh and shows it. What goes wrong is said, and is not tried again before the job changes. False where something else came first.
 *
 * @param {'meshing' | 'updating'} phase updating where nobody asked for it: then it is seen once it takes long, and no focus moves
 * @param {ReturnType<typeof currentJob>} job
 * @param {import('hexcast').Estimate | null} expected
 */
export function makeMesh(phase, job, expected) {
  const making = meshAndShow(phase, job, expected);
  end = making;
  return making;
}

/** @param {'meshing' | 'updating'} phase @param {ReturnType<typeof currentJob>} job @param {import('hexcast').Estimate | null} expected */
async function meshAndShow(phase, job, expected) {
  const { mesher } = state;
  if (!mesher) return false;
  const isAsked = phase === 'meshing';
  clearMessages(isAsked ? undefined : 'run');
  const [status, start, mine] = [byId('status'), performance.now(), new AbortController()];
  stop = mine;
  isSeen = isAsked;
  byId('progress').removeAttribute('value');
  // a screen reader speaks the beginning and the end; for the rest there is the progress bar
  status.ariaLive = 'off';
  if (isAsked) status.textContent = 'Meshing …';
  change('phase', { phase });
  const later = setTimeout(() => {
    isSeen = true;
    show();
  }, PATIENCE);
  let hadFocus = isAsked && (document.activeElement === document.body || document.activeElement === byId('run'));
  if (hadFocus) byId('cancel').focus({ preventScroll: true });
  try {
    const mesh = await mesher.mesh(job, { signal: mine.signal, onProgress: watch(start, expected?.cells ?? 0) });
    release(state.mesh);
    // requested before listeners request anything, so that the worker copies them first
    const runs = runsOf(mesh);
    const seconds = (performance.now() - start) / 1000;
    if (isAsked) status.ariaLive = 'polite';
    status.textContent = `Meshed ${count(mesh.report.cells)} cells in ${duration(seconds)}.`;
    hadFocus ||= document.activeElement === byId('cancel');
    isSeen = false;
    change('phase', { phase: 'idle' });
    change('mesh', { mesh, job, runs, expected, left: null });
  } catch (error) {
    hadFocus ||= document.activeElement === byId('cancel');
    isSeen = false;
    const [isAbort, isSuperseded] = [mine.signal.aborted, mine.signal.reason === SUPERSEDED];
    if (!isSuperseded) state.left = { key: keyOfCells(job), mesher };
    // another mesher may be starting: then the page is not idle yet
    if (state.phase === phase) change('phase', { phase: 'idle' });
    status.ariaLive = 'polite';
    status.textContent = isAbort && !isSuperseded ? 'Cancelled; nothing was lost.' : '';
    if (!isAbort) showError(error, undefined, remedy(error), 'run');
  } finally {
    clearTimeout(later);
    stop = null;
    if (hadFocus) byId(byId('run').hidden ? 'run-bar' : 'run').focus({ preventScroll: true });
  }
  return mine.signal.reason !== SUPERSEDED;
}

/** What the user can do about a lost or failing device, or an open surface. @param {unknown} error */
function remedy(error) {
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
    if (!stop || !last || !isSeen) return;
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

/** Long work besides meshes: each has a line with what is done, a bar, and a button that ends it. */
import { byId, make, oncePerFrame } from './dom.js';
import { on, state } from '../state/state.js';

/** @typedef {import('hexcast').CallOptions} CallOptions */

/** Milliseconds after which work has a line: before, it would only flash. */
const PATIENCE = 150;

/** Work that goes on, the newest last. @type {Set<AbortController>} */
const running = new Set();

/** Escape ends the newest work, unless a mesh is made or a dialog is open. */
export function startTasks() {
  document.addEventListener('keydown', (event) => {
    if (event.key !== 'Escape' || state.phase === 'meshing' || document.querySelector('dialog[open]')) return;
    [...running].at(-1)?.abort();
  });
  // a mesh goes first
  on('phase', () => byId('tasks').classList.toggle('waiting', state.phase === 'meshing'));
}

/**
 * Does long work, which can be ended by its button, or by `signal`.
 *
 * @template T
 * @param {string} what such as `Reading case.stl`
 * @param {(options: CallOptions) => Promise<T>} act
 * @param {AbortSignal} [signal]
 * @returns {Promise<T>}
 */
export async function task(what, act, signal) {
  const stop = new AbortController();
  const end = () => stop.abort(signal?.reason);
  signal?.addEventListener('abort', end);
  const { line, show } = lineOf(what, stop);
  const timer = setTimeout(() => byId('tasks').append(line), PATIENCE);
  running.add(stop);
  try {
    return await act({ signal: stop.signal, onProgress: ({ done, total }) => show(total > 0 ? done / total : 0) });
  } finally {
    running.delete(stop);
    clearTimeout(timer);
    signal?.removeEventListener('abort', end);
    const hadFocus = line.contains(document.activeElement);
    line.remove();
    if (hadFocus) byId('run-bar').focus({ preventScroll: true });
  }
}

/** @param {string} what @param {AbortController} stop */
function lineOf(what, stop) {
  const said = make('span', {}, what);
  const bar = make('progress', { max: 1, 'aria-label': what });
  const cancel = { type: 'button', className: 'small', 'aria-label': `Cancel: ${what}`, on: { click: () => stop.abort() } };
  const line = make('li', {}, said, make('button', cancel, 'Cancel'), bar);
  let last = 0;
  const draw = oncePerFrame(() => {
    bar.value = last;
    said.textContent = `${what}: ${Math.floor(100 * last)} %`;
  });
  const show = (/** @type {number} */ share) => {
    last = share;
    draw();
  };
  return { line, show };
}

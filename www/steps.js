/** Long work of the wasm in steps: between them messages arrive, also one that cancels, and a mesh goes first. */
import { cancelled, pause } from './call.js';

/**
 * What the wasm does in steps.
 *
 * @template T
 * @typedef {{ step(): boolean, share(): number, finish(): T, free(): void }} Work `finish` frees it
 */

/**
 * Does all of the work.
 *
 * @template T
 * @param {Work<T>} work
 * @param {'check' | 'preview'} stage
 * @param {import('./call.js').Listener} progress
 * @param {import('./call.js').State} state
 * @param {() => Promise<unknown>} turn resolves when no mesh is made
 * @returns {Promise<T>}
 */
export async function inSteps(work, stage, progress, state, turn) {
  try {
    while (work.step()) {
      progress({ stage, done: work.share(), total: 1 });
      await pause();
      await turn();
      if (state.cancelled) throw cancelled();
    }
  } catch (error) {
    work.free();
    throw error;
  }
  progress({ stage, done: 1, total: 1 });
  return work.finish();
}

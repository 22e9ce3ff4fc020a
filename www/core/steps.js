/** Long work of the wasm in steps, between which messages arrive, also one that cancels. */
import { cancelled, pause } from '../protocol/call.js';

/**
 * What the wasm does in steps; `finish` frees it.
 *
 * @template T
 * @typedef {{ step(): boolean, finish(): T, free(): void, share?(): number }} Work
 */

/**
 * Does all of the work.
 *
 * @template T
 * @param {Work<T>} work
 * @param {import('../protocol/call.js').State} state
 * @param {(share: number) => Promise<unknown>} [onStep] is told what share is done, 0 to 1, and waited for
 * @returns {Promise<T>}
 */
export async function inSteps(work, state, onStep) {
  try {
    while (work.step()) {
      await onStep?.(work.share?.() ?? 0);
      await pause();
      if (state.cancelled) throw cancelled();
    }
  } catch (error) {
    work.free();
    throw error;
  }
  await onStep?.(1);
  return work.finish();
}

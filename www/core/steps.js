/** Long work of the wasm in steps, between which messages arrive, also one that cancels. */
import { cancelled, pause } from '../protocol/call.js';

/**
 * Does all of the work; returns what it made, which its maker describes.
 *
 * @param {import('../hexcast_wasm.js').WebWork} work
 * @param {import('../protocol/call.js').State} state
 * @param {(share: number) => Promise<unknown>} [onStep] is told what share is done, 0 to 1, and waited for
 * @returns {Promise<any>}
 */
export async function inSteps(work, state, onStep) {
  try {
    while (work.step()) {
      await onStep?.(work.share());
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

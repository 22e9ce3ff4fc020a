import { HexcastError } from './error.js';

/**
 * A call of the core while it runs: whether it is cancelled, and the function that receives its progress.
 *
 * @typedef {{ stop: import('../hexcast_wasm.js').WebSwitch, cancelled: boolean }} State
 * @typedef {(progress: import('../hexcast.js').Progress) => void} Listener
 */

/** Resolves once all waiting messages were handled, also one that cancels. */
export function pause() {
  return new Promise((resolve) => {
    const { port1, port2 } = new MessageChannel();
    port1.onmessage = () => {
      port1.close();
      resolve(undefined);
    };
    port2.postMessage(null);
  });
}

/** The error of a call that was cancelled. */
export function cancelled() {
  return new HexcastError('cancelled', 'cancelled');
}

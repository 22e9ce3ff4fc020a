/** Requests to the core, and its answers: what a worker and a core on the calling thread do alike. */
import { asError, failureOf } from '../protocol/error.js';

/**
 * Answers a request with the result of its operation or an error; `report` receives progress.
 *
 * @param {import('./core.js').Core} core
 * @param {{ id: number, operation: import('./core.js').Operation, args: any }} request
 * @param {(answer: { id: number, progress: import('../hexcast.js').Progress }) => void} report
 * @returns {Promise<{ id: number, result?: unknown, failure?: import('../protocol/error.js').Failure }>}
 */
export async function answer(core, { id, operation, args }, report) {
  try {
    const progress = (/** @type {import('../hexcast.js').Progress} */ at) => report({ id, progress: at });
    // what a call is cancelled with is the wasm's, which `load` brings
    const result = operation === 'load' ? await core.load(args) : await core.run(operation, id, args, progress);
    return { id, result };
  } catch (error) {
    return { id, failure: failureOf(asError(error)) };
  }
}

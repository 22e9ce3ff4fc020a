/**
 * Answers messages to a worker `{id, operation, args}` with `{id, result}`, `{id, failure}` or, on the way, `{id, progress}`. `{cancel: id}`
 * stops a call. Bytes go back without a copy.
 */
import { answer } from './answer.js';

/** @param {import('./core.js').Core} core */
export function answerAll(core) {
  addEventListener('message', async ({ data }) => {
    if (data.cancel !== undefined) {
      core.cancel(data.cancel);
      return;
    }
    const made = await answer(core, data, (progress) => postMessage(progress));
    try {
      postMessage(made, { transfer: buffers(made.result) });
    } catch {
      // the cause of a failure may be anything, also what cannot be sent
      const { id, failure } = made;
      if (failure)
        postMessage({ id, failure: { ...failure, remarks: { ...failure.remarks, cause: String(failure.remarks.cause) } } });
    }
  });
}

/**
 * The buffers of a result that was made for this answer alone.
 *
 * @param {unknown} result
 */
function buffers(result) {
  /** @type {ArrayBuffer[]} */
  const found = [];
  const look = (/** @type {unknown} */ value) => {
    if (ArrayBuffer.isView(value)) found.push(/** @type {ArrayBuffer} */ (value.buffer));
    else if (value && typeof value === 'object') Object.values(value).forEach(look);
  };
  look(result);
  return found;
}

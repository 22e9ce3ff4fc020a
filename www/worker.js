/**
 * The worker. It runs a core, and answers messages `{id, operation, args}` with `{id, result}`, `{id, failure}` or, on the way,
 * `{id, progress}`; `{cancel: id}` stops a call. Or it is a thread of a core, whose only message is `{module, memory}`; it answers null when
 * it waits for work, and says why where it failed.
 */
import { answer } from './core/answer.js';
import { Core } from './core/core.js';
import * as many from './hexcast_threads.js';
import * as one from './hexcast_wasm.js';

/** @type {Core | undefined} */
let core;
addEventListener('message', ({ data }) => {
  if (data.module) runThread(data);
  else if (data.cancel !== undefined) core?.cancel(data.cancel);
  else answerTo(data);
});

/** Answers a request; bytes go back without a copy. @param {Parameters<typeof answer>[1]} request */
async function answerTo(request) {
  // the first is `load`
  core ??= request.args.hasThreads ? new Core(many) : new Core(one);
  const made = await answer(core, request, (progress) => postMessage(progress));
  try {
    postMessage(made, { transfer: buffers(made.result) });
  } catch {
    // the cause of a failure may be anything, also what cannot be sent
    const { id, failure } = made;
    if (failure)
      postMessage({ id, failure: { ...failure, remarks: { ...failure.remarks, cause: String(failure.remarks.cause) } } });
  }
}

/** The buffers of a result that was made for this answer alone. @param {unknown} result */
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

/** Works for a core, for as long as it lives. @param {import('./client/threads.js').Shared} shared */
async function runThread({ module, memory }) {
  await many.default({ module_or_path: module, memory });
  postMessage(null);
  try {
    many.runThread();
  } catch (error) {
    // the core waits for its work, and hears nothing
    postMessage(String(error));
  }
}

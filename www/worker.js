/**
 * The worker. It runs a core, and answers messages `{id, operation, args}` with `{id, result}`, `{id, failure}` or, on the way,
 * `{id, progress}`; `{cancel: id}` stops a call. In pages that are isolated from other origins it starts itself again as threads of its wasm,
 * whose first message is `{module, memory}`.
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
  core ??= request.args.hasThreads ? new Core(many, startThread) : new Core(one);
  const made = await answer(core, request, (progress) => postMessage(progress));
  try {
    postMessage(made, { transfer: buffers(made.result) });
  } catch {
    // the cause of a failure may be anything, also what cannot be sent
    const { id, failure } = made;
    if (failure) postMessage({ id, failure: { ...failure, remarks: { ...failure.remarks, cause: String(failure.remarks.cause) } } });
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

/** Starts a thread: this script again, as a bundler that makes one script of it knows no other. @type {import('./core/threads.js').StartThread} */
function startThread(shared) {
  const worker = new Worker(location.href, { type: isModule() ? 'module' : 'classic' });
  const ready = new Promise((resolve, reject) => {
    worker.onmessage = resolve;
    worker.onerror = reject;
  });
  worker.postMessage(shared);
  return { ready, end: () => worker.terminate() };
}

/** Whether this worker was started as a module, where there are no scripts to import. */
function isModule() {
  try {
    // of no script
    /** @type {any} */ (globalThis).importScripts();
    return false;
  } catch {
    return true;
  }
}

/** Works for the worker that started this one, for as long as it lives. @param {import('./core/threads.js').Shared} shared */
async function runThread({ module, memory, failures }) {
  await many.default({ module_or_path: module, memory });
  postMessage(null);
  try {
    many.runThread();
  } catch (error) {
    // who started it waits for its work, and hears nothing
    new BroadcastChannel(/** @type {string} */ (failures)).postMessage(String(error));
  }
}

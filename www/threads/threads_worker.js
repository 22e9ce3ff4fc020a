/** The worker of pages that are isolated from other origins: its wasm computes on several threads. */
import { Core } from '../core/core.js';
import { answerAll } from '../core/answer_all.js';
import * as glue from '../hexcast_threads.js';

answerAll(new Core(glue, startThread));

/** @type {import('../core/threads.js').StartThread} */
function startThread(shared) {
  const worker = new Worker(new URL('./thread.js', import.meta.url), { type: 'module' });
  const ready = new Promise((resolve, reject) => {
    worker.onmessage = resolve;
    worker.onerror = reject;
  });
  worker.postMessage(shared);
  return { ready, end: () => worker.terminate() };
}

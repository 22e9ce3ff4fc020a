/** A thread of the wasm in Node. */
import { writeSync } from 'node:fs';
import { parentPort, workerData } from 'node:worker_threads';

import init, { runThread } from '../hexcast_threads.js';

const { module, memory } = workerData;
await init({ module_or_path: module, memory });
parentPort?.postMessage(null);
try {
  // for as long as the worker lives
  runThread();
} catch (error) {
  // who started it waits for its work for ever, and hears nothing
  writeSync(2, `hexcast: a thread failed: ${error}\n`);
  process.kill(process.pid, 'SIGABRT');
}

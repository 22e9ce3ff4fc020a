/** Files of CAD in Node: see `cad.d.ts`. */
import { fileURLToPath } from 'node:url';
import { Worker } from 'node:worker_threads';

import { readBy } from './cad/read.js';

export { MUCH as largeBytes, kindOfCad } from './cad/read.js';

/** @type {typeof import('./cad.js').readCad} */
export async function readCad(source, options) {
  return readBy(start, source, options);
}

/** Starts the thread. @type {import('./cad/read.js').Start} */
function start(asked, answer) {
  const [script, wasm] = ['js', 'wasm'].map((ending) =>
    fileURLToPath(new URL(`./cad/occt/occt-import-js.${ending}`, import.meta.url)),
  );
  const worker = new Worker(new URL('./cad/node_worker.js', import.meta.url), { workerData: { ...asked, script, wasm } });
  worker.once('message', answer);
  worker.once('error', (error) => answer({ failure: String(error) }));
  return () => worker.terminate();
}

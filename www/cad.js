/** Files of CAD in a page: see `cad.d.ts`. */
import { readBy } from './cad/read.js';
import { packageFolder } from './platform/own_files.js';
import { started } from './start_worker.js';

export { MUCH as largeBytes, kindOfCad } from './cad/read.js';

/** @type {typeof import('./cad.js').readCad} */
export async function readCad(source, options) {
  return readBy(start, source, options);
}

/** Starts the worker. @type {import('./cad/read.js').Start} */
function start(asked, answer) {
  const worker = started(ownWorker);
  worker.onmessage = ({ data }) => answer(data);
  worker.onerror = (event) => {
    event.preventDefault();
    answer({ failure: event.message || 'its worker cannot be loaded' });
  };
  const [script, wasm] = ownFiles().map(({ href }) => href);
  worker.postMessage({ ...asked, script, wasm });
  return () => worker.terminate();
}

/** The worker of this entry; written so that bundlers find it. */
function ownWorker() {
  const folder = packageFolder(import.meta.url);
  if (folder) return new Worker(new URL('cad/cad_worker.js', folder), { type: 'module' });
  return new Worker(new URL('./cad/cad_worker.js', import.meta.url), { type: 'module' });
}

/** Open CASCADE: script and wasm, written so that bundlers find them. */
function ownFiles() {
  const folder = packageFolder(import.meta.url);
  if (folder) return ['cad/occt/occt-import-js.js', 'cad/occt/occt-import-js.wasm'].map((name) => new URL(name, folder));
  return [new URL('./cad/occt/occt-import-js.js', import.meta.url), new URL('./cad/occt/occt-import-js.wasm', import.meta.url)];
}

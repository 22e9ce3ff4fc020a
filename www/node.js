/**
 * The package in Node: the same interface on the calling thread. The GPU backend needs the npm package `webgpu` to be
 * installed, too; without it, or without an adapter, `backend: 'auto'` meshes on the CPU.
 */
import { readFile } from 'node:fs/promises';
import { availableParallelism } from 'node:os';
import { Worker } from 'node:worker_threads';

import { HexcastError } from './protocol/error.js';
import { MOST_THREADS, checked, start } from './start.js';

export { HexcastError, formats, version } from './hexcast.js';

const NO_GPU = 'Node has no GPU of its own and the npm package webgpu is not installed';

/** @type {typeof import('./hexcast.js').createMesher} */
export async function createMesher(given) {
  const options = checked(given);
  const { backend, device } = options;
  const wasm = await bytesOf(options.wasm);
  const threads = options.threads ?? (wasm === undefined ? Math.min(availableParallelism(), MOST_THREADS) : undefined);
  const local = { ...options, wasm, threads, worker: /** @type {const} */ (false) };
  const gpu = backend === 'cpu' ? null : await findGpu();
  if (backend === 'cpu' || gpu || device) return start(local, gpu, core);
  if (backend === 'gpu') throw new HexcastError('no-adapter', NO_GPU, { hint: 'install webgpu, or use the CPU backend' });
  return Object.assign(await start({ ...local, backend: 'cpu' }, gpu, core), { fallback: NO_GPU });
}

/** Reads the wasm from its file, which `fetch` does not. @param {import('./hexcast.js').WasmSource} [wasm] */
async function bytesOf(wasm) {
  const isFile = (typeof wasm === 'string' || wasm instanceof URL) && String(wasm).startsWith('file:');
  return isFile ? readFile(new URL(wasm)) : wasm;
}

/** A core on this thread, which may wait for others here. @type {import('./start.js').LocalCore} */
async function core(hasThreads) {
  const glue = hasThreads ? import('./hexcast_threads.js') : import('./hexcast_wasm.js');
  const file = hasThreads ? new URL('./hexcast_threads_bg.wasm', import.meta.url) : new URL('./hexcast_bg.wasm', import.meta.url);
  const [{ Core }, loaded, source] = await Promise.all([import('./core/core.js'), glue, bytesOf(file)]);
  return {
    core: new Core(loaded),
    source: /** @type {Uint8Array<ArrayBuffer>} */ (source),
    startThread,
  };
}

/** A thread of this program, which all meshers share. @type {import('./start.js').StartThread} */
async function startThread(shared) {
  const worker = new Worker(new URL('./platform/node_thread.js', import.meta.url), { workerData: shared });
  const answer = await new Promise((resolve, reject) => worker.once('message', resolve).once('error', reject));
  // the program ends although it waits for work
  worker.unref();
  return answer;
}

/** The GPU of this Node, or of the package `webgpu`; null if there is none. No global is set. @returns {Promise<GPU | null>} */
async function findGpu() {
  if (globalThis.navigator?.gpu) return navigator.gpu;
  try {
    // bundlers leave it: it may not be installed
    const { create } = await import(/* webpackIgnore: true */ /* turbopackIgnore: true */ /* @vite-ignore */ 'webgpu');
    return create([]);
  } catch {
    return null;
  }
}

/**
 * The package in Node: the same interface on the calling thread. The GPU backend needs the npm package `webgpu` to be
 * installed, too; without it, or without an adapter, `backend: 'auto'` meshes on the CPU.
 */
import { readFile } from 'node:fs/promises';

import { HexcastError } from './protocol/error.js';
import { checked, start } from './start.js';

export { HexcastError, formats, version } from './hexcast.js';

const NO_GPU = 'Node has no GPU of its own and the npm package webgpu is not installed';

/** @type {typeof import('./hexcast.js').createMesher} */
export async function createMesher(given) {
  const options = checked(given);
  const { backend, device } = options;
  const local = { ...options, wasm: await wasmOf(options.wasm), worker: /** @type {const} */ (false) };
  const gpu = backend === 'cpu' ? null : await findGpu();
  if (backend === 'cpu' || gpu || device) return start(local, gpu);
  if (backend === 'gpu') throw new HexcastError('no-adapter', NO_GPU, { hint: 'install webgpu, or use the CPU backend' });
  return Object.assign(await start({ ...local, backend: 'cpu' }, gpu), { fallback: NO_GPU });
}

/** Reads the wasm from its file, which `fetch` does not. @param {import('./hexcast.js').WasmSource} [wasm] */
async function wasmOf(wasm = new URL('./hexcast_bg.wasm', import.meta.url)) {
  const isFile = (typeof wasm === 'string' || wasm instanceof URL) && String(wasm).startsWith('file:');
  return isFile ? readFile(new URL(wasm)) : wasm;
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

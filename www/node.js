/**
 * The package in Node: the same interface on the calling thread. The GPU backend needs the npm package `webgpu` to be
 * installed, too; without it, or without an adapter, `backend: 'auto'` meshes on the CPU.
 */
import { readFile } from 'node:fs/promises';

import { HexcastError } from './error.js';
import { MESHER, optionsOf } from './check.js';
import { createMesher as create } from './hexcast.js';

export { HexcastError, version } from './hexcast.js';

const NO_GPU = 'Node has no GPU of its own and the npm package webgpu is not installed';

/** @type {typeof import('./hexcast.js').createMesher} */
export async function createMesher(given) {
  const options = optionsOf(given, MESHER);
  const { backend = 'auto' } = options;
  const wasm = options.wasm ?? (await readFile(new URL('./hexcast_bg.wasm', import.meta.url)));
  if (backend === 'cpu' || (await provideGpu())) return create({ ...options, wasm, worker: false });
  if (backend === 'gpu') throw new HexcastError('no-adapter', NO_GPU, { hint: 'install webgpu, or use the CPU backend' });
  const mesher = await create({ ...options, backend: 'cpu', wasm, worker: false });
  return Object.assign(mesher, { fallback: NO_GPU });
}

/** Puts `navigator.gpu` where the wasm looks for it, if the package `webgpu` is installed; false if there is none. */
async function provideGpu() {
  if (globalThis.navigator?.gpu) return true;
  let webgpu;
  try {
    webgpu = await import('webgpu');
  } catch {
    return false;
  }
  Object.assign(globalThis, webgpu.globals);
  if (!globalThis.navigator) Object.defineProperty(globalThis, 'navigator', { value: {}, configurable: true, writable: true });
  Object.defineProperty(globalThis.navigator, 'gpu', { value: webgpu.create([]), configurable: true });
  // the wasm asks whether it runs in a window or in a worker before it looks for the GPU
  globalThis.WorkerGlobalScope ??= globalThis.constructor ?? class {};
  return true;
}

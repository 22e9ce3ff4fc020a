/**
 * The package in Node: the same interface on the calling thread. The GPU backend needs the npm package `webgpu` beside this
 * one; without it, or without an adapter, `backend: 'auto'` meshes on the CPU.
 */
import { readFile } from 'node:fs/promises';

import { createMesher as create } from './hexcast.js';

export { HexcastError, version } from './hexcast.js';

export async function createMesher(options = {}) {
  if (options.backend !== 'cpu') await provideGpu();
  const wasm = options.wasm ?? (await readFile(new URL('./hexcast_bg.wasm', import.meta.url)));
  return create({ ...options, wasm, worker: false });
}

/** Puts `navigator.gpu` where the wasm looks for it, if the package `webgpu` is installed. */
async function provideGpu() {
  if (globalThis.navigator?.gpu) return;
  let webgpu;
  try {
    webgpu = await import('webgpu');
  } catch {
    return;
  }
  Object.assign(globalThis, webgpu.globals);
  if (!globalThis.navigator) Object.defineProperty(globalThis, 'navigator', { value: {}, configurable: true, writable: true });
  Object.defineProperty(globalThis.navigator, 'gpu', { value: webgpu.create([]), configurable: true });
  // the wasm asks whether it runs in a window or in a worker before it looks for the GPU
  globalThis.WorkerGlobalScope ??= globalThis.constructor ?? class {};
}

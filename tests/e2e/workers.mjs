// Pages whose worker meets misfortune: no adapter, a device that is lost, and one that cannot be opened again.

import { appendFileSync, cpSync, mkdtempSync, readdirSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';

import { DIST } from '../../scripts/build.mjs';
import { serve } from '../../scripts/serve.mjs';

/** A worker without an adapter. */
export const WITHOUT_ADAPTER = "Object.defineProperty(navigator, 'gpu', { value: { requestAdapter: async () => null } });";

/**
 * Serves the page and the package with workers that do something else, too: workers have a navigator and devices of their own.
 *
 * @param {string} code runs in the worker after its own script
 * @returns {Promise<{url: string, close: () => Promise<void>}>}
 */
export async function serveWithWorker(code) {
  const root = mkdtempSync(path.join(tmpdir(), 'hexcast-'));
  cpSync(DIST, root, { recursive: true });
  const ofPage = readdirSync(path.join(root, 'assets')).filter((name) => /^worker-.*\.js$/.test(name));
  if (ofPage.length !== 1) throw new Error(`the page has ${ofPage.length} workers`);
  for (const file of ['worker.js', path.join('assets', ofPage[0])]) appendFileSync(path.join(root, file), `\n{\n${code}\n}\n`);
  const server = await serve({ root });
  const close = async () => {
    await server.close();
    rmSync(root, { recursive: true });
  };
  return { url: server.url, close };
}

/**
 * Has the worker's adapter tell something else of itself.
 *
 * @param {Partial<GPUAdapterInfo>} info nothing of what it leaves out
 */
export function tellOfAdapter(info) {
  const told = { vendor: '', architecture: '', description: '', isFallbackAdapter: false, ...info };
  return `
  for (const [key, value] of Object.entries(${JSON.stringify(told)})) {
    Object.defineProperty(GPUAdapterInfo.prototype, key, { get: () => value, configurable: true });
  }
`;
}

/** So that the software adapters of the tests pass for one of hardware, which `auto` takes. */
export const AS_HARDWARE = tellOfAdapter({ description: 'a GPU' });

/**
 * Destroys the worker's first device once it has been given a few bands, and tells how many devices are asked for.
 *
 * @param {number} n_devices that it may open; the browser has no adapter for more
 * @param {boolean} is_told whether the browser ever tells the worker that the device was lost
 */
export function loseFirstDevice(n_devices = Infinity, is_told = true) {
  return `
  const told = new BroadcastChannel('devices');
  const { gpu } = navigator;
  const find = gpu.requestAdapter.bind(gpu);
  let n_devices = 0;
  gpu.requestAdapter = async (...options) => (n_devices < ${n_devices} ? find(...options) : null);
  const open = GPUAdapter.prototype.requestDevice;
  GPUAdapter.prototype.requestDevice = async function (...options) {
    const device = await open.apply(this, options);
    n_devices += 1;
    if (n_devices === 1) {
      const { queue } = device;
      const submit = queue.submit.bind(queue);
      let n_submits = 0;
      queue.submit = (commands) => {
        submit(commands);
        n_submits += 1;
        if (n_submits === 4) device.destroy();
      };
      device.lost.then(({ reason }) => told.postMessage({ reason }));
      if (!${is_told}) Object.defineProperty(device, 'lost', { value: new Promise(() => {}) });
    }
    told.postMessage({ n_devices });
    return device;
  };
`;
}

/** Destroys the worker's device whenever the page says so, and counts the devices. */
export const DESTROY_ON_DEMAND = `
  const open = GPUAdapter.prototype.requestDevice;
  const told = new BroadcastChannel('devices');
  let device = null;
  let n_devices = 0;
  GPUAdapter.prototype.requestDevice = async function (...options) {
    device = await open.apply(this, options);
    n_devices += 1;
    return device;
  };
  told.onmessage = async ({ data }) => {
    // the page's own worker hears it, too
    if (data !== 'destroy' || !device) return;
    device.destroy();
    const { reason } = await device.lost;
    told.postMessage({ reason, n_devices });
  };
`;

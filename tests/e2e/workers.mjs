// Pages whose worker meets misfortune: no adapter, a device that is lost, and one that cannot be opened again.

import { mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';

import { DIST } from '../../scripts/build.mjs';
import { serve } from '../../scripts/serve.mjs';

/** Serves the page with a worker that first does something else: workers have a navigator and devices of their own. */
export async function withWorker(code, visit) {
  const folder = mkdtempSync(path.join(tmpdir(), 'hexcast-'));
  writeFileSync(path.join(folder, 'worker.js'), `${readFileSync(path.join(DIST, 'worker.js'), 'utf8')}\n${code}\n`);
  const server = await serve({ roots: [folder, DIST] });
  try {
    await visit(server.url);
  } finally {
    await server.close();
    rmSync(folder, { recursive: true });
  }
}

/**
 * Destroys the worker's first device once it has been given a few bands, and tells how many devices are asked for.
 *
 * @param {number} n_devices that it may open; the browser has no adapter for more
 */
export function loseFirstDevice(n_devices = Infinity) {
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
    }
    told.postMessage({ n_devices });
    return device;
  };
`;
}

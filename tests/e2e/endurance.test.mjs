// What a long visit takes: many meshes without growth, and a device that is lost again and again.

import assert from 'node:assert/strict';

import { knotText } from './samples.mjs';
import { test } from './visit.mjs';
import { DESTROY_ON_DEMAND } from './workers.mjs';

/** In the page: bytes of the wasm's memory after 20 meshes and after 200, which are kept or not. */
async function growth([knot, isKept]) {
  const { createMesher } = await import(new URL('hexcast.js', location.href).href);
  const { default: init } = await import(new URL('hexcast_wasm.js', location.href).href);
  const mesher = await createMesher({ backend: 'cpu', worker: false });
  const source = new File([Uint8Array.from(knot, (letter) => letter.charCodeAt(0))], 'knot.stl');
  const surface = await mesher.read(source);
  const { memory } = await init();
  const bytes = [];
  for (let n = 1; n <= 200; n += 1) {
    const mesh = await mesher.mesh({ geometries: [{ source: surface }], cells: 60 });
    await mesh.slice(2, 9);
    await mesh.skin();
    if (!isKept) mesh.dispose();
    if (n === 20 || n === 200) bytes.push(memory.buffer.byteLength);
  }
  return bytes;
}

test('200 meshes in a row do not grow the memory', async ({ visit }) => {
  const knot = await knotText();
  const page = await visit('');
  const [after20, after200] = await page.evaluate(growth, [knot, false]);
  assert.equal(after200, after20);
  // meshes that are kept do
  const other = await visit('');
  const kept = await other.evaluate(growth, [knot, true]);
  assert.ok(kept[1] > kept[0] + 1e6, `${kept}`);
});

/** In the page: meshes, destroys the device, and so on; the hashes, and what was told of the devices. */
async function loseDevices([knot, n_losses]) {
  const { createMesher } = await import(new URL('hexcast.js', location.href).href);
  const source = new File([Uint8Array.from(knot, (letter) => letter.charCodeAt(0))], 'knot.stl');
  const devices = new BroadcastChannel('devices');
  const destroy = () =>
    new Promise((resolve) => {
      devices.onmessage = ({ data }) => data.reason && resolve(data);
      devices.postMessage('destroy');
    });
  const mesher = await createMesher({ backend: 'gpu', worker: new URL('worker.js', location.href) });
  const hashes = [];
  const told = [];
  for (let n = 0; n <= n_losses; n += 1) {
    const mesh = await mesher.mesh({ geometries: [{ source }], cells: 30 });
    hashes.push(mesh.report.flags_hash);
    mesh.dispose();
    if (n < n_losses) told.push(await destroy());
  }
  return { hashes, told, backend: mesher.backend };
}

test('a device that is destroyed 20 times is opened again 20 times, with the same cells', async ({ visit, siteWithWorker }) => {
  // where the driver is the processor, its kernels are compiled for some seconds each time
  test.setTimeout(600_000);
  const page = await visit('#backend=cpu', { url: await siteWithWorker(DESTROY_ON_DEMAND) });
  const { hashes, told, backend } = await page.evaluate(loseDevices, [await knotText(), 20]);
  assert.equal(backend, 'gpu');
  assert.equal(hashes.length, 21);
  assert.deepEqual(new Set(hashes).size, 1);
  assert.deepEqual(
    told,
    Array.from({ length: 20 }, (_, n) => ({ reason: 'destroyed', n_devices: n + 1 })),
  );
});

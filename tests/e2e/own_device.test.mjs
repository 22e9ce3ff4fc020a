// Devices of the caller's own: each mesher keeps to its own, and errors and handlers that are the caller's stay the caller's.

import assert from 'node:assert/strict';

import { test } from './visit.mjs';

/** In the page: two meshers on two devices, with errors of the page's own on one of them before, while and after it meshes. */
async function meshOnTwoDevices() {
  const { createMesher } = await import(new URL('hexcast.js', location.href).href);
  const corners = [0, 0, 0, 0, 7, 0, 9, 0, 0, 0, 0, 0, 9, 0, 0, 0, 0, 5, 0, 0, 0, 0, 0, 5, 0, 7, 0, 9, 0, 0, 0, 7, 0, 0, 0, 5];
  const job = { geometries: [{ source: Float32Array.from(corners), file: 'tetrahedron' }], dims: [64, 96, 32] };
  const adapter = () => navigator.gpu.requestAdapter();
  const devices = [await (await adapter()).requestDevice(), await (await adapter()).requestDevice()];
  const n_submits = [0, 0];
  for (const [at, { queue }] of devices.entries()) {
    const { submit } = GPUQueue.prototype;
    queue.submit = (...args) => {
      n_submits[at] += 1;
      return submit.apply(queue, args);
    };
  }
  const heard = [];
  const onError = (event) => {
    event.preventDefault();
    heard.push(event.error.message.length > 0);
  };
  devices[0].onuncapturederror = onError;
  const gpu = navigator.gpu;
  const before = Object.getOwnPropertyNames(globalThis);
  const meshers = await Promise.all(devices.map((device) => createMesher({ device })));
  // more than a buffer can have
  const fail = () => devices[0].createBuffer({ size: 2 ** 50, usage: GPUBufferUsage.STORAGE });
  fail();
  devices[0].pushErrorScope('validation');
  const hashes = [];
  const used = [];
  for (const [at, mesher] of meshers.entries()) {
    n_submits.fill(0);
    const onProgress = () => at === 0 && fail();
    const mesh = await mesher.mesh(job, { onProgress });
    const { backend, warnings } = mesh.report;
    hashes.push([backend, warnings, await mesh.sha256()]);
    used.push(n_submits.map((n) => n > 0));
  }
  const scoped = await devices[0].popErrorScope();
  fail();
  const again = await meshers[0].mesh(job);
  hashes.push([again.report.backend, again.report.warnings, await again.sha256()]);
  const isMine = devices[0].onuncapturederror === onError && navigator.gpu === gpu;
  for (const mesher of meshers) mesher.dispose();
  const isOpen = await Promise.race([devices[0].lost.then(() => false), new Promise((resolve) => setTimeout(resolve, 50, true))]);
  const cpu = await createMesher({ backend: 'cpu' });
  const expected = await (await cpu.mesh(job)).sha256();
  cpu.dispose();
  const added = Object.getOwnPropertyNames(globalThis).filter((name) => !before.includes(name));
  return { hashes, expected, used, heard, scoped: scoped !== null, isMine, isOpen, added };
}

test("two meshers keep to their devices, and the caller's errors, scopes and handlers stay the caller's", async ({ visit }) => {
  const page = await visit('');
  const { hashes, expected, used, heard, scoped, isMine, isOpen, added } = await page.evaluate(meshOnTwoDevices);
  assert.deepEqual(hashes, Array(3).fill(['gpu', [], expected]));
  assert.deepEqual(used, [
    [true, false],
    [false, true],
  ]);
  // those within the page's own scope go there
  assert.deepEqual(heard, [true, true]);
  assert.ok(scoped, 'the scope of the page received its error');
  assert.ok(isMine, 'handler and navigator.gpu are what they were');
  assert.ok(isOpen, "the caller's device is not destroyed");
  assert.deepEqual(added, []);
});

/** In the page: what is no device, or none any more. */
async function openWrongDevices() {
  const { createMesher } = await import(new URL('hexcast.js', location.href).href);
  const lost = await (await navigator.gpu.requestAdapter()).requestDevice();
  lost.destroy();
  const told = (options) =>
    createMesher(options).then(
      ({ backend }) => backend,
      ({ code, message }) => `${code}: ${message}`,
    );
  const wrong = [];
  for (const device of [{}, null, 5, navigator.gpu]) wrong.push(await told({ device }));
  return { wrong, lost: await told({ device: lost, backend: 'gpu' }) };
}

test('what is no device is refused, and one that is lost fails', async ({ visit }) => {
  const page = await visit('');
  const { wrong, lost } = await page.evaluate(openWrongDevices);
  assert.equal(wrong.length, 4);
  for (const told of wrong) assert.match(told, /^job-value: device is .*; allowed: a GPUDevice$/);
  assert.match(lost, /^device-lost: /);
});

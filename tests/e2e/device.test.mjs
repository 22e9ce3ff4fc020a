// No adapter, a device of the caller's own, a device that is lost: the same mesh, and the page says who made it.

import assert from 'node:assert/strict';

import { hasGeometries, legend, run, test } from './visit.mjs';
import { AS_HARDWARE, WITHOUT_ADAPTER, loseFirstDevice, tellOfAdapter } from './workers.mjs';

test('without an adapter the processor does the same work, and the page says so', async ({ visit, siteWithWorker }) => {
  const page = await visit('#cells=20&sample=cubes', { url: await siteWithWorker(WITHOUT_ADAPTER) });
  await hasGeometries(page, 2);
  assert.equal(await page.getAttribute('#device', 'data-backend'), 'cpu');
  assert.match(await page.textContent('#device'), /No GPU/);
  await run(page);
  assert.deepEqual(await legend(page), [
    [1, 1000],
    [2, 500],
  ]);
});

test('where the only adapter computes on the processor the CPU meshes, and the page and the report say why', async ({
  visit,
}) => {
  const page = await visit('#cells=20&sample=cubes');
  await hasGeometries(page, 2);
  const why = 'the only GPU adapter, SwiftShader, computes on the processor, where the CPU backend is faster';
  assert.equal(await page.getAttribute('#device', 'data-backend'), 'cpu');
  assert.match(await page.textContent('#device'), /No GPU/);
  assert.equal(await page.getAttribute('#device', 'title'), why);
  await run(page);
  assert.deepEqual(await legend(page), [
    [1, 1000],
    [2, 500],
  ]);
  assert.equal(await page.textContent('#result-backend'), 'the processor');
  const { fallback, warnings } = JSON.parse(await page.textContent('#report'));
  assert.deepEqual({ fallback, warnings }, { fallback: why, warnings: [] });
});

/** Meshers for `auto` and for the GPU, in a page. */
async function openBoth() {
  const { createMesher } = await import(new URL('hexcast.js', location.href).href);
  const open = async (backend) => {
    const mesher = await createMesher({ backend });
    const facts = { backend: mesher.backend, fallback: mesher.fallback, software: mesher.adapter?.software ?? null };
    mesher.dispose();
    return facts;
  };
  return [await open('auto'), await open('gpu')];
}

const SLOW = 'computes on the processor, where the CPU backend is faster';
for (const [what, info, fallback] of [
  [
    'SwiftShader by its architecture',
    { vendor: 'google', architecture: 'swiftshader' },
    `the only GPU adapter, SwiftShader, ${SLOW}`,
  ],
  ['llvmpipe by its description', { description: 'llvmpipe (LLVM 19.1, 256 bits)' }, `the only GPU adapter, llvmpipe, ${SLOW}`],
  ['another fallback adapter', { vendor: 'x', isFallbackAdapter: true }, `the only GPU adapter, x, ${SLOW}`],
  ['one without a name', { isFallbackAdapter: true }, `the only GPU adapter ${SLOW}`],
  ['one of hardware', { vendor: 'nvidia', architecture: 'hopper' }, null],
]) {
  test(`auto and gpu, where the adapter is ${what}`, async ({ visit, siteWithWorker }) => {
    const page = await visit('#backend=cpu', { url: await siteWithWorker(tellOfAdapter(info)) });
    const [auto, gpu] = await page.evaluate(openBoth);
    const isSoftware = fallback !== null;
    assert.deepEqual(gpu, { backend: 'gpu', fallback: null, software: isSoftware });
    assert.deepEqual(auto, isSoftware ? { backend: 'cpu', fallback, software: null } : gpu);
  });
}

test('the page and the report name the GPU as the browser does', async ({ visit }) => {
  const page = await visit('#cells=20&sample=cubes&backend=gpu');
  await hasGeometries(page, 2);
  const name = await page.evaluate(async () => {
    const { vendor, architecture, description } = (await navigator.gpu.requestAdapter({ powerPreference: 'high-performance' }))
      .info;
    return description || `${vendor} ${architecture}`.trim();
  });
  assert.notEqual(name, '');
  assert.ok((await page.textContent('#device')).includes(name), await page.textContent('#device'));
  await run(page);
  assert.equal(await page.textContent('#result-backend'), name);
  assert.equal(JSON.parse(await page.textContent('#report')).adapter, name);
});

/** Where the page hears what its worker tells of devices. */
function hearOfDevices() {
  window.told = [];
  new BroadcastChannel('devices').onmessage = ({ data }) => window.told.push(data);
}

/** The SHA-256 of all flags, as the page shows it. */
async function hashOf(page) {
  await page.click('#results summary:text-is("Report")');
  await page.click('#hash');
  await page.waitForFunction(() => document.querySelector('#result-hash').textContent.length === 64, null, { timeout: 120_000 });
  return page.textContent('#result-hash');
}

/** A job of many bands. */
const LONG_JOB = '#dims=16 2000 1000&axis=x&sample=knot';

/** The hash of that job, made on the processor. */
async function hashOnProcessor(visit) {
  const page = await visit(`${LONG_JOB}&backend=cpu`);
  await hasGeometries(page, 1);
  await run(page);
  return hashOf(page);
}

test('a device that is lost while the page meshes costs no cell', async ({ visit, siteWithWorker }) => {
  const url = await siteWithWorker(loseFirstDevice());
  const page = await visit(`${LONG_JOB}&backend=gpu`, { url, prepare: hearOfDevices });
  await hasGeometries(page, 1);
  await run(page);
  const told = await page.evaluate(() => window.told);
  const losses = told.filter(({ reason }) => reason);
  assert.deepEqual(losses, [{ reason: 'destroyed' }], 'the device was lost');
  const isReopened = told.some(({ n_devices }) => n_devices === 2);
  assert.ok(isReopened, 'and another one opened');
  assert.equal(await page.getAttribute('#device', 'data-backend'), 'gpu');
  assert.equal(await page.textContent('#messages'), '');
  assert.equal(await hashOf(page), await hashOnProcessor(visit));
});

test('where no other device can be opened the processor goes on, and the page says so', async ({ visit, siteWithWorker }) => {
  const page = await visit(LONG_JOB, { url: await siteWithWorker(AS_HARDWARE + loseFirstDevice(1)), prepare: hearOfDevices });
  await hasGeometries(page, 1);
  assert.equal(await page.getAttribute('#device', 'data-backend'), 'gpu');
  await run(page);
  const losses = (await page.evaluate(() => window.told)).filter(({ reason }) => reason);
  assert.deepEqual(losses, [{ reason: 'destroyed' }]);
  assert.equal(await page.getAttribute('#device', 'data-backend'), 'cpu');
  const findings = await page.textContent('#finding-list p');
  assert.match(findings, /^Meshed on the CPU: the GPU device was lost .*; opening it again: /);
  assert.equal(await page.textContent('#result-backend'), 'the processor');
  assert.equal(await page.textContent('#messages'), '');
  const hash = await hashOf(page);
  // and stays there
  await run(page);
  assert.equal(await page.getAttribute('#device', 'data-backend'), 'cpu');
  assert.equal(hash, await hashOnProcessor(visit));
});

test('where the GPU was asked for, its loss for good is a sentence, and another try is offered', async ({
  visit,
  siteWithWorker,
}) => {
  const page = await visit(`${LONG_JOB}&backend=gpu`, { url: await siteWithWorker(loseFirstDevice(1)) });
  await hasGeometries(page, 1);
  await page.click('#run');
  await page.waitForSelector('#messages [role=alert]', { timeout: 120_000 });
  assert.equal(await page.getAttribute('#messages [role=alert]', 'data-code'), 'device-lost');
  assert.match(await page.textContent('#messages [role=alert]'), /was lost .* opening it again: .*Open the GPU again/s);
});

/** Meshes on a device of the page's own, which is destroyed after the first band; and on the processor. */
async function meshOnOwnDevice(cornersOf) {
  const { createMesher } = await import(new URL('hexcast.js', location.href).href);
  const source = Float32Array.from(cornersOf);
  const job = { geometries: [{ source, file: 'tetrahedron' }], dims: [1024, 2048, 8], axis: 'z' };
  const hashOn = async (options, onProgress) => {
    const mesher = await createMesher(options);
    const mesh = await mesher.mesh(job, { onProgress });
    const facts = { backend: mesher.backend, adapter: mesher.adapter, sha256: await mesh.sha256() };
    mesher.dispose();
    return facts;
  };
  const own = await (await navigator.gpu.requestAdapter()).requestDevice();
  const before = navigator.gpu;
  let n_opened = 0;
  const open = GPUAdapter.prototype.requestDevice;
  GPUAdapter.prototype.requestDevice = function (...options) {
    n_opened += 1;
    return open.apply(this, options);
  };
  const intact = await hashOn({ device: own });
  const n_forIntact = n_opened;
  const done = [];
  const lost = await hashOn({ device: own }, ({ stage, done: rays }) => {
    if (stage !== 'mesh') return;
    if (done.length === 0) own.destroy();
    done.push(rays);
  });
  const refused = [];
  for (const options of [
    { device: own, backend: 'cpu' },
    { device: own, worker: 'worker.js' },
  ]) {
    await createMesher(options).catch(({ code }) => refused.push(code));
  }
  const cpu = await hashOn({ backend: 'cpu' });
  const { reason } = await own.lost;
  return { intact, lost, cpu, n_forIntact, n_opened, done, refused, reason, isBack: navigator.gpu === before };
}

test("a device of the caller's own is meshed on, and one of the mesher's where it is destroyed", async ({ visit }) => {
  const page = await visit('');
  const tetrahedron = [
    [0, 0, 0],
    [9, 0, 0],
    [0, 7, 0],
    [0, 0, 5],
  ];
  const corners = [
    [0, 2, 1],
    [0, 1, 3],
    [0, 3, 2],
    [1, 2, 3],
  ].flatMap((facet) => facet.flatMap((corner) => tetrahedron[corner]));
  const found = await page.evaluate(meshOnOwnDevice, corners);
  assert.deepEqual([found.intact.backend, found.lost.backend, found.cpu.backend], ['gpu', 'gpu', 'cpu']);
  assert.equal(found.n_forIntact, 0, 'no other device was opened');
  assert.equal(found.reason, 'destroyed');
  assert.equal(found.n_opened, 1, 'the mesher opened one of its own');
  assert.ok(found.isBack, 'navigator.gpu is what it was');
  assert.notEqual(found.intact.adapter.name, '');
  assert.equal(found.cpu.adapter, null);
  assert.deepEqual(found.refused, ['job-conflict', 'job-conflict']);
  assert.ok(
    found.done.length > 4 && found.done.every((rays, at) => at === 0 || rays > found.done[at - 1]),
    `bands in order: ${found.done}`,
  );
  assert.equal(found.lost.sha256, found.cpu.sha256);
  assert.equal(found.intact.sha256, found.cpu.sha256);
});

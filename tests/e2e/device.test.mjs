// No adapter, a device of the caller's own, a device that is lost: the same mesh, and the page says who made it.

import assert from 'node:assert/strict';
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { test } from 'node:test';

import { DIST } from '../../scripts/build.mjs';
import { serve } from '../../scripts/serve.mjs';
import { LIMIT, hasGeometries, isIdle, legend, run, site, useSite, withPage } from './visit.mjs';

useSite();

/** Serves the page with a worker that first does something else: workers have a navigator and devices of their own. */
async function withWorker(code, visit) {
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

test('without an adapter the processor does the same work, and the page says so', LIMIT, () =>
  withWorker("Object.defineProperty(navigator, 'gpu', { value: { requestAdapter: async () => null } });", async (url) => {
    const page = await site.browser.newPage();
    try {
      await page.goto(`${url}#cells=20&sample=cubes`);
      await isIdle(page);
      await hasGeometries(page, 2);
      assert.equal(await page.getAttribute('#device', 'data-backend'), 'cpu');
      assert.match(await page.textContent('#device'), /No GPU/);
      await run(page);
      assert.deepEqual(await legend(page), [[1, 1000], [2, 500]]);
    } finally {
      await page.close();
    }
  }),
);

test('the page and the report name the GPU as the browser does', LIMIT, () =>
  withPage('#cells=20&sample=cubes', async (page) => {
    await hasGeometries(page, 2);
    const name = await page.evaluate(async () => {
      const { vendor, architecture, description } = (await navigator.gpu.requestAdapter({ powerPreference: 'high-performance' })).info;
      return description || `${vendor} ${architecture}`.trim();
    });
    assert.notEqual(name, '');
    assert.ok((await page.textContent('#device')).includes(name), await page.textContent('#device'));
    await run(page);
    assert.equal(await page.textContent('#result-backend'), name);
    assert.equal(JSON.parse(await page.textContent('#report')).adapter, name);
  }),
);

/** Destroys the worker's first device once it has been given a few bands, and tells how many devices it opens. */
const LOSE_FIRST_DEVICE = `
  const told = new BroadcastChannel('devices');
  const open = GPUAdapter.prototype.requestDevice;
  let n_devices = 0;
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

test('a device that is lost while the page meshes costs no cell', LIMIT, () =>
  withWorker(LOSE_FIRST_DEVICE, async (url) => {
    const prepare = () => {
      window.told = [];
      new BroadcastChannel('devices').onmessage = ({ data }) => window.told.push(data);
    };
    const hash = async (page) => {
      await page.click('#results summary');
      await page.click('#hash');
      await page.waitForFunction(() => document.querySelector('#result-hash').textContent.length === 64, null, { timeout: 120_000 });
      return page.textContent('#result-hash');
    };
    const job = '#dims=16 2000 1000&axis=x&sample=knot';
    const hashes = [];
    await withPage(job, async (page) => {
      await hasGeometries(page, 1);
      await run(page);
      const told = await page.evaluate(() => window.told);
      assert.deepEqual(told.filter(({ reason }) => reason), [{ reason: 'destroyed' }], 'the device was lost');
      assert.ok(told.some(({ n_devices }) => n_devices === 2), 'and another one opened');
      assert.equal(await page.getAttribute('#device', 'data-backend'), 'gpu');
      assert.equal(await page.textContent('#messages'), '');
      hashes.push(await hash(page));
    }, { url, prepare });
    await withPage(`${job}&backend=cpu`, async (page) => {
      await hasGeometries(page, 1);
      await run(page);
      hashes.push(await hash(page));
    });
    assert.equal(hashes[0], hashes[1]);
  }),
);

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
  const conflicts = [];
  for (const options of [{ device: own, backend: 'cpu' }, { device: own, worker: 'worker.js' }]) {
    await createMesher(options).catch(({ code }) => conflicts.push(code));
  }
  const cpu = await hashOn({ backend: 'cpu' });
  const { reason } = await own.lost;
  return { intact, lost, cpu, n_forIntact, n_opened, done, conflicts, reason, isBack: navigator.gpu === before };
}

test("a device of the caller's own is meshed on, and one of the mesher's where it is destroyed", LIMIT, () =>
  withPage('', async (page) => {
    const tetrahedron = [[0, 0, 0], [9, 0, 0], [0, 7, 0], [0, 0, 5]];
    const corners = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]].flatMap((facet) => facet.flatMap((corner) => tetrahedron[corner]));
    const found = await page.evaluate(meshOnOwnDevice, corners);
    assert.deepEqual([found.intact.backend, found.lost.backend, found.cpu.backend], ['gpu', 'gpu', 'cpu']);
    assert.equal(found.n_forIntact, 0, 'no other device was opened');
    assert.equal(found.reason, 'destroyed');
    assert.equal(found.n_opened, 1, 'the mesher opened one of its own');
    assert.ok(found.isBack, 'navigator.gpu is what it was');
    assert.notEqual(found.intact.adapter.name, '');
    assert.equal(found.cpu.adapter, null);
    assert.deepEqual(found.conflicts, ['job-conflict', 'job-conflict']);
    assert.ok(found.done.length > 4 && found.done.every((rays, at) => at === 0 || rays > found.done[at - 1]), `bands in order: ${found.done}`);
    assert.equal(found.lost.sha256, found.cpu.sha256);
    assert.equal(found.intact.sha256, found.cpu.sha256);
  }),
);

// The package's contract of calls, in a page: meshes wait for each other, aborts are heeded at once and lose nothing.

import assert from 'node:assert/strict';

import { knotText } from './samples.mjs';
import { test } from './visit.mjs';

/** Runs a function, given as text, in the page with the package and a sample's file. */
async function inPage(page, act) {
  const source = `async (knot) => {
    const { createMesher } = await import(new URL('hexcast.js', location.href).href);
    const source = new File([Uint8Array.from(knot, (letter) => letter.charCodeAt(0))], 'knot.stl');
    return (${act})(createMesher, source);
  }`;
  return page.evaluate(`(${source})(${JSON.stringify(await knotText())})`);
}

for (const worker of [true, false]) {
  const where = worker ? 'in a worker' : 'on the calling thread';

  test(`meshes asked for at once are made one after the other, ${where}`, async ({ visit }) => {
    const page = await visit('');
    const found = await inPage(
      page,
      `async (createMesher, source) => {
        const mesher = await createMesher({ backend: 'cpu', worker: ${worker ? 'undefined' : 'false'} });
        const job = (cells) => ({ geometries: [{ source }], cells });
        const meshes = await Promise.all([mesher.mesh(job(300)), mesher.mesh(job(40)), mesher.mesh(job(40))]);
        const hashes = await Promise.all(meshes.slice(1).map((mesh) => mesh.sha256()));
        return { dims: meshes.map((mesh) => Math.max(...mesh.dims)), hashes };
      }`,
    );
    assert.deepEqual(found.dims, [300, 40, 40]);
    assert.equal(found.hashes[0], found.hashes[1]);
  });

  test(`an aborted mesh rejects with the reason while the core is busy, and the next one is made, ${where}`, async ({
    visit,
  }) => {
    const page = await visit('');
    const found = await inPage(
      page,
      `async (createMesher, source) => {
        const mesher = await createMesher({ backend: 'cpu', worker: ${worker ? 'undefined' : 'false'} });
        const stop = new AbortController();
        const events = [];
        const onProgress = ({ stage }) => stage === 'mesh' && events.push(0) === 3 && stop.abort('enough');
        const big = mesher.mesh({ geometries: [{ source }], cells: 3000 }, { signal: stop.signal, onProgress });
        const waiting = mesher.mesh({ geometries: [{ source }], cells: 3000 }, { signal: stop.signal });
        const reasons = await Promise.all([big, waiting].map((call) => call.catch((reason) => reason)));
        const n_told = events.length;
        const mesh = await mesher.mesh({ geometries: [{ source }], cells: 30 });
        return { reasons, cells: mesh.report.cells, n_late: events.length - n_told, dims: mesh.dims };
      }`,
    );
    assert.deepEqual(found.reasons, ['enough', 'enough']);
    assert.equal(found.n_late, 0, 'who gave up hears no more');
    assert.equal(Math.max(...found.dims), 30);
  });
}

test("a Worker of the caller's, and a function that starts one, mesh; where onProgress throws the call rejects with that", async ({
  visit,
}) => {
  const page = await visit('');
  const found = await inPage(
    page,
    `async (createMesher, source) => {
      const start = () => new Worker(new URL('worker.js', location.href), { type: 'module' });
      const n_started = [];
      const count = () => n_started.push(0) && start();
      const found = [];
      for (const worker of [start(), count, count]) {
        const mesher = await createMesher({ backend: 'cpu', worker });
        const job = { geometries: [{ source }], cells: 60 };
        const fail = () => { throw new TypeError('mine'); };
        const problem = await mesher.mesh(job, { onProgress: fail }).catch(({ name, code, message, cause }) => [name, code, message, String(cause)]);
        const mesh = await mesher.mesh(job);
        found.push({ problem, cells: Math.max(...mesh.dims) });
        mesher.dispose();
      }
      return { found, n_started: n_started.length };
    }`,
  );
  const problem = ['HexcastError', 'callback', 'onProgress threw: mine', 'TypeError: mine'];
  assert.deepEqual(found, { found: Array(3).fill({ problem, cells: 60 }), n_started: 2 });
});

test('compressed files are smaller, and read back', async ({ visit }) => {
  const page = await visit('');
  const found = await inPage(
    page,
    `async (createMesher, source) => {
      const mesher = await createMesher({ backend: 'cpu', worker: false });
      const mesh = await mesher.mesh({ geometries: [{ source }], cells: 60 });
      const plain = (await mesh.blob('vti', { compress: 0 })).size;
      const sizes = await Promise.all([1, 6, 9].map(async (compress) => (await mesh.blob('vti', { compress })).size));
      const again = await mesher.open(await mesh.blob('hxc', { compress: 6 }));
      return { sizes, dims: [again.dims, mesh.dims], plain };
    }`,
  );
  assert.ok(
    found.sizes.every((size) => size < found.plain / 4),
    `${found.sizes} of ${found.plain}`,
  );
  assert.deepEqual(found.dims[0], found.dims[1]);
});

test('a compressed file is made a slab at a time: others are answered meanwhile, and an abort ends it', async ({ visit }) => {
  const page = await visit('');
  const found = await inPage(
    page,
    `async (createMesher, source) => {
      const mesher = await createMesher({ backend: 'cpu' });
      const mesh = await mesher.mesh({ geometries: [{ source }], cells: 400 });
      const stop = new AbortController();
      const shares = [];
      const asked = [];
      const onProgress = ({ done, total }) => {
        shares.push(done / total);
        if (shares.length === 2) asked.push(mesh.slice(2, 7));
        if (shares.length === 4) stop.abort('enough');
      };
      const reason = await mesh.blob('vti', { compress: 6, signal: stop.signal, onProgress }).catch((reason) => reason);
      const [slice] = await Promise.all(asked);
      const whole = await mesh.blob('vti', { compress: 1 });
      return { reason, shares, width: slice.width, nx: mesh.dims[0], bytes: whole.size };
    }`,
  );
  assert.equal(found.reason, 'enough');
  assert.equal(found.shares.length, 4, `${found.shares}`);
  assert.ok(found.shares.at(-1) < 1, `${found.shares}`);
  assert.equal(found.width, found.nx);
  assert.ok(found.bytes > 1000);
});

test('a GPU keeps to the bytes that it may have, with the same cells; fewer than it can do with are refused by the key', async ({
  visit,
}) => {
  const page = await visit('#backend=cpu');
  const found = await inPage(
    page,
    `async (createMesher, source) => {
      const mesher = await createMesher({ backend: 'gpu' });
      const make = async (options) => (await mesher.mesh({ geometries: [{ source }], cells: 200 }, options)).report;
      const reports = [await make(), await make({ maxDeviceBytes: 2 << 20 })];
      const wrong = [0, NaN, 1e6, '4MB', Infinity].map((maxDeviceBytes) => make({ maxDeviceBytes }).catch(({ code, details }) => [code, details.key]));
      return { bytes: reports.map(({ peak_bytes }) => peak_bytes.device), hashes: reports.map(({ flags_hash }) => flags_hash), wrong: await Promise.all(wrong) };
    }`,
  );
  assert.equal(found.hashes[0], found.hashes[1]);
  assert.ok(found.bytes[0] > 2 << 20 && found.bytes[1] <= 2 << 20 && found.bytes[1] > 0, `${found.bytes}`);
  assert.deepEqual(found.wrong, Array(5).fill(['job-value', 'maxDeviceBytes']));
});

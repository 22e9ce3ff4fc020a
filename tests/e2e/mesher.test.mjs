// The package's contract of calls, in a page: meshes wait for each other, aborts are heeded at once and lose nothing.

import assert from 'node:assert/strict';
import { test } from 'node:test';

import { LIMIT, useSite, withPage } from './visit.mjs';

useSite();

/** Runs a function in the page with the package and a sample's file. */
function inPage(page, act) {
  const source = `(async () => {
    const { createMesher } = await import(new URL('hexcast.js', location.href).href);
    const { sampleFiles } = await import(new URL('page/samples.js', location.href).href);
    const [{ source }] = sampleFiles('knot');
    return (${act})(createMesher, source);
  })()`;
  return page.evaluate(source);
}

for (const worker of [true, false]) {
  const where = worker ? 'in a worker' : 'on the calling thread';

  test(`meshes asked for at once are made one after the other, ${where}`, LIMIT, () =>
    withPage('', async (page) => {
      const found = await inPage(page, `async (createMesher, source) => {
        const mesher = await createMesher({ backend: 'cpu', worker: ${worker ? 'undefined' : 'false'} });
        const job = (cells) => ({ geometries: [{ source }], cells });
        const meshes = await Promise.all([mesher.mesh(job(300)), mesher.mesh(job(40)), mesher.mesh(job(40))]);
        const hashes = await Promise.all(meshes.slice(1).map((mesh) => mesh.sha256()));
        return { dims: meshes.map((mesh) => Math.max(...mesh.dims)), hashes };
      }`);
      assert.deepEqual(found.dims, [300, 40, 40]);
      assert.equal(found.hashes[0], found.hashes[1]);
    }),
  );

  test(`an aborted mesh rejects with the reason while the core is busy, and the next one is made, ${where}`, LIMIT, () =>
    withPage('', async (page) => {
      const found = await inPage(page, `async (createMesher, source) => {
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
      }`);
      assert.deepEqual(found.reasons, ['enough', 'enough']);
      assert.equal(found.n_late, 0, 'who gave up hears no more');
      assert.equal(Math.max(...found.dims), 30);
    }),
  );
}

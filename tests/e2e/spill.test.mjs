// Columns that outgrow the memory allowed: in both browsers they go to the private file system, and leave nothing there.

import assert from 'node:assert/strict';

import { complaintsOf, openChromium, openFirefox } from './browsers.mjs';
import { knotText } from './samples.mjs';
import { test } from './visit.mjs';

/** In the page: meshes in memory and with columns that spill, on one backend; returns the results and the files that remain. */
async function meshSpilling({ backend, knot }) {
  const { createMesher } = await import(new URL('hexcast.js', location.href).href);
  const source = Uint8Array.from(knot, (letter) => letter.charCodeAt(0));
  const files = async () => {
    const root = await navigator.storage.getDirectory();
    const names = [];
    for await (const name of (await root.getDirectoryHandle('hexcast-columns', { create: true })).keys()) names.push(name);
    return names.length;
  };
  const untilGone = async () => {
    for (const end = performance.now() + 20_000; (await files()) > 0 && performance.now() < end; )
      await new Promise((resolve) => setTimeout(resolve, 20));
    return files();
  };
  const bytesOf = async (mesh) => {
    const hash = await crypto.subtle.digest('SHA-256', await (await mesh.blob('hxc')).arrayBuffer());
    return [...new Uint8Array(hash), await mesh.sha256(), await mesh.flag(8, 700, 300)].join();
  };
  const job = { geometries: [{ source }], dims: [16, 2000, 1000], axis: 'x' };
  // the buffers of a software GPU lie in the same memory
  const tight = { ...job, max_memory: backend === 'gpu' ? '27MB' : '8MB' };
  const code = (made) =>
    made.then(
      () => 'meshed',
      (error) => error.code ?? error,
    );

  // what an earlier visit left is gone with the next one
  const folder = await (await navigator.storage.getDirectory()).getDirectoryHandle('hexcast-columns', { create: true });
  await folder.getFileHandle('left behind', { create: true });
  const mesher = await createMesher({ backend });
  const atStart = await untilGone();
  const held = await mesher.mesh(job);
  const facts = { backend: mesher.backend, held: await bytesOf(held), spilledOfHeld: held.report.peak_bytes.spilled, atStart };
  facts.refused = await code(mesher.mesh(tight, { spill: false }));
  facts.none = await files();
  const spilled = [await mesher.mesh(tight), await mesher.mesh(tight, { spill: true })];
  facts.files = await files();
  facts.spilledBytes = spilled.map((mesh) => mesh.report.peak_bytes.spilled);
  facts.memory = [held.columns.bytes, ...spilled.map((mesh) => mesh.columns.bytes)];
  facts.spilled = [await bytesOf(spilled[0]), await bytesOf(spilled[1])];
  for (const mesh of spilled) mesh.dispose();
  facts.afterMeshes = await untilGone();
  const stop = new AbortController();
  const abort = ({ stage }) => stage === 'mesh' && stop.abort('enough');
  facts.aborted = await code(mesher.mesh(tight, { spill: true, signal: stop.signal, onProgress: abort }));
  facts.afterAbort = await untilGone();
  await mesher.mesh(tight);
  facts.again = await files();
  mesher.dispose();
  facts.afterMesher = await untilGone();
  const here = await createMesher({ backend, worker: false });
  facts.here = [
    await code(here.mesh(tight)),
    await code(here.mesh(job, { spill: true })),
    await code(here.mesh(job, { spill: 'yes' })),
  ];
  here.dispose();
  return facts;
}

for (const [name, open] of Object.entries({ Chromium: openChromium, Firefox: openFirefox })) {
  test(`columns spill in ${name}, read back the same, and no file is left`, async ({ site: ofOneThread, isolatedSite }) => {
    const knot = await knotText();
    const browser = await open();
    try {
      for (const [backend, site] of [
        ['cpu', ofOneThread],
        ['gpu', ofOneThread],
        ['cpu', isolatedSite],
      ]) {
        const page = await browser.newPage();
        const complaints = complaintsOf(page, site);
        await page.goto(site);
        const { held, memory, spilledBytes, ...found } = await page.evaluate(meshSpilling, { backend, knot });
        assert.ok(
          spilledBytes.every((bytes) => bytes > 1e6) && memory[1] < memory[0] / 10,
          `${spilledBytes} bytes spilled, ${memory} in memory`,
        );
        const expected = {
          backend,
          spilledOfHeld: 0,
          atStart: 0,
          refused: 'memory',
          none: 0,
          files: 2,
          spilled: [held, held],
          afterMeshes: 0,
          aborted: 'enough',
          afterAbort: 0,
          again: 1,
          afterMesher: 0,
          here: ['memory', 'io', 'job-value'],
        };
        assert.deepEqual(found, expected);
        assert.deepEqual(complaints, []);
        await page.close();
      }
    } finally {
      await browser.close();
    }
  });
}

/** In the page: the hash of a mesh whose columns spill, or its error. */
async function hashSpilled(knot) {
  const { createMesher } = await import(new URL('hexcast.js', location.href).href);
  const source = Uint8Array.from(knot, (letter) => letter.charCodeAt(0));
  const mesher = await createMesher({ backend: 'cpu' });
  const job = { geometries: [{ source }], dims: [16, 1000, 1000], axis: 'x', max_memory: '5MB' };
  const found = await mesher.mesh(job).then(
    (mesh) => mesh.sha256(),
    ({ code, message }) => ({ code, message }),
  );
  mesher.dispose();
  return found;
}

const WHOLE = '';
const IN_PARTS = `for (const name of ['read', 'write']) {
  const whole = FileSystemSyncAccessHandle.prototype[name];
  FileSystemSyncAccessHandle.prototype[name] = function (bytes, options) { return whole.call(this, bytes.subarray(0, 1000), options); };
}`;
const FULL = "FileSystemSyncAccessHandle.prototype.write = () => { throw new DOMException('no room', 'QuotaExceededError'); };";

test('a file system that takes and gives bytes in parts will do, and one that is full is a sentence', async ({
  browser,
  siteWithWorker,
}) => {
  const found = [];
  for (const code of [WHOLE, IN_PARTS, FULL]) {
    const page = await browser.newPage();
    await page.goto(await siteWithWorker(code));
    found.push(await page.evaluate(hashSpilled, await knotText()));
    await page.close();
  }
  const [whole, inParts, full] = found;
  assert.equal(whole.length, 64);
  assert.equal(inParts, whole);
  assert.equal(full.code, 'io');
  assert.match(full.message, /writing columns to the disk: .*"no room"; make room on the disk/);
});

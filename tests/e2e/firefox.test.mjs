// The main way through the page in Firefox, whose WebGPU is another implementation (naga, on lavapipe).

import assert from 'node:assert/strict';

import { knotText } from './samples.mjs';
import { test } from './visit.mjs';
import { AS_HARDWARE, loseFirstDevice } from './workers.mjs';

test('Firefox meshes two touching blocks, as Chromium does', async ({ firefox, site }) => {
  const page = await firefox.newPage();
  await page.goto(`${site}#cells=20&sample=cubes&backend=gpu`);
  await page.waitForSelector('.geometry:nth-child(2)', { timeout: 120_000 });
  console.log(`${await page.$eval('#device', (element) => element.textContent)} (Firefox)`);
  // without a click
  await page.waitForSelector('#legend tr', { timeout: 180_000 });
  const cells = await page.$$eval('#legend .cells', (entries) => entries.map((entry) => Number(entry.dataset.cells)));
  assert.deepEqual(cells, [1000, 500]);
  assert.equal(await page.$eval('#messages', (element) => element.textContent), '');
});

/** In the page: meshes with a worker that loses its device, and on the processor. */
async function meshAndLose(knot) {
  const { createMesher } = await import(new URL('hexcast.js', location.href).href);
  const source = Uint8Array.from(knot, (letter) => letter.charCodeAt(0));
  const found = [];
  for (const backend of ['auto', 'cpu']) {
    const mesher = await createMesher({ backend });
    const before = mesher.backend;
    const mesh = await mesher.mesh({ geometries: [{ source }], dims: [16, 2000, 1000], axis: 'x' });
    found.push({
      backends: [before, mesher.backend, mesh.report.backend],
      warnings: mesh.report.warnings,
      sha256: await mesh.sha256(),
    });
    mesher.dispose();
  }
  return found;
}

for (const [what, n_devices, backend, is_told] of [
  ['another is opened', Infinity, 'gpu', true],
  ['another is opened, though nobody is told', Infinity, 'gpu', false],
  ['the processor goes on', 1, 'cpu', true],
]) {
  test(`where Firefox loses its device ${what}, with the same result`, async ({ firefox, siteWithWorker }) => {
    const page = await firefox.newPage();
    await page.goto(await siteWithWorker(AS_HARDWARE + loseFirstDevice(n_devices, is_told)));
    const [lost, cpu] = await page.evaluate(meshAndLose, await knotText());
    assert.deepEqual(lost.backends, ['gpu', backend, backend]);
    assert.equal(lost.warnings.length, backend === 'cpu' ? 1 : 0);
    assert.ok(
      lost.warnings.every((warning) => /meshed on the CPU: the GPU device was lost/.test(warning)),
      `${lost.warnings}`,
    );
    assert.equal(lost.sha256, cpu.sha256);
  });
}

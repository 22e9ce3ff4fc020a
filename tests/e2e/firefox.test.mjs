// The main way through the page in Firefox, whose WebGPU is another implementation (naga, on lavapipe).

import assert from 'node:assert/strict';
import { test } from 'node:test';

import { serve } from '../../scripts/serve.mjs';
import { openFirefox } from './browsers.mjs';
import { loseFirstDevice, withWorker } from './workers.mjs';

test('Firefox meshes two touching blocks, as Chromium does', { timeout: 240_000 }, async (context) => {
  const server = await serve();
  const browser = await openFirefox();
  try {
    const page = await browser.newPage();
    await page.goto(`${server.url}#cells=20&sample=cubes`);
    await page.waitForSelector('.geometry:nth-child(2)', { timeout: 120_000 });
    await page.waitForSelector('#run:enabled');
    context.diagnostic(`${await page.$eval('#device', (element) => element.textContent)} (Firefox)`);
    await page.$eval('#run', (button) => button.click());
    await page.waitForSelector('#legend tr', { timeout: 180_000 });
    const cells = await page.$$eval('#legend .cells', (entries) => entries.map((entry) => Number(entry.dataset.cells)));
    assert.deepEqual(cells, [1000, 500]);
    assert.equal(await page.$eval('#messages', (element) => element.textContent), '');
  } finally {
    await browser.close();
    await server.close();
  }
});

/** In the page: meshes with a worker that loses its device, and on the processor. */
async function meshAndLose() {
  const { createMesher } = await import(new URL('hexcast.js', location.href).href);
  const { sampleFiles } = await import(new URL('page/samples.js', location.href).href);
  const [{ source }] = sampleFiles('knot');
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

for (const [what, n_devices, backend] of [
  ['another is opened', Infinity, 'gpu'],
  ['the processor goes on', 1, 'cpu'],
]) {
  test(`where Firefox loses its device ${what}, with the same result`, { timeout: 240_000 }, () =>
    withWorker(loseFirstDevice(n_devices), async (url) => {
      const browser = await openFirefox();
      try {
        const page = await browser.newPage();
        await page.goto(url);
        const [lost, cpu] = await page.evaluate(meshAndLose);
        assert.deepEqual(lost.backends, ['gpu', backend, backend]);
        assert.equal(lost.warnings.length, backend === 'cpu' ? 1 : 0);
        assert.ok(
          lost.warnings.every((warning) => /meshed on the CPU: the GPU device was lost/.test(warning)),
          `${lost.warnings}`,
        );
        assert.equal(lost.sha256, cpu.sha256);
      } finally {
        await browser.close();
      }
    }),
  );
}

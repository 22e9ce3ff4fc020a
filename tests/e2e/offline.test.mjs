// Once loaded the page needs no network.

import assert from 'node:assert/strict';
import { readdirSync } from 'node:fs';
import path from 'node:path';

import { DIST } from '../../scripts/build.mjs';
import { serve } from '../../scripts/serve.mjs';
import { isIdle, legend, saved, test } from './visit.mjs';

/** In the page: waits until the service worker has kept these paths. */
async function isKept(paths) {
  const cache = await caches.open('hexcast');
  for (;;) {
    const kept = new Set((await cache.keys()).map(({ url }) => new URL(url).pathname));
    if (paths.every((path) => kept.has(path))) return;
    await new Promise((resolve) => setTimeout(resolve, 100));
  }
}

test('once loaded the page works without a network', async ({ browser }) => {
  const own = await serve({ base: '/' });
  const context = await browser.newContext();
  try {
    const page = await context.newPage();
    await page.goto(own.url);
    await isIdle(page);
    // offline one thread does, and no file of CAD is read
    const assets = readdirSync(path.join(DIST, 'assets')).filter((name) => !/threads.*\.wasm$|^occt$/.test(name));
    // the page, its style, the 3-D view, a worker, a core for this thread, the wasm
    assert.ok(assets.length >= 6, `${assets}`);
    await page.evaluate(isKept, ['/', ...assets.map((name) => `/assets/${name}`)]);
    await own.close();
    await page.goto(`${own.url}#cells=20&sample=cubes&backend=gpu`);
    await page.reload();
    await isIdle(page);
    // without a click
    await page.waitForSelector('#legend tr', { timeout: 180_000 });
    assert.deepEqual(await legend(page), [
      [1, 1000],
      [2, 500],
    ]);
    // no test can answer the dialogue for a place
    await page.evaluate(() => delete window.showSaveFilePicker);
    const { bytes } = await saved(page, '#download-vtiz');
    assert.match(bytes.toString('latin1'), /vtkZLibDataCompressor[\s\S]*<\/VTKFile>/);
  } finally {
    await context.close();
    await own.close().catch(() => {});
  }
});

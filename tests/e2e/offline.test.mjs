// Once loaded the page needs no network.

import assert from 'node:assert/strict';
import { test } from 'node:test';

import { serve } from '../../scripts/serve.mjs';
import { LIMIT, hasGeometries, isIdle, legend, run, saved, site, useSite } from './visit.mjs';

useSite();

test('once loaded the page works without a network', LIMIT, async () => {
  const own = await serve({ base: '/' });
  const context = await site.browser.newContext();
  try {
    const page = await context.newPage();
    await page.goto(own.url);
    await isIdle(page);
    const isKept = async () => {
      const cache = await caches.open('hexcast');
      for (;;) {
        const kept = (await cache.keys()).map(({ url }) => new URL(url).pathname);
        if (['/', '/hexcast_bg.wasm', '/worker.js', '/core.js', '/vendor/three.module.js', '/page/scene.js'].every((file) => kept.includes(file))) return;
        await new Promise((resolve) => setTimeout(resolve, 100));
      }
    };
    await page.evaluate(isKept);
    await own.close();
    await page.goto(`${own.url}#cells=20&sample=cubes`);
    await page.reload();
    await isIdle(page);
    await hasGeometries(page, 2);
    await run(page);
    assert.deepEqual(await legend(page), [[1, 1000], [2, 500]]);
    // compressed, which takes the second wasm; no test can answer the dialogue for a place
    await page.evaluate(() => delete window.showSaveFilePicker);
    const { bytes } = await saved(page, '#download-vtiz');
    assert.match(bytes.toString('latin1'), /vtkZLibDataCompressor[^]*<\/VTKFile>/);
  } finally {
    await context.close();
    await own.close().catch(() => {});
  }
});

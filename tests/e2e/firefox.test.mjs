// The main way through the page in Firefox, whose WebGPU is another implementation (naga, on lavapipe).

import assert from 'node:assert/strict';
import { test } from 'node:test';

import { serve } from '../../scripts/serve.mjs';
import { openFirefox } from './browsers.mjs';

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

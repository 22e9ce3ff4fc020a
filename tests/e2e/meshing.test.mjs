// From a sample to a mesh that can be looked at, in Chromium: slices, 3-D, priorities, either backend.

import assert from 'node:assert/strict';

import { expect } from '@playwright/test';

import { cellsAreDrawn, COPPER, EPOXY, hasGeometries, legend, picture3d, run, slice, take, test } from './visit.mjs';

test('two touching blocks: every cell of two slices has its colour', async ({ visit }) => {
  const page = await visit('#cells=20&backend=gpu');
  await take(page, 'cubes', 2);
  assert.deepEqual(await page.$$eval('[id^=dims-]', (inputs) => inputs.map((input) => input.value)), ['20', '10', '10']);
  await run(page);
  assert.deepEqual(await legend(page), [
    [1, 1000],
    [2, 500],
  ]);
  const row = (right) => Array.from({ length: 20 }, (_, i) => (i < 10 ? COPPER : right));
  assert.deepEqual(await slice(page, 'z', 2), Array(10).fill(row(EPOXY)));
  assert.deepEqual(await slice(page, 'z', 7), Array(10).fill(row(null)));
  assert.deepEqual(
    await slice(page, 'x', 15),
    Array.from({ length: 10 }, (_, k) => Array(10).fill(k < 5 ? EPOXY : null)),
  );
});

test('arrow keys move the slice', async ({ visit }) => {
  const page = await visit('#cells=20&sample=cubes&backend=gpu');
  await hasGeometries(page, 2);
  await run(page);
  await slice(page, 'z', 4);
  await page.focus('#canvas-z');
  await page.keyboard.press('ArrowUp');
  await page.waitForFunction(() => document.querySelector('#canvas-z').dataset.index === '5');
  assert.equal((await slice(page, 'z', 5))[0][15], null);
  await page.keyboard.press('Home');
});

test('with the keyboard the cursor leads a slice that is zoomed, which pans after it', async ({ visit }) => {
  const page = await visit('#cells=20&sample=cubes&backend=cpu');
  await hasGeometries(page, 2);
  await run(page);
  await slice(page, 'z', 4);
  await page.focus('#canvas-z');
  const where = () =>
    page.$eval('#canvas-z', ({ dataset, width, height }) => ({
      ...Object.fromEntries(['left', 'top', 'scaleX', 'scaleY', 'zoom', 'height'].map((key) => [key, Number(dataset[key])])),
      canvas: [width, height],
    }));
  for (let n = 0; n < 4; n += 1) await page.keyboard.press('+');
  await expect.poll(async () => (await where()).zoom).toBeGreaterThan(5);
  const before = await where();
  // from the middle to the corner
  for (let n = 0; n < 9; n += 1) await page.keyboard.press('Shift+ArrowRight');
  for (let n = 0; n < 5; n += 1) await page.keyboard.press('Shift+ArrowUp');
  await expect(page.locator('#readout')).toHaveText(/^cell 19, 9, 4 at /);
  // cell 19, 9 is the last of the row at the top; it is drawn in the frame after the text names it
  const isSeen = async () => {
    const { left, top, scaleX, scaleY, canvas } = await where();
    const [x, y] = [left + 19.5 * scaleX, top + 0.5 * scaleY];
    return (x > 0 && x < canvas[0] && y > 0 && y < canvas[1]) || `the cursor is at ${x}, ${y} of ${canvas}`;
  };
  await expect.poll(isSeen).toBe(true);
  const { left, top } = await where();
  assert.ok(left < before.left && top > before.top, `${[before.left, before.top]} became ${[left, top]}`);
  const corner = [before.left + 19.5 * before.scaleX, before.top + 0.5 * before.scaleY];
  assert.ok(corner[0] > before.canvas[0] || corner[1] < 0, `${corner} was in view before`);
});

test('the model, the cells and a section are drawn in 3-D', async ({ visit }) => {
  const page = await visit('#cells=32&backend=gpu');
  await take(page, 'shells', 2);
  const counts = [await coloursIn3d(page)];
  await run(page);
  await cellsAreDrawn(page);
  counts.push(await coloursIn3d(page));
  await page.selectOption('#section-axis', '0');
  await page.waitForFunction(() => !document.querySelector('#section-at').disabled);
  await page.waitForTimeout(500);
  counts.push(await coloursIn3d(page));
  for (const { n_colours, share } of counts) {
    assert.ok(n_colours > 20, `${n_colours} colours`);
    assert.ok(share > 0.05 && share < 0.9, `${share} of the picture is drawn on`);
  }
  // the section shows the core, in its own colour and unlit
  assert.ok(counts[2].exact > 0.005, `${counts[2].exact} of the picture is the core`);
  assert.equal(counts[1].exact, 0);
});

/** Number of colours, share of pixels that are drawn on, and share in the second flag's very colour, of the saved picture. */
async function coloursIn3d(page) {
  await page.waitForTimeout(500);
  return page.evaluate(
    ({ data }) => {
      const pixels = new Uint32Array(data.buffer);
      const isDrawn = pixels.filter((pixel) => pixel >>> 24 > 0);
      const near = (pixel) => [0x3a, 0x8f, 0xc9].every((part, at) => Math.abs(((pixel >>> (8 * at)) & 255) - part) <= 1);
      return {
        n_colours: new Set(pixels).size,
        share: isDrawn.length / pixels.length,
        exact: isDrawn.filter(near).length / pixels.length,
      };
    },
    await picture3d(page),
  );
}

test('where two geometries overlap the higher priority wins', async ({ visit }) => {
  const page = await visit('#cells=20&backend=gpu');
  await take(page, 'shells', 2);
  await run(page);
  assert.equal((await slice(page, 'z', 10))[10][10], EPOXY);
  await page.fill('.geometry[data-file="core.stl"] .priority', '-1');
  await run(page);
  assert.equal((await slice(page, 'z', 10))[10][10], COPPER);
  assert.equal(new Map(await legend(page)).get(2) ?? 0, 0);
  assert.equal(await page.locator('#finding-list [data-kind=no-cell-covered]').count(), 1);
});

test('the processor does the work where it is asked to', async ({ visit }) => {
  const page = await visit('#cells=20&sample=cubes&backend=cpu');
  await hasGeometries(page, 2);
  assert.equal(await page.getAttribute('#device', 'data-backend'), 'cpu');
  await run(page);
  assert.deepEqual(await legend(page), [
    [1, 1000],
    [2, 500],
  ]);
});

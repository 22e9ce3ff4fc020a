// `<hexcast-viewer>` on a plain page: it draws a column file without the wasm, and is small.

import assert from 'node:assert/strict';
import { readFileSync, statSync } from 'node:fs';

import { expect, test } from '@playwright/test';

import { DIST } from '../../scripts/build.mjs';

/** Bytes that the package promises. */
const MOST_BYTES = 60_000;
const MESH = readFileSync('tests/fixtures/columns.hxc');
const PAGE = '<!doctype html><title>A plain page</title><script type="module" src="viewer.js"></script>';

/** A page with the element. */
async function open(page, attributes, mesh = MESH) {
  await page.route('http://plain.test/**', (route) => {
    const { pathname } = new URL(route.request().url());
    if (pathname === '/viewer.js')
      return route.fulfill({ contentType: 'text/javascript', body: readFileSync(`${DIST}/viewer.js`) });
    if (pathname === '/mesh.hxc') return route.fulfill({ body: mesh });
    return route.fulfill({
      contentType: 'text/html',
      body: `${PAGE}<hexcast-viewer src="mesh.hxc" ${attributes}></hexcast-viewer>`,
    });
  });
  await page.goto('http://plain.test/');
}

const whole = (page) => expect(page.locator('hexcast-viewer')).toHaveAttribute('data-drawn', 'whole');

/** Pixels of the element that have a colour: the frame of what has the focus has none. */
async function drawn(page) {
  await whole(page);
  const png = (await page.locator('hexcast-viewer').screenshot({ path: process.env.VIEWER_PICTURE })).toString('base64');
  return page.evaluate(async (png) => {
    const bitmap = await createImageBitmap(await (await fetch(`data:image/png;base64,${png}`)).blob());
    const context = new OffscreenCanvas(bitmap.width, bitmap.height).getContext('2d');
    context.drawImage(bitmap, 0, 0);
    const { data } = context.getImageData(0, 0, bitmap.width, bitmap.height);
    const pixels = Array.from({ length: data.length / 4 }, (_, at) => [...data.subarray(4 * at, 4 * at + 3)]);
    return pixels.filter((pixel) => Math.max(...pixel) - Math.min(...pixel) > 20);
  }, png);
}

test('it is at most 60 kB', () => {
  const { size } = statSync(`${DIST}/viewer.js`);
  assert.ok(size <= MOST_BYTES, `${size} bytes`);
});

test('it shows the cells in the colour of their flag, and none that are hidden or cut away', async ({ page }) => {
  await open(page, '');
  const pixels = await drawn(page);
  assert.ok(pixels.length > 2000, `${pixels.length} pixels`);
  // flag 7 is #e83458: whatever the light, red is the most and green the least
  const right = pixels.filter(([red, green, blue]) => red > blue && blue > green);
  assert.ok(right.length > 0.98 * pixels.length, `${right.length} of ${pixels.length} pixels are red`);
  const picture = page.getByRole('img', { name: 'Mesh of 7 x 12 x 12 cells' });
  await picture.focus();
  await page.keyboard.press('-');
  await expect.poll(async () => (await drawn(page)).length).toBeLessThan(0.8 * pixels.length);
  await page.locator('hexcast-viewer').evaluate((viewer) => viewer.setAttribute('cut', 'z -0.6'));
  await expect.poll(async () => (await drawn(page)).length).toBeLessThan(0.3 * pixels.length);
  await page.locator('hexcast-viewer').evaluate((viewer) => viewer.setAttribute('hidden-flags', '7'));
  await expect.poll(async () => (await drawn(page)).length).toBe(0);
});

test('a file that is not whole is said', async ({ page }) => {
  await open(page, '', MESH.subarray(0, MESH.length - 200));
  await expect(page.getByRole('status')).toHaveText(/^mesh\.hxc: the file ends before its cells do/);
});

for (const [at, said] of [
  [60, 'the head of the file is damaged'],
  [MESH.indexOf('BAND') + 50, 'the file is damaged after byte'],
]) {
  test(`a file with another byte at ${at} is damaged`, async ({ page }) => {
    const mesh = Buffer.from(MESH);
    mesh[at] ^= 1;
    await open(page, '', mesh);
    await expect(page.getByRole('status')).toHaveText(new RegExp(`^mesh\\.hxc: ${said}`));
  });
}

// What people do on the page, for the tests: open it, take a sample, make the mesh, look at slices, save files.

import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { after, before } from 'node:test';

import { serve } from '../../scripts/serve.mjs';
import { complaintsOf, openChromium } from './browsers.mjs';

export const COPPER = '#d98324';
export const EPOXY = '#3a8fc9';
export const LIMIT = { timeout: 240_000 };
/** Chromium's remark where WebGL is drawn on the processor: it says nothing about the page. */
const DRIVER_REMARK = /GL Driver Message \(OpenGL, Performance/;

/** Chromium and a server for the tests of a file: `url` is where the page lives. */
export const site = { browser: null, url: null };

/** Starts both before the tests of a file and ends them after. */
export function useSite() {
  let server;
  before(async () => {
    server = await serve({ base: '/below/a/path/' });
    site.url = server.url;
    // three.js draws on the processor here
    site.browser = await openChromium(['--enable-unsafe-swiftshader']);
  });
  after(async () => {
    await site.browser?.close();
    await server?.close();
  });
}

/**
 * Opens the page with parameters and hands it over once it is ready; nothing may be complained about.
 *
 * @param {string} hash
 * @param {(page: import('playwright-core').Page) => Promise<void>} visit
 * @param {{url?: string, prepare?: () => void}} [options] another server's page; a script that runs before the page's
 */
export async function withPage(hash, visit, { url = site.url, prepare = withoutPicker } = {}) {
  const context = await site.browser.newContext({ acceptDownloads: true });
  await context.addInitScript(prepare);
  const page = await context.newPage();
  const complaints = complaintsOf(page, url);
  try {
    await page.goto(url + hash);
    await isIdle(page);
    await visit(page);
    assert.deepEqual(
      complaints.filter((complaint) => !DRIVER_REMARK.test(complaint)),
      [],
    );
  } finally {
    await context.close();
  }
}

/** The dialogue for a place to save is the browser's own: no test can answer it. */
function withoutPicker() {
  delete window.showSaveFilePicker;
}

export function isIdle(page) {
  return page.waitForFunction(() => document.body.dataset.phase === 'idle', null, { timeout: 120_000 });
}

export async function take(page, sample, n_files) {
  await page.click(`#empty [data-sample=${sample}]`);
  await hasGeometries(page, n_files);
}

export async function hasGeometries(page, n_files) {
  await page.waitForFunction((n) => document.querySelectorAll('.geometry').length === n, n_files);
  await isIdle(page);
  await page.waitForSelector('#run:enabled');
}

/** Makes the mesh and waits until the page shows that one. */
export async function run(page) {
  await page.evaluate(() => document.querySelector('#legend').replaceChildren());
  await page.click('#run');
  await page.waitForSelector('#legend tr', { timeout: 180_000 });
}

/** Cells of each flag as the legend has them. */
export function legend(page) {
  return page.$$eval('#legend tr', (rows) =>
    rows.map((row) => [Number(row.dataset.flag), Number(row.querySelector('.cells').dataset.cells)]),
  );
}

/** Shows a slice and reads the colour in the middle of every cell: `[j][i]`, `null` for the background. */
export async function slice(page, axis, index) {
  await page.click('#tab-slices');
  await page.check(`#slice-${axis}`);
  await page.fill('#slice-number', String(index));
  const isThere = ([axis, index]) => {
    const { dataset } = document.querySelector('#canvas-slice');
    return dataset.axis === axis && dataset.index === String(index);
  };
  await page.waitForFunction(isThere, [axis, index]);
  return page.$eval('#canvas-slice', (canvas) => {
    const [left, top, dx, dy, width, height] = ['left', 'top', 'scaleX', 'scaleY', 'width', 'height'].map((key) =>
      Number(canvas.dataset[key]),
    );
    const background = getComputedStyle(canvas).getPropertyValue('--cells-background').trim();
    const copy = new OffscreenCanvas(canvas.width, canvas.height).getContext('2d', { willReadFrequently: true });
    copy.drawImage(canvas, 0, 0);
    const { data } = copy.getImageData(0, 0, canvas.width, canvas.height);
    const colour = (x, y) =>
      `#${[...data.slice(4 * (x + canvas.width * y), 4 * (x + canvas.width * y) + 3)].map((part) => part.toString(16).padStart(2, '0')).join('')}`;
    return Array.from({ length: height }, (_, j) =>
      Array.from({ length: width }, (_, i) => {
        const found = colour(Math.floor(left + (i + 0.5) * dx), Math.floor(top + (height - j - 0.5) * dy));
        return found === background ? null : found;
      }),
    );
  });
}

/** Clicks and returns the bytes that the browser saved. */
export async function saved(page, selector) {
  const [download] = await Promise.all([page.waitForEvent('download'), page.click(selector)]);
  return { name: download.suggestedFilename(), bytes: readFileSync(await download.path()) };
}

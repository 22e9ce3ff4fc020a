// What people do on the page, for the tests: open it, take a sample, make the mesh, look at slices, save files.

import assert from 'node:assert/strict';
import { mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';

import { test as base } from '@playwright/test';

import { serve } from '../../scripts/serve.mjs';
import { ISOLATED } from '../../vite.config.mjs';
import { complaintsOf, meshByClick, openFirefox } from './browsers.mjs';
import { serveWithWorker } from './workers.mjs';

export const COPPER = '#d98324';
export const EPOXY = '#3a8fc9';
/** Chromium's remark where WebGL is drawn on the processor: it says nothing about the page. */
const DRIVER_REMARK = /GL Driver Message \(OpenGL, Performance/;

/**
 * A test of the page. Its fixtures:
 *
 * - `site`: where the page is;
 * - `visit(hash, { url, prepare, live })`: opens the page with parameters, in a context of its own, and resolves to it once it is
 *   ready. `url` is that of another server's page, `prepare` a script that runs before the page's. Only a `live` page meshes without a click. Where the page complains of
 *   anything until the test ends, the test fails;
 * - `isolatedSite`: where it is with the headers that let its workers share memory;
 * - `siteWithWorker(code)`: where a page is whose worker runs this code, too;
 * - `folder`: an empty folder, which goes with the test;
 * - `firefox`: a Puppeteer browser.
 */
export const test = base.extend({
  site: [
    // biome-ignore lint/correctness/noEmptyPattern: Playwright reads from the pattern what a fixture needs
    async ({}, use) => {
      const server = await serve({ base: '/below/a/path/' });
      await use(server.url);
      await server.close();
    },
    { scope: 'worker' },
  ],

  isolatedSite: [
    // biome-ignore lint/correctness/noEmptyPattern: as above
    async ({}, use) => {
      const server = await serve({ headers: ISOLATED });
      await use(server.url);
      await server.close();
    },
    { scope: 'worker' },
  ],

  // biome-ignore lint/correctness/noEmptyPattern: as above
  siteWithWorker: async ({}, use) => {
    const servers = [];
    await use(async (code) => {
      const server = await serveWithWorker(code);
      servers.push(server);
      return server.url;
    });
    for (const server of servers) await server.close();
  },

  visit: async ({ browser, site, siteWithWorker: _closedLater }, use) => {
    const visits = [];
    await use(async (hash, { url = site, prepare = withoutPicker, live = false } = {}) => {
      const context = await browser.newContext();
      if (!live) await context.addInitScript(meshByClick);
      await context.addInitScript(prepare);
      const page = await context.newPage();
      visits.push({ context, complaints: complaintsOf(page, url) });
      await page.goto(url + hash);
      await isIdle(page);
      return page;
    });
    const complaints = visits.flatMap(({ complaints }) => complaints.filter((complaint) => !DRIVER_REMARK.test(complaint)));
    for (const { context } of visits) await context.close();
    assert.deepEqual(complaints, []);
  },

  // biome-ignore lint/correctness/noEmptyPattern: as above
  folder: async ({}, use) => {
    const folder = mkdtempSync(path.join(tmpdir(), 'hexcast-'));
    await use(folder);
    rmSync(folder, { recursive: true });
  },

  // biome-ignore lint/correctness/noEmptyPattern: as above
  firefox: async ({}, use) => {
    const browser = await openFirefox();
    await use(browser);
    await browser.close();
  },
});

/** The dialogue for a place to save is the browser's own: no test can answer it. */
function withoutPicker() {
  delete window.showSaveFilePicker;
}

/** Before the page's scripts: a browser whose canvases cannot go to a worker. */
export function withoutOffscreen() {
  delete window.showSaveFilePicker;
  delete HTMLCanvasElement.prototype.transferControlToOffscreen;
}

/** The worker that draws finds no WebGL. */
export const WITHOUT_WEBGL = 'OffscreenCanvas.prototype.getContext = () => null;';

/** Lets the worker that draws run this code first; not once it is there. */
export function beforeDrawing(page, code) {
  return page.route(/draw_worker.*\.js$/, async (route) => {
    const response = await route.fetch();
    await route.fulfill({ response, body: `${code}\n${await response.text()}` });
  });
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
  await page.check(`#panes-${axis}`);
  await page.fill(`#plane-${axis}`, String(index));
  await page.waitForSelector(`#canvas-${axis}[data-index="${index}"]`);
  return page.$eval(`#canvas-${axis}`, (canvas) => {
    const [left, top, dx, dy, width, height] = ['left', 'top', 'scaleX', 'scaleY', 'width', 'height'].map((key) =>
      Number(canvas.dataset[key]),
    );
    const copy = new OffscreenCanvas(canvas.width, canvas.height).getContext('2d', { willReadFrequently: true });
    // set and read again a colour has six digits
    copy.fillStyle = getComputedStyle(canvas).getPropertyValue('--cells-background').trim();
    const background = copy.fillStyle;
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

/** The saved picture of the 3-D view, without its legend: a handle of its ImageData in the page. */
export async function picture3d(page) {
  const { bytes } = await saved(page, '#save-3d');
  return page.evaluateHandle(async (base64) => {
    const blob = new Blob([Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0))]);
    const bitmap = await createImageBitmap(blob);
    const { clientWidth, clientHeight } = document.querySelector('#canvas-3d');
    const height = Math.round((bitmap.width * clientHeight) / clientWidth);
    const context = new OffscreenCanvas(bitmap.width, height).getContext('2d');
    context.drawImage(bitmap, 0, 0);
    return context.getImageData(0, 0, bitmap.width, height);
  }, bytes.toString('base64'));
}

/** Names of the files that the page keeps for the next visit; null while the page replaces their list. */
export function keptFiles(page) {
  return page.evaluate(async () => {
    const root = await navigator.storage.getDirectory();
    const folder = await root.getDirectoryHandle('hexcast-session').catch(() => null);
    const list = await folder?.getFileHandle('session.json').catch(() => null);
    if (!list) return [];
    try {
      // it is empty until it is written
      const text = await (await list.getFile()).text();
      return text === '' ? [] : JSON.parse(text).map(({ name }) => name);
    } catch (error) {
      // the page puts another in its place between the steps
      if (error.name === 'NotFoundError' || error.name === 'NotReadableError') return null;
      throw error;
    }
  });
}

/** Waits until the cells of the last mesh are drawn. @param {number} [timeout] in milliseconds */
export const cellsAreDrawn = (page, timeout) =>
  page.waitForFunction(() => / cells$/.test(document.querySelector('#view-status').textContent), null, { timeout });

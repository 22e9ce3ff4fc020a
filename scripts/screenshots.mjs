// Takes the pictures of the page that README.md shows: builds, serves, drives Chromium, writes docs/*.png.

import { mkdirSync } from 'node:fs';
import path from 'node:path';

import { openChromium } from '../tests/e2e/browsers.mjs';
import { build } from './build.mjs';
import { ROOT } from './run.mjs';
import { serve } from './serve.mjs';

/**
 * @typedef {{ viewport?: { width: number, height: number }, colorScheme?: 'light' | 'dark' }} Look
 * @typedef {(page: import('@playwright/test').Page) => Promise<unknown>} Act
 */

const DOCS = path.join(ROOT, 'docs');
const SPOT = path.join(ROOT, 'tests/fixtures/spot.stl');
const WIDE = { width: 1280, height: 800 };

/**
 * Opens the page, does what the picture needs, takes it.
 *
 * @param {import('@playwright/test').Browser} browser
 * @param {string} url
 * @param {string} name
 * @param {Look} look
 * @param {Act} act
 */
async function picture(browser, url, name, { viewport = WIDE, colorScheme = 'light' }, act) {
  const context = await browser.newContext({ viewport, colorScheme });
  const page = await context.newPage();
  await page.goto(url);
  await page.waitForSelector('body[data-phase=idle]');
  await act(page);
  await page.waitForTimeout(1500);
  await page.screenshot({ path: path.join(DOCS, `${name}.png`) });
  await context.close();
}

/** @param {import('@playwright/test').Page} page */
async function load(page) {
  await page.setInputFiles('#file-input', SPOT);
  await page.waitForSelector('.geometry[data-file]');
}

/** @param {import('@playwright/test').Page} page */
async function mesh(page) {
  await load(page);
  await page.fill('#cells', '96');
  await page.press('#cells', 'Enter');
  await page.click('#run');
  await page.waitForSelector('#legend tr[data-flag]');
}

console.log(await build());
mkdirSync(DOCS, { recursive: true });
const server = await serve();
const browser = await openChromium();
/** @type {[string, Look, Act][]} */
const shots = [
  ['empty', {}, async () => {}],
  ['model', {}, load],
  ['mesh', {}, mesh],
  [
    'slices',
    {},
    async (page) => {
      await mesh(page);
      await page.click('#tab-slices');
    },
  ],
  ['error', {}, async (page) => page.setInputFiles('#file-input', path.join(ROOT, 'tests/fixtures/bin_count_too_big.stl'))],
  ['dark', { colorScheme: 'dark' }, mesh],
  ['phone', { viewport: { width: 390, height: 844 } }, mesh],
];
for (const [name, options, act] of shots) {
  await picture(browser, server.url, `page-${name}`, options, act);
  console.log(`docs/page-${name}.png`);
}
await browser.close();
await server.close();

// Takes the picture of the page in README.md: builds and serves the page, meshes a model in Chromium, writes docs/page.png.

import path from 'node:path';

import { openChromium } from '../tests/e2e/browsers.mjs';
import { build } from './build.mjs';
import { ROOT } from './run.mjs';
import { serve } from './serve.mjs';

console.log(await build());
const server = await serve();
const browser = await openChromium();
const page = await browser.newPage({ viewport: { width: 1280, height: 800 } });
await page.goto(`${server.url}#cells=96&unit=mm&backend=cpu`);
await page.setInputFiles('#file-input', path.join(ROOT, 'tests/fixtures/spot.stl'));
// up is y in the model, and z in the view
await page.click('.geometry summary');
await page.fill('.geometry .rotate', '90 0 0');
await page.click('.geometry summary');
// the page meshes whatever changes
await page.waitForFunction(() => document.querySelector('#result-dims')?.textContent?.startsWith('53 × 96 × 95'));
await page.waitForFunction(() => / cells$/.test(document.querySelector('#view-status')?.textContent ?? ''));
await page.press('#canvas-3d', 'Home');
for (let turn = 0; turn < 12; turn += 1) await page.press('#canvas-3d', 'ArrowRight');
// the view is drawn once a frame, on the processor
await page.waitForTimeout(1500);
await page.screenshot({ path: path.join(ROOT, 'docs/page.png') });
await browser.close();
await server.close();

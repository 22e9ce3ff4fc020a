// Times the page in Chromium and the native program, both on SwiftShader, then the largest mesh, for bench.mjs.

import path from 'node:path';

import { build } from '../scripts/build.mjs';
import { swiftshaderEnv } from '../scripts/machine.mjs';
import { serve } from '../scripts/serve.mjs';
import { meshByClick, openChromiumProfile } from '../tests/e2e/browsers.mjs';
import { benchLargest } from './largest.mjs';
import { median, ms, span, table, timeStages } from './results.mjs';

/**
 * @typedef {import('./bench.mjs').Bench} Bench
 * @typedef {import('@playwright/test').BrowserContext} Context
 *
 * Where the page is, and the environment that gives the native program the same driver.
 *
 * @typedef {Bench & { context: Context, url: string, driver: Record<string, string> }} Site
 *
 * Seconds of all runs of a racer: of the stages, and from click to result.
 *
 * @typedef {{ stages: number[], clicks: number[] }} Times
 */

/** Cells along an edge of the largest mesh: 1.0008e10 cells. */
const LARGEST = 2155;

/** A native backend, with its environment, or the page's; `other` is the racer that it is compared with. */
/** @type {{ name: string, backend: string, isPage?: boolean, other?: string, env?: Record<string, string> }[]} */
const RACERS = [
  { name: 'native, GPU', backend: 'gpu' },
  { name: 'page, GPU', backend: 'gpu', isPage: true, other: 'native, GPU' },
  { name: 'native, CPU, all cores', backend: 'cpu' },
  { name: 'native, CPU, one thread', backend: 'cpu', env: { RAYON_NUM_THREADS: '1' } },
  { name: 'page, CPU (wasm, one thread)', backend: 'cpu', isPage: true, other: 'native, CPU, one thread' },
];

/** Measures the page. @param {Bench} bench */
export async function benchPage(bench) {
  const driver = swiftshaderEnv();
  if (!driver) throw new Error("missing: SwiftShader as a Vulkan driver, which Debian's package chromium brings");
  console.log(await build());
  const server = await serve();
  const context = await openChromiumProfile(path.join(bench.folder, 'profile'), ['--enable-unsafe-swiftshader']);
  try {
    const site = { ...bench, context, url: server.url, driver };
    const races = [];
    for (const n of bench.quick ? [128] : bench.sizes) races.push(await race(site, n));
    const largest = await benchLargest(site, Number(bench.largest ?? (bench.quick ? 300 : LARGEST)));
    const text = [
      '\n### From the read file to columns, 64 spheres',
      ...races.map(({ rows }) => rows),
      '### The largest mesh',
      largest,
    ];
    return { adapter: `SwiftShader, for both (${races[0].adapter} to the page)`, text: text.join('\n\n') };
  } finally {
    await context.close();
    await server.close();
  }
}

/** Runs every racer in turn: a table of their warm runs, and the GPU as the page names it. @param {Site} site @param {number} n */
async function race(site, n) {
  /** @type {Map<string, Times>} */
  const times = new Map(RACERS.map(({ name }) => [name, { stages: [], clicks: [] }]));
  let adapter = '';
  const sum = (/** @type {Record<string, number>} */ { lines, snap, columns }) => lines + snap + columns;
  for (let round = 0; round < site.rounds; round += 1) {
    for (const { name, backend, isPage, env } of RACERS) {
      const { stages, clicks } = /** @type {Times} */ (times.get(name));
      if (isPage) {
        const made = await runOnPage(site, n, backend);
        stages.push(...made.map(({ report }) => sum(report.seconds)));
        clicks.push(...made.map(({ seconds }) => seconds));
        adapter ||= made[0].report.adapter;
      } else {
        const all = { ...(backend === 'gpu' ? site.driver : {}), ...env };
        const [made] = timeStages(site.stages, site.spheres, { n, backend, runs: site.runs, env: all });
        stages.push(...made.runs.map(sum));
      }
    }
  }
  return { rows: raceTable(n, times), adapter };
}

/**
 * Meshes with a click on the page, as often as asked and once before; with the seconds until the page shows the result.
 *
 * @param {Site} site
 * @param {number} n
 * @param {string} backend
 */
async function runOnPage({ context, url, spheres, runs }, n, backend) {
  const page = await context.newPage();
  // each mesh is made by a click
  await page.addInitScript(meshByClick);
  try {
    // another hash alone would not load the page again
    await page.goto(`${url}?${backend}#cells=${n}&backend=${backend}`);
    await page.waitForSelector('body[data-phase=idle]');
    await page.setInputFiles('#file-input', spheres);
    await page.waitForSelector('.geometry');
    /** @type {{ seconds: number, report: import('./results.mjs').Report }[]} */
    const made = [];
    for (let run = 0; run <= Number(runs); run += 1) {
      await page.waitForSelector('#run:enabled');
      await page.evaluate(pictureIsDrawn);
      made.push(await page.evaluate(clickAndWait));
      // the surface for the 3-D view is made after the mesh, and must not count as the next one's
      const isMade = () => / cells$|No cell/.test(document.querySelector('#view-status')?.textContent ?? '');
      await page.waitForFunction(isMade, null, { timeout: 0 });
    }
    return made.slice(1);
  } finally {
    await page.close();
  }
}

/** In the page: resolves once nothing is drawn in 3-D any more, which takes a driver on the processor a second after a mesh. */
async function pictureIsDrawn() {
  const { dataset } = /** @type {HTMLCanvasElement} */ (document.querySelector('#canvas-3d'));
  /** @type {string | undefined} */
  let before;
  do {
    before = dataset.pictures;
    await new Promise((resolve) => setTimeout(resolve, 1000));
  } while (before !== dataset.pictures);
}

/** In the page: clicks, and resolves once the result is shown. @returns {Promise<any>} */
function clickAndWait() {
  const [run, shown] = ['#run', '#report'].map((name) => /** @type {HTMLElement} */ (document.querySelector(name)));
  return new Promise((resolve, reject) => {
    const start = performance.now();
    const observer = new MutationObserver(() => {
      if (document.body.dataset.phase !== 'idle') return;
      observer.disconnect();
      const seconds = (performance.now() - start) / 1000;
      // the report is written in the same task
      setTimeout(() => {
        const message = document.querySelector('#messages [role=alert]')?.textContent;
        if (message) reject(new Error(message));
        else resolve({ seconds, report: JSON.parse(shown.textContent ?? '') });
      });
    });
    observer.observe(document.body, { attributeFilter: ['data-phase'] });
    run.click();
  });
}

/** @param {number} n @param {Map<string, Times>} times */
function raceTable(n, times) {
  const of = (/** @type {string} */ name) => /** @type {Times} */ (times.get(name));
  const rows = RACERS.map(({ name, other }) => {
    const { stages, clicks } = of(name);
    const middle = median(stages);
    const ratio = other ? `${(middle / median(of(other).stages)).toFixed(2)} of ${other}` : '';
    const click = clicks.length > 0 ? ms(median(clicks)) : '';
    return [name, ms(middle), span(stages, ms), click, (n ** 3 / middle / 1e9).toFixed(2), ratio];
  });
  return table([`${n}^3`, 'columns, ms', 'from - to', 'click to result, ms', '1e9 cells/s', 'time'], rows);
}

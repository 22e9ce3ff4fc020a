// Times the page in Chromium beside the native program, both on SwiftShader, then makes the largest mesh in the page and
// saves it to the private file system: "npm run bench -- page". bench.mjs writes the tables into benches/RESULTS.md.

import { execFileSync } from 'node:child_process';
import { cpSync } from 'node:fs';
import path from 'node:path';

import { openChromiumProfile } from '../tests/e2e/browsers.mjs';
import { largestInPage, largestNatively, largestTable } from './bench_largest.mjs';
import { DIST, build } from './build.mjs';
import { NATIVE_ENV, swiftshaderEnv } from './machine.mjs';
import { serve } from './serve.mjs';

/**
 * @typedef {import('./results.mjs').Report} Report
 * @typedef {import('@playwright/test').BrowserContext} Context
 * @typedef {Record<string, string>} Environment
 *
 * Where the page is, the model and the driver of both.
 *
 * @typedef {{ context: Context, url: string, file: string, driver: Environment }} Site
 *
 * @typedef {Pick<typeof import('./results.mjs'), 'jsonLines' | 'median' | 'ms' | 'table'>} Writing
 * @typedef {Writing & { scratch: string, command: string, bench: string, run: typeof import('./results.mjs').output }} Tools
 *
 * Seconds of all runs by racer: of the stages, and from click to result.
 *
 * @typedef {{ n: number, stages: Record<string, number[]>, clicks: Record<string, number[]>, adapter: string }} Race
 */

/** Cells along an edge of the largest mesh: 1.0008e10 cells. */
const LARGEST = 2155;

/**
 * Times everything.
 *
 * @param {{sizes: number[], rounds: number, runs: string, largest?: string, quick: boolean}} options
 * @param {Tools} tools of bench.mjs: the folder for files, the program, how to run it, and how tables are written
 * @returns {Promise<{adapter: string, text: string}>}
 */
export async function benchPage({ sizes, rounds, runs, largest, quick }, tools) {
  const driver = swiftshaderEnv();
  if (!driver) throw new Error("missing: SwiftShader as a Vulkan driver, which Debian's package chromium brings");
  console.log(await build());
  const root = path.join(tools.scratch, 'site');
  cpSync(DIST, root, { recursive: true });
  const file = path.join(root, 'spheres.stl');
  tools.run(tools.bench, ['--spheres', file]);
  const server = await serve({ root });
  const context = await openChromiumProfile(path.join(tools.scratch, 'profile'), ['--enable-unsafe-swiftshader']);
  try {
    const site = { context, url: server.url, file, driver };
    const races = [];
    for (const n of sizes) races.push(await race(site, tools, { n, rounds, runs }));
    const n = Number(largest ?? (quick ? 300 : LARGEST));
    const biggest = { page: await largestInPage(site, n), native: largestNatively(site, tools, n), n };
    const text = [
      '### From the read file to columns, 64 spheres\n',
      races.map((result) => raceTable(result, tools)).join('\n\n'),
      '\n### The largest mesh\n',
      largestTable(biggest, tools),
    ].join('\n');
    return { adapter: `SwiftShader, for both (${races[0].adapter} to the page)`, text };
  } finally {
    await context.close();
    await server.close();
  }
}

/** Who meshes, and how: a native backend with its environment, or the page's. */
/** @type {{ id: string, name: string, backend: string, isPage?: boolean, beside?: string, env?: Environment }[]} */
const RACERS = [
  { id: 'nativeGpu', name: 'native, GPU', backend: 'gpu' },
  { id: 'pageGpu', name: 'page, GPU', backend: 'gpu', isPage: true, beside: 'nativeGpu' },
  { id: 'nativeCpu', name: 'native, CPU, all cores', backend: 'cpu' },
  { id: 'nativeOne', name: 'native, CPU, one thread', backend: 'cpu', env: { RAYON_NUM_THREADS: '1' } },
  { id: 'pageCpu', name: 'page, CPU (wasm, one thread)', backend: 'cpu', isPage: true, beside: 'nativeOne' },
];

/**
 * Seconds of every warm run of every racer, in turn: of the stages from the read file to columns, and from click to result.
 *
 * @param {Site} site
 * @param {Tools} tools
 * @param {{ n: number, rounds: number, runs: string }} how
 * @returns {Promise<Race>}
 */
async function race(site, tools, { n, rounds, runs }) {
  /** @returns {Record<string, number[]>} */
  const none = () => Object.fromEntries(RACERS.map(({ id }) => [id, []]));
  const [stages, clicks] = [none(), none()];
  let adapter = '';
  const sum = (/** @type {Record<string, number>} */ { lines, snap, columns }) => lines + snap + columns;
  for (let round = 0; round < rounds; round += 1) {
    for (const { id, backend, isPage, env } of RACERS) {
      if (isPage) {
        const made = await runInPage(site, n, backend, Number(runs));
        stages[id].push(...made.map(({ report }) => sum(report.seconds)));
        clicks[id].push(...made.map(({ seconds }) => seconds));
        adapter ||= made[0].report.adapter;
      } else {
        const args = ['--file', site.file, '--cells', String(n), '--backends', backend, '--runs', runs];
        const environment = { ...process.env, ...NATIVE_ENV, ...(backend === 'gpu' ? site.driver : {}), ...env };
        const [made] = tools.jsonLines(
          execFileSync(tools.bench, args, { encoding: 'utf8', env: environment, stdio: ['ignore', 'pipe', 'ignore'] }),
        );
        stages[id].push(...made.runs.map(sum));
      }
    }
  }
  return { n, stages, clicks, adapter };
}

/**
 * Meshes with a click on the page, as often as asked and once before; with the seconds until the page shows the result.
 *
 * @param {Site} site
 * @param {number} n
 * @param {string} backend
 * @param {number} runs
 */
async function runInPage({ context, url, file }, n, backend, runs) {
  const page = await context.newPage();
  try {
    // another hash alone would not load the page again
    await page.goto(`${url}?${backend}#cells=${n}&backend=${backend}`);
    await page.waitForSelector('body[data-phase=idle]');
    await page.setInputFiles('#file-input', file);
    await page.waitForSelector('.geometry');
    /** @type {{ seconds: number, report: Report }[]} */
    const made = [];
    for (let run = 0; run <= runs; run += 1) {
      await page.waitForSelector('#run:enabled');
      await page.evaluate(pictureIsDrawn);
      made.push(await page.evaluate(clickAndWait));
      // the surface for the 3-D view is made after the mesh, and must not count as the next one's
      await page.waitForFunction(
        () => /triangles|No cell/.test(document.querySelector('#view-status')?.textContent ?? ''),
        null,
        {
          timeout: 0,
        },
      );
    }
    return made.slice(1);
  } finally {
    await page.close();
  }
}

/** In the page: resolves once the 3-D view stands still, which takes a driver on the processor a second after a mesh. */
async function pictureIsDrawn() {
  const canvas = /** @type {HTMLCanvasElement} */ (document.querySelector('#canvas-3d'));
  const gl = canvas.getContext('webgl2');
  for (let frame = 0; frame < 3; frame += 1) {
    await new Promise(requestAnimationFrame);
    // reading waits for all that was drawn
    gl?.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
  }
}

/** In the page: clicks, and resolves once the result is shown. @returns {Promise<{ seconds: number, report: Report }>} */
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

/** @param {Race} race @param {Writing} writing */
function raceTable({ n, stages, clicks }, { median, ms, table }) {
  const rows = RACERS.map(({ id, name, beside }) => {
    const [all, middle] = [stages[id], median(stages[id])];
    const other = beside && RACERS.find((racer) => racer.id === beside);
    const ratio = other ? `${(middle / median(stages[other.id])).toFixed(2)} of ${other.name}` : '';
    const click = clicks[id].length > 0 ? ms(median(clicks[id])) : '';
    return [
      name,
      ms(middle),
      `${ms(Math.min(...all))} - ${ms(Math.max(...all))}`,
      click,
      (n ** 3 / middle / 1e9).toFixed(2),
      ratio,
    ];
  });
  return table([`${n}^3`, 'columns, ms', 'from - to', 'click to result, ms', '1e9 cells/s', 'time'], rows);
}

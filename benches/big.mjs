// Opens a model of 2e7 facets on the page in Chromium, for bench.mjs: seconds of each stage, and the most memory of its process.

import { readFileSync } from 'node:fs';
import path from 'node:path';

import { build } from '../scripts/build.mjs';
import { serve } from '../scripts/serve.mjs';
import { meshByClick, openChromium } from '../tests/e2e/browsers.mjs';
import { writeWave } from '../tests/e2e/wave.mjs';
import { ISOLATED } from '../vite.config.mjs';
import { table } from './results.mjs';

/** Points around the axis of the model: 2e7 facets, 1 GB. */
const POINTS = 4472;
/** Milliseconds between two looks at the memory. */
const PAUSE = 100;

/** Pages that are opened: what their servers send, and how many threads that gives the mesher. */
const PAGES = [
  { name: 'as `npm start` serves it, on all cores', headers: ISOLATED },
  { name: 'first visit elsewhere, one thread', headers: {} },
];

/** @param {{ folder: string, quick: boolean }} bench @returns {Promise<import('./bench.mjs').Measured>} */
export async function benchBig({ folder, quick }) {
  const file = path.join(folder, 'wave.stl');
  const n_facets = writeWave(file, quick ? POINTS / 4 : POINTS);
  console.log(await build());
  const browser = await openChromium(['--enable-unsafe-swiftshader']);
  try {
    /** @type {Map<string, string[]>} */
    const rows = new Map();
    for (const { headers } of PAGES) {
      for (const [name, s, gb] of await served(headers, (url) => openFile(browser, url, file))) {
        rows.set(name, [...(rows.get(name) ?? [name]), s.toFixed(1), gb ? gb.toFixed(2) : '']);
      }
    }
    const cancels = await served({}, (url) => cancelStages(browser, url, file));
    const text = [
      `\n${n_facets} facets, seconds since the file was chosen, and the most memory of the page's process (RSS) until then:`,
      table(['', ...PAGES.flatMap(({ name }) => [`${name}: s`, 'GB'])], [...rows.values()]),
      'Seconds from a cancel to the answer of the next call, on one thread, the longest of those at some moments of each stage:',
      table(
        ['', 's'],
        cancels.map(([stage, s]) => [stage, s.toFixed(2)]),
      ),
    ];
    return { adapter: 'none', text: text.join('\n\n') };
  } finally {
    await browser.close();
  }
}

/**
 * Does something while the page is served.
 *
 * @template T
 * @param {Record<string, string>} headers
 * @param {(url: string) => Promise<T>} act
 */
async function served(headers, act) {
  const server = await serve({ headers });
  try {
    return await act(server.url);
  } finally {
    await server.close();
  }
}

/**
 * Chooses the file on a page, waits until its edges are known, and meshes it: the seconds of each step, and the most memory.
 *
 * @param {import('@playwright/test').Browser} browser @param {string} url @param {string} file
 * @returns {Promise<[string, number, number?][]>}
 */
async function openFile(browser, url, file) {
  const page = await (await browser.newContext()).newPage();
  await page.addInitScript(listen);
  await page.goto(`${url}#cells=256&backend=cpu`);
  await page.waitForSelector('body[data-phase=idle]');
  const memory = watch(await browser.newBrowserCDPSession());
  await page.evaluate(() => Object.assign(window, { start: performance.now() }));
  await page.setInputFiles('#file-input', file);
  await page.waitForFunction(() => document.querySelector('.geometry .facts')?.textContent?.includes('Surfaceclosed'), null, {
    timeout: 600_000,
  });
  const opened = memory.take();
  const ends = await page.evaluate(() => Reflect.get(window, 'ends'));
  const meshable = await page.evaluate(() => Reflect.get(window, 'meshable'));
  const start = performance.now();
  await page.click('#run');
  await page.waitForSelector('#legend tr', { timeout: 600_000 });
  const seconds = (performance.now() - start) / 1000;
  const meshed = memory.take();
  memory.end();
  await page.context().close();
  return [
    ['read', ends.read],
    ['can be meshed', meshable],
    ['drawn', ends.preview],
    ['edges are known', ends.check, opened],
    ['256^3 cells, after another click', seconds, meshed],
  ];
}

/** Seconds after which stages are cancelled. */
const MOMENTS = { read: [2, 5], preview: [0.3, 1, 2], estimate: [0.1, 1], mesh: [0.2, 2, 4, 6, 8, 10], check: [1, 6, 12, 20] };

/**
 * Cancels each stage at some moments; the most seconds until the worker has answered the next call.
 *
 * @param {import('@playwright/test').Browser} browser @param {string} url @param {string} file
 * @returns {Promise<[string, number][]>}
 */
async function cancelStages(browser, url, file) {
  const page = await browser.newPage();
  // the page meshes nothing by itself beside it
  await page.addInitScript(meshByClick);
  await page.goto(url);
  await page.evaluate(() => document.body.append(Object.assign(document.createElement('input'), { type: 'file', id: 'big' })));
  await page.setInputFiles('#big', file);
  return page.evaluate(async (moments) => {
    const { createMesher } = await import(new URL('hexcast.js', location.href).href);
    const [source] = /** @type {HTMLInputElement} */ (document.querySelector('#big')).files ?? [];
    const mesher = await createMesher({ backend: 'cpu' });
    const small = new Float32Array([0, 0, 0, 1, 0, 0, 0, 1, 0]);
    const read = (/** @type {object} */ options) => mesher.read(source, { check: false, ...options });
    const surface = await read({});
    const job = { geometries: [{ source: surface }], cells: 256 };
    /** @type {Record<string, (options: object) => Promise<unknown>>} */
    const stages = {
      read,
      preview: (options) => surface.preview(1_000_000, options),
      estimate: (options) => mesher.estimate(job, options),
      mesh: (options) => mesher.mesh(job, options),
      check: (options) => surface.check(options),
    };
    /** @type {[string, number][]} */
    const found = [];
    for (const [stage, act] of Object.entries(stages)) {
      let longest = 0;
      for (const seconds of moments[/** @type {keyof typeof moments} */ (stage)]) {
        const stop = new AbortController();
        const work = act({ signal: stop.signal }).catch(() => {});
        await new Promise((resolve) => setTimeout(resolve, 1000 * seconds));
        const start = performance.now();
        stop.abort();
        await mesher.read(small);
        longest = Math.max(longest, (performance.now() - start) / 1000);
        await work;
      }
      found.push([stage, longest]);
    }
    mesher.dispose();
    return found;
  }, MOMENTS);
}

/** In the page, before its scripts: when the worker told last of each stage, and when Run could first be clicked. */
function listen() {
  const all = Object.assign(window, { start: 0, ends: /** @type {Record<string, number>} */ ({}), meshable: 0 });
  const since = () => (performance.now() - all.start) / 1000;
  const Plain = window.Worker;
  window.Worker = class extends Plain {
    /** @param {ConstructorParameters<typeof Plain>} options */
    constructor(...options) {
      super(...options);
      this.addEventListener('message', ({ data: { progress } }) => {
        if (progress) all.ends[progress.stage] = since();
      });
    }
  };
  const look = () => {
    const isEnabled = document.querySelector('.geometry') && document.querySelector('#run:enabled');
    if (isEnabled && all.meshable === 0) all.meshable = since();
    requestAnimationFrame(look);
  };
  requestAnimationFrame(look);
}

/** Watches the largest of the browser's processes for pages, in GB. @param {import('@playwright/test').CDPSession} session */
function watch(session) {
  let most = 0;
  const timer = setInterval(async () => {
    const { processInfo } = await session.send('SystemInfo.getProcessInfo').catch(() => ({ processInfo: [] }));
    for (const { id, type } of processInfo) {
      if (type !== 'renderer') continue;
      const found = /VmRSS:\s+(\d+) kB/.exec(statusOf(id));
      most = Math.max(most, found ? Number(found[1]) * 1.024e-6 : 0);
    }
  }, PAUSE);
  const take = () => {
    const taken = most;
    most = 0;
    return taken;
  };
  return { take, end: () => clearInterval(timer) };
}

/** What Linux says of a process; nothing where it ended, or is none of ours. @param {number} id */
function statusOf(id) {
  try {
    return readFileSync(`/proc/${id}/status`, 'utf8');
  } catch {
    return '';
  }
}

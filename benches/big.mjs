// Opens a model of 2e7 facets on the page in Chromium, for bench.mjs: seconds of each stage, and the most memory of its process.

import { readFileSync } from 'node:fs';
import path from 'node:path';

import { build } from '../scripts/build.mjs';
import { serve } from '../scripts/serve.mjs';
import { openChromium } from '../tests/e2e/browsers.mjs';
import { writeWave } from '../tests/e2e/wave.mjs';
import { table } from './results.mjs';

/** Points around the axis of the model: 2e7 facets, 1 GB. */
const POINTS = 4472;
/** Milliseconds between two looks at the memory. */
const PAUSE = 100;

/** @param {{ folder: string, quick: boolean }} bench @returns {Promise<import('./bench.mjs').Measured>} */
export async function benchBig({ folder, quick }) {
  const file = path.join(folder, 'wave.stl');
  const n_facets = writeWave(file, quick ? POINTS / 4 : POINTS);
  console.log(await build());
  const server = await serve();
  const browser = await openChromium(['--enable-unsafe-swiftshader']);
  try {
    const page = await (await browser.newContext()).newPage();
    await page.addInitScript(listen);
    await page.goto(`${server.url}#cells=256&backend=cpu`);
    await page.waitForSelector('body[data-phase=idle]');
    const session = await browser.newBrowserCDPSession();
    const memory = watch(session);
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
    const rows = [
      ['read', ends.read, ''],
      ['can be meshed', meshable, ''],
      ['drawn', ends.preview, ''],
      ['edges are known', ends.check, opened],
      ['256^3 cells, after another click', seconds, memory.take()],
    ];
    memory.end();
    const text = [
      `\n${n_facets} facets, seconds since the file was chosen, and the most memory of the page's process (RSS) until then:`,
      table(
        ['', 's', 'GB'],
        rows.map(([name, s, gb]) => [name, Number(s).toFixed(1), gb && Number(gb).toFixed(2)]),
      ),
    ];
    return { adapter: 'none', text: text.join('\n\n') };
  } finally {
    await browser.close();
    await server.close();
  }
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

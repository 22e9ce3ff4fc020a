// People's ways through the page, in Chromium: sample, run, slices, 3-D, priorities, files, cancel, errors, links.

import assert from 'node:assert/strict';
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { after, before, test } from 'node:test';

import { DIST } from '../../scripts/build.mjs';
import { serve } from '../../scripts/serve.mjs';
import { complaintsOf, openChromium } from './browsers.mjs';

const COPPER = '#d98324';
const EPOXY = '#3a8fc9';
const LIMIT = { timeout: 240_000 };
/** Chromium's remark where WebGL is drawn on the processor: it says nothing about the page. */
const DRIVER_REMARK = /GL Driver Message \(OpenGL, Performance/;

let server;
let browser;
before(async () => {
  server = await serve({ base: '/below/a/path/' });
  // three.js draws on the processor here
  browser = await openChromium(['--enable-unsafe-swiftshader']);
});
after(async () => {
  await browser?.close();
  await server?.close();
});

/** Opens the page with parameters and hands it over once it is ready; nothing may be complained about. */
async function withPage(hash, visit) {
  const context = await browser.newContext({ acceptDownloads: true });
  // the dialogue for a place to save is the browser's own: no test can answer it
  await context.addInitScript(() => delete window.showSaveFilePicker);
  const page = await context.newPage();
  const complaints = complaintsOf(page, server.url);
  try {
    await page.goto(server.url + hash);
    await isIdle(page);
    await visit(page);
    assert.deepEqual(complaints.filter((complaint) => !DRIVER_REMARK.test(complaint)), []);
  } finally {
    await context.close();
  }
}

function isIdle(page) {
  return page.waitForFunction(() => document.body.dataset.phase === 'idle', null, { timeout: 120_000 });
}

async function take(page, sample, n_files) {
  await page.click(`#empty [data-sample=${sample}]`);
  await hasGeometries(page, n_files);
}

async function hasGeometries(page, n_files) {
  await page.waitForFunction((n) => document.querySelectorAll('.geometry').length === n, n_files);
  await isIdle(page);
  await page.waitForSelector('#run:enabled');
}

/** Makes the mesh and waits until the page shows that one. */
async function run(page) {
  await page.evaluate(() => document.querySelector('#legend').replaceChildren());
  await page.click('#run');
  await page.waitForSelector('#legend tr', { timeout: 180_000 });
}

/** Cells of each flag as the legend has them. */
function legend(page) {
  return page.$$eval('#legend tr', (rows) => rows.map((row) => [Number(row.dataset.flag), Number(row.querySelector('.cells').dataset.cells)]));
}

/** Shows a slice and reads the colour in the middle of every cell: `[j][i]`, `null` for the background. */
async function slice(page, axis, index) {
  await page.click('#tab-slices');
  await page.check(`#slice-${axis}`);
  await page.fill('#slice-number', String(index));
  const isThere = ([axis, index]) => {
    const { dataset } = document.querySelector('#canvas-slice');
    return dataset.axis === axis && dataset.index === String(index);
  };
  await page.waitForFunction(isThere, [axis, index]);
  return page.$eval('#canvas-slice', (canvas) => {
    const [left, top, dx, dy, width, height] = ['left', 'top', 'scaleX', 'scaleY', 'width', 'height'].map((key) => Number(canvas.dataset[key]));
    const background = getComputedStyle(canvas).getPropertyValue('--cells-background').trim();
    const copy = new OffscreenCanvas(canvas.width, canvas.height).getContext('2d', { willReadFrequently: true });
    copy.drawImage(canvas, 0, 0);
    const { data } = copy.getImageData(0, 0, canvas.width, canvas.height);
    const colour = (x, y) => `#${[...data.slice(4 * (x + canvas.width * y), 4 * (x + canvas.width * y) + 3)].map((part) => part.toString(16).padStart(2, '0')).join('')}`;
    return Array.from({ length: height }, (_, j) =>
      Array.from({ length: width }, (_, i) => {
        const found = colour(Math.floor(left + (i + 0.5) * dx), Math.floor(top + (height - j - 0.5) * dy));
        return found === background ? null : found;
      }),
    );
  });
}

/** Clicks and returns the bytes that the browser saved. */
async function saved(page, selector) {
  const [download] = await Promise.all([page.waitForEvent('download'), page.click(selector)]);
  return { name: download.suggestedFilename(), bytes: readFileSync(await download.path()) };
}

test('two touching blocks: every cell of two slices has its colour', LIMIT, () =>
  withPage('#cells=20', async (page) => {
    await take(page, 'cubes', 2);
    assert.deepEqual(await page.$$eval('[id^=dims-]', (inputs) => inputs.map((input) => input.value)), ['20', '10', '10']);
    await run(page);
    assert.deepEqual(await legend(page), [[1, 1000], [2, 500]]);
    const row = (right) => Array.from({ length: 20 }, (_, i) => (i < 10 ? COPPER : right));
    assert.deepEqual(await slice(page, 'z', 2), Array(10).fill(row(EPOXY)));
    assert.deepEqual(await slice(page, 'z', 7), Array(10).fill(row(null)));
    assert.deepEqual(await slice(page, 'x', 15), Array.from({ length: 10 }, (_, k) => Array(10).fill(k < 5 ? EPOXY : null)));
  }),
);

test('arrow keys move the slice', LIMIT, () =>
  withPage('#cells=20&sample=cubes', async (page) => {
    await hasGeometries(page, 2);
    await run(page);
    await slice(page, 'z', 4);
    await page.focus('#canvas-slice');
    await page.keyboard.press('ArrowUp');
    await page.waitForFunction(() => document.querySelector('#canvas-slice').dataset.index === '5');
    assert.equal((await slice(page, 'z', 5))[0][15], null);
    await page.keyboard.press('Home');
  }),
);

test('the model, the cells and a section are drawn in 3-D', LIMIT, () =>
  withPage('#cells=32', async (page) => {
    await take(page, 'shells', 2);
    const counts = [await coloursIn3d(page)];
    await run(page);
    await page.waitForSelector('#canvas-3d[data-triangles]', { timeout: 60_000 });
    counts.push(await coloursIn3d(page));
    const whole = await page.$eval('#canvas-3d', (canvas) => Number(canvas.dataset.triangles));
    assert.ok(whole > 1000, `${whole} triangles`);
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
  }),
);

/** Number of colours, share of pixels that are drawn on, and share in the second flag's very colour, of the saved picture. */
async function coloursIn3d(page) {
  await page.waitForTimeout(500);
  const { bytes } = await saved(page, '#save-3d');
  return page.evaluate(async (base64) => {
    const blob = new Blob([Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0))]);
    const bitmap = await createImageBitmap(blob);
    const context = new OffscreenCanvas(bitmap.width, bitmap.height).getContext('2d');
    context.drawImage(bitmap, 0, 0);
    const pixels = new Uint32Array(context.getImageData(0, 0, bitmap.width, bitmap.height).data.buffer);
    const isDrawn = pixels.filter((pixel) => pixel >>> 24 > 0);
    const near = (pixel) => [0x3a, 0x8f, 0xc9].every((part, at) => Math.abs(((pixel >>> (8 * at)) & 255) - part) <= 1);
    return { n_colours: new Set(pixels).size, share: isDrawn.length / pixels.length, exact: isDrawn.filter(near).length / pixels.length };
  }, bytes.toString('base64'));
}

test('where two geometries overlap the higher priority wins', LIMIT, () =>
  withPage('#cells=20', async (page) => {
    await take(page, 'shells', 2);
    await run(page);
    assert.equal((await slice(page, 'z', 10))[10][10], EPOXY);
    await page.fill('.geometry[data-file="core.stl"] .priority', '-1');
    await run(page);
    assert.equal((await slice(page, 'z', 10))[10][10], COPPER);
    assert.equal(new Map(await legend(page)).get(2) ?? 0, 0);
    assert.notEqual(await page.textContent('#result-warnings'), '');
  }),
);

test('files are as large as was said and hold the cells', LIMIT, () =>
  withPage('#cells=20&sample=cubes&unit=mm', async (page) => {
    await hasGeometries(page, 2);
    await run(page);
    for (const id of ['vti', 'npy', 'raw']) {
      const said = Number(await page.getAttribute(`#download-${id} .size`, 'data-bytes'));
      const { name, bytes } = await saved(page, `#download-${id}`);
      assert.equal(name, `copper.${id}`);
      assert.equal(bytes.length, said, id);
    }
    const { bytes: raw } = await saved(page, '#download-raw');
    const flag = (at) => (at % 20 < 10 ? 1 : at < 1000 ? 2 : 0);
    assert.deepEqual([...raw], Array.from({ length: 2000 }, (_, at) => flag(at)));
    const { bytes: sidecar } = await saved(page, '#download-sidecar');
    assert.equal(JSON.parse(sidecar).unit, 'mm');
    assert.ok((await saved(page, '#download-vtiz')).bytes.length > 0);
    await page.click('#results summary');
    const { bytes: report } = await saved(page, '#save-report');
    assert.deepEqual(JSON.parse(report).dims, [20, 10, 10]);
    // a column file opens again
    const { bytes: columns } = await saved(page, '#download-hxc');
    await page.goto(`${server.url}?empty`);
    await isIdle(page);
    await page.setInputFiles('#file-input', { name: 'again.hxc', mimeType: '', buffer: columns });
    await page.waitForSelector('#legend tr');
    assert.deepEqual(await legend(page), [[1, 1000], [2, 500]]);
  }),
);

test('a malformed file gives a sentence and loses nothing', LIMIT, () =>
  withPage('#cells=20&sample=gear', async (page) => {
    await hasGeometries(page, 1);
    await page.setInputFiles('#file-input', { name: 'letter.stl', mimeType: 'model/stl', buffer: Buffer.from('Dear Sir or Madam') });
    await page.waitForSelector('#messages [role=alert]');
    const text = await page.textContent('#messages [role=alert] p');
    assert.match(text, /letter\.stl/);
    assert.match(text, /[.!?]$/);
    assert.match(await page.getAttribute('#messages [role=alert]', 'data-code'), /^stl-/);
    await hasGeometries(page, 1);
    await run(page);
  }),
);

test('dropped files are read, several at once', LIMIT, () =>
  withPage('', async (page) => {
    await page.evaluate(async () => {
      const { sampleFiles } = await import(new URL('page/samples.js', location.href).href);
      const dataTransfer = new DataTransfer();
      for (const { source } of [...sampleFiles('cubes'), ...sampleFiles('gear')]) dataTransfer.items.add(source);
      document.querySelector('#canvas-3d').dispatchEvent(new DragEvent('drop', { dataTransfer, bubbles: true, cancelable: true }));
    });
    await hasGeometries(page, 3);
    assert.deepEqual(await page.$$eval('.geometry .flag', (inputs) => inputs.map((input) => input.value)), ['1', '2', '3']);
    await page.click('[aria-label="Remove epoxy"]');
    await hasGeometries(page, 2);
  }),
);

test('Cancel stops within half a second, and the next mesh is made', LIMIT, () =>
  withPage('#cells=1500&sample=knot', async (page) => {
    await hasGeometries(page, 1);
    await page.click('#run');
    await page.waitForSelector('#progress[value]', { timeout: 60_000 });
    const seconds = await page.evaluate(
      () =>
        new Promise((resolve) => {
          const start = performance.now();
          new MutationObserver(() => resolve((performance.now() - start) / 1000)).observe(document.body, { attributeFilter: ['data-phase'] });
          document.querySelector('#cancel').click();
        }),
    );
    assert.match(await page.textContent('#status'), /Cancelled/);
    // a driver on a busy processor may hold the half second up
    assert.ok(seconds < 2, `${seconds} s`);
    await page.fill('#cells', '30');
    await page.waitForFunction(() => document.querySelector('#dims-y').value === '30');
    await run(page);
  }),
);

test('the processor does the work where it is asked to', LIMIT, () =>
  withPage('#cells=20&sample=cubes&backend=cpu', async (page) => {
    await hasGeometries(page, 2);
    assert.equal(await page.getAttribute('#device', 'data-backend'), 'cpu');
    await run(page);
    assert.deepEqual(await legend(page), [[1, 1000], [2, 500]]);
  }),
);

test('a link restores the parameters and never holds the geometry', LIMIT, () =>
  withPage('', async (page) => {
    await take(page, 'cubes', 2);
    await page.fill('#cell-size', '0.5');
    await page.click('#settings summary');
    await page.fill('#padding', '1 2 3');
    await page.selectOption('#rule', 'nonzero');
    await page.selectOption('#axis', 'x');
    await page.selectOption('#unit', 'mm');
    await page.fill('.geometry[data-file="copper.stl"] .priority', '3');
    await page.fill('.geometry[data-file="epoxy.stl"] .name', 'FR4 board');
    await page.click('.geometry[data-file="epoxy.stl"] summary');
    await page.fill('.geometry[data-file="epoxy.stl"] .rotate', '0 0 90');
    await page.click('#copy-command');
    const command = await page.inputValue('#copied-text');
    assert.equal(
      command,
      "hexcast mesh copper.stl:name=copper,flag=1,priority=3 'epoxy.stl:name=FR4 board,flag=2,rotate=0/0/90' --padding-cells=1,2,3 --cell-size=0.5 --rule=nonzero --axis=x --unit=mm -o copper.vti",
    );
    await page.click('#copy-link');
    const link = await page.inputValue('#copied-text');
    assert.ok(link.length < 600, `${link.length} characters`);
    await withPage(new URL(link).hash, async (other) => {
      await hasGeometries(other, 2);
      await other.click('#copy-command');
      assert.equal(await other.inputValue('#copied-text'), command);
    });
  }),
);

test('what cannot be meshed is said before it is tried', LIMIT, () =>
  withPage('#sample=knot', async (page) => {
    await hasGeometries(page, 1);
    await page.fill('#cells', '60000');
    await page.waitForSelector('#estimate-warning, #estimate-error');
    await page.fill('#cells', '64');
    await page.waitForFunction(() => !document.querySelector('#estimate-warning, #estimate-error'));
  }),
);

test('where the browser lets one pick a place, files are streamed to it', LIMIT, () =>
  withPage('#cells=20&sample=cubes', async (page) => {
    await hasGeometries(page, 2);
    await run(page);
    // the private file system stands for the place that the user would pick
    await page.evaluate(() => {
      window.showSaveFilePicker = async ({ suggestedName }) =>
        (await navigator.storage.getDirectory()).getFileHandle(suggestedName, { create: true });
    });
    await page.click('#download-npy');
    await page.waitForFunction(() => document.querySelector('#downloads').textContent.includes('Saved.'));
    const size = await page.evaluate(async () => (await (await (await navigator.storage.getDirectory()).getFileHandle('copper.npy')).getFile()).size);
    assert.equal(size, Number(await page.getAttribute('#download-npy .size', 'data-bytes')));
  }),
);

test('the page stays at its frame rate while it meshes', LIMIT, () =>
  withPage('#cells=3000&sample=knot&backend=cpu', async (page) => {
    await hasGeometries(page, 1);
    await page.click('#run');
    const longest = await page.evaluate(
      () =>
        new Promise((resolve) => {
          const gaps = [];
          let last = performance.now();
          const frame = (now) => {
            gaps.push(now - last);
            last = now;
            gaps.length < 40 && document.body.dataset.phase === 'meshing' ? requestAnimationFrame(frame) : resolve(gaps.sort((a, b) => a - b));
          };
          requestAnimationFrame(frame);
        }),
    );
    await page.$eval('#cancel', (button) => button.click());
    await isIdle(page);
    assert.ok(longest.length >= 20, `${longest.length} frames`);
    // the middle one: a busy machine may delay single frames
    assert.ok(longest[Math.floor(longest.length / 2)] < 34, `${longest.map(Math.round)} ms between frames`);
  }),
);

test('without an adapter the processor does the same work, and the page says so', LIMIT, async () => {
  // workers have a navigator of their own: this one's finds no adapter
  const folder = mkdtempSync(path.join(tmpdir(), 'hexcast-'));
  const worker = readFileSync(path.join(DIST, 'worker.js'), 'utf8');
  writeFileSync(path.join(folder, 'worker.js'), `${worker}\nObject.defineProperty(navigator, 'gpu', { value: { requestAdapter: async () => null } });\n`);
  const without = await serve({ roots: [folder, DIST] });
  const page = await browser.newPage();
  try {
    await page.goto(`${without.url}#cells=20&sample=cubes`);
    await isIdle(page);
    await hasGeometries(page, 2);
    assert.equal(await page.getAttribute('#device', 'data-backend'), 'cpu');
    assert.match(await page.textContent('#device'), /No GPU/);
    await run(page);
    assert.deepEqual(await legend(page), [[1, 1000], [2, 500]]);
  } finally {
    await page.close();
    await without.close();
    rmSync(folder, { recursive: true });
  }
});

test('once loaded the page works without a network', LIMIT, async () => {
  const own = await serve({ base: '/' });
  const context = await browser.newContext();
  try {
    const page = await context.newPage();
    await page.goto(own.url);
    await isIdle(page);
    const isKept = async () => {
      const cache = await caches.open('hexcast');
      for (;;) {
        const kept = (await cache.keys()).map(({ url }) => new URL(url).pathname);
        if (['/', '/hexcast_bg.wasm', '/worker.js', '/core.js', '/vendor/three.module.js', '/page/scene.js'].every((file) => kept.includes(file))) return;
        await new Promise((resolve) => setTimeout(resolve, 100));
      }
    };
    await page.evaluate(isKept);
    await own.close();
    await page.goto(`${own.url}#cells=20&sample=cubes`);
    await page.reload();
    await isIdle(page);
    await hasGeometries(page, 2);
    await run(page);
    assert.deepEqual(await legend(page), [[1, 1000], [2, 500]]);
  } finally {
    await context.close();
    await own.close().catch(() => {});
  }
});

// Models of many facets: stages that can be ended, a mesh before the edges are known, a picture of fewer facets.

import assert from 'node:assert/strict';
import { mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';

import { test as base, hasGeometries, isIdle, legend, run } from './visit.mjs';
import { writeWave } from './wave.mjs';

/** Facets of the model: more than the page draws. */
const N_FACETS = 2 * 1100 * 549;

const test = base.extend({
  wave: [
    // biome-ignore lint/correctness/noEmptyPattern: Playwright reads from the pattern what a fixture needs
    async ({}, use) => {
      const folder = mkdtempSync(path.join(tmpdir(), 'hexcast-wave-'));
      const file = path.join(folder, 'wave.stl');
      assert.equal(writeWave(file, 1100), N_FACETS);
      await use(file);
      rmSync(folder, { recursive: true });
    },
    { scope: 'worker' },
  ],
});

/** Before the page's scripts: notes all progress of the worker, clicks Run as soon as it can, and presses Escape at stages, in their order. */
function listen() {
  delete window.showSaveFilePicker;
  window.heard = [];
  window.endAt = [];
  window.runsAtOnce = false;
  const Plain = window.Worker;
  window.Worker = class extends Plain {
    constructor(...options) {
      super(...options);
      this.addEventListener('message', ({ data: { id, progress } }) => {
        // the runs of the mesh are read for the 3-D view as well
        if (!progress || id === this.columns) return;
        window.heard.push({ stage: progress.stage, share: progress.done / progress.total });
        if (progress.stage !== window.endAt[0]) return;
        window.endAt.shift();
        // what the worker has told already is heard first
        setTimeout(() => {
          window.heard.push({ stage: `end of ${progress.stage}` });
          document.dispatchEvent(new KeyboardEvent('keydown', { key: 'Escape', bubbles: true }));
        });
      });
    }

    postMessage(message, ...options) {
      if (message.operation === 'columns') this.columns = message.id;
      super.postMessage(message, ...options);
    }
  };
  const look = () => {
    const button = document.querySelector('#run');
    if (window.runsAtOnce && button && !button.disabled) {
      window.runsAtOnce = false;
      button.click();
    }
    requestAnimationFrame(look);
  };
  requestAnimationFrame(look);
}

const heard = (page) => page.evaluate(() => window.heard);
const facts = (page) => page.textContent('.geometry .facts');
const hasFact = (page, text) =>
  page.waitForFunction((text) => document.querySelector('.geometry .facts')?.textContent.includes(text), text);

test('many facets are read, drawn as fewer, and looked at; the mesh is made before that ends', async ({ visit, wave }) => {
  const page = await visit('#cells=24&backend=cpu', { prepare: listen });
  await page.evaluate(() => (window.runsAtOnce = true));
  await page.setInputFiles('#file-input', wave);
  await page.waitForSelector('#legend tr', { timeout: 180_000 });
  await hasFact(page, 'closed');
  const stages = (await heard(page)).map(({ stage }) => stage);
  const order = stages.filter(
    (stage, at) => stage !== 'mesh' && stage !== stages.slice(0, at).findLast((other) => other !== 'mesh'),
  );
  assert.deepEqual(order, ['read', 'preview', 'check'], 'one after another');
  assert.ok(stages.lastIndexOf('mesh') < stages.lastIndexOf('check'), 'the mesh goes first');
  for (const stage of ['read', 'preview', 'check']) {
    const shares = (await heard(page)).filter((one) => one.stage === stage).map(({ share }) => share);
    assert.ok(
      shares.length > 2 && shares.at(-1) === 1 && shares.every((share) => share >= 0 && share <= 1),
      `${stage}: ${shares}`,
    );
  }
  const n_drawn = Number(/drawn with ([\d,]+)/.exec(await facts(page))[1].replaceAll(',', ''));
  assert.ok(n_drawn > 100_000 && n_drawn <= 1_000_000, `${n_drawn}`);
  assert.match(await facts(page), /1,207,800, drawn with/);
  // as many as a ball has
  const [[flag, cells]] = await legend(page);
  assert.equal(flag, 1);
  assert.ok(Math.abs(cells / (24 ** 3 * (Math.PI / 6)) - 1) < 0.1, `${cells}`);
  assert.equal(await page.locator('#tasks li').count(), 0);
});

/** In the worker: it rests longer between steps, so that no work is done before it can be ended. */
const SLOW_STEPS = `
  const Plain = MessageChannel;
  globalThis.MessageChannel = class extends Plain {
    constructor() {
      super();
      const post = this.port2.postMessage.bind(this.port2);
      this.port2.postMessage = (message) => setTimeout(post, 100, message);
    }
  };
`;

test('Escape ends reading, drawing and looking at edges, each by itself', async ({ visit, siteWithWorker, wave }) => {
  const page = await visit('#cells=24&backend=cpu', { url: await siteWithWorker(SLOW_STEPS), prepare: listen });
  const endAt = (...stages) => page.evaluate((stages) => (window.endAt = stages), stages);
  /** Progress that came after the end: what was on its way. */
  const isEnded = async (stage) => {
    const all = (await heard(page)).map((one) => one.stage);
    const end = all.lastIndexOf(`end of ${stage}`);
    const after = all.slice(end).filter((one) => one === stage).length;
    assert.ok(end >= 0 && after <= 2, `${after} steps of ${stage} after its end`);
  };
  await endAt('read');
  await page.setInputFiles('#file-input', wave);
  await page.waitForFunction(() => document.querySelector('#status').textContent.startsWith('Cancelled'));
  assert.equal(await page.textContent('#status'), 'Cancelled; wave.stl was not read.');
  await isIdle(page);
  assert.equal(await page.locator('.geometry').count(), 0);
  await isEnded('read');

  // the edges are next, at once
  await endAt('preview', 'check');
  await page.setInputFiles('#file-input', wave);
  await page.getByRole('button', { name: 'Check the edges' }).waitFor();
  await isEnded('preview');
  await isEnded('check');
  assert.match(await facts(page), /not drawn.*edges not checked yet/s);
  await hasGeometries(page, 1);
  await run(page);
  await page.getByRole('button', { name: 'Check the edges' }).click();
  await hasFact(page, 'Surfaceclosed');
  assert.equal(await page.getByRole('button', { name: 'Check the edges' }).count(), 0);
  assert.deepEqual(await page.textContent('#messages'), '');
});

/** In the worker: slices of files come late, as from a slow disk. */
const SLOW_DISK = `
  const read = Blob.prototype.arrayBuffer;
  Blob.prototype.arrayBuffer = async function () {
    await new Promise((resolve) => setTimeout(resolve, 100));
    return read.call(this);
  };
`;

test('work has a bar and a button that ends it, and a model that is removed ends its own', async ({
  visit,
  siteWithWorker,
  wave,
}) => {
  const page = await visit('#cells=24&backend=cpu', { url: await siteWithWorker(SLOW_DISK) });
  await page.setInputFiles('#file-input', wave);
  const line = page.locator('#tasks li');
  await line.waitFor();
  assert.match(await line.textContent(), /^Reading wave\.stl(: \d+ %)?Cancel$/);
  await page.waitForFunction(() => document.querySelector('#tasks progress')?.value > 0);
  await line.getByRole('button', { name: 'Cancel: Reading wave.stl' }).click();
  await page.waitForFunction(() => document.querySelectorAll('#tasks li').length === 0);
  assert.equal(await page.textContent('#status'), 'Cancelled; wave.stl was not read.');
  await page.setInputFiles('#file-input', wave);
  await page.locator('.geometry').waitFor();
  await page.getByRole('button', { name: 'Remove wave' }).click();
  await page.waitForFunction(() => document.querySelectorAll('#tasks li, .geometry').length === 0);
  await page.setInputFiles('#file-input', 'tests/fixtures/spot.stl');
  await hasGeometries(page, 1);
  await run(page);
  assert.equal(await page.textContent('#messages'), '');
});

// While the page meshes: frames go on, Cancel is heeded, and what is shown says which settings it was made with.

import assert from 'node:assert/strict';

import { hasGeometries, isIdle, legend, run, take, test } from './visit.mjs';

/** Before the page's scripts: counts frames, and notes the frame of every word that the worker says of its progress. */
function watchWorker() {
  delete window.showSaveFilePicker;
  window.frames_ = 0;
  window.gaps = [];
  window.heard = [];
  let last = performance.now();
  const frame = (now) => {
    window.frames_ += 1;
    window.gaps.push(now - last);
    last = now;
    requestAnimationFrame(frame);
  };
  requestAnimationFrame(frame);
  const Plain = window.Worker;
  window.Worker = class extends Plain {
    constructor(...options) {
      super(...options);
      this.addEventListener('message', ({ data: { progress } }) => {
        if (progress?.stage === 'mesh') window.heard.push({ share: progress.done / progress.total, frame: window.frames_ });
      });
    }
  };
}

/** In the page: cancels; seconds until it is idle, and until the worker has estimated the job with so many cells on y. */
async function cancel(cells) {
  // what the worker has told already is heard first
  for (let turn = 0; turn < 2; turn += 1) await new Promise((resolve) => setTimeout(resolve));
  const [start, n_before] = [performance.now(), window.heard.length];
  const since = () => (performance.now() - start) / 1000;
  const stopped = new Promise((resolve) => {
    new MutationObserver(() => resolve(since())).observe(document.body, { attributeFilter: ['data-phase'] });
  });
  document.querySelector('#cancel').click();
  const seconds = await stopped;
  while (document.querySelector('#dims-y').value !== cells) await new Promise((resolve) => setTimeout(resolve, 2));
  return { n_before, seconds, untilFree: since() };
}

for (const backend of ['gpu', 'cpu']) {
  test(`Cancel is heeded at the next band, and the next mesh is made (${backend})`, async ({ visit }) => {
    const page = await visit(`#cells=6000&sample=knot&backend=${backend}`, { prepare: watchWorker });
    await hasGeometries(page, 1);
    await page.click('#run');
    await page.fill('#cells', '30');
    await page.waitForFunction(() => window.heard.length >= 3, null, { timeout: 60_000 });
    const { n_before, seconds, untilFree } = await page.evaluate(cancel, '30');
    assert.match(await page.textContent('#status'), /Cancelled/);
    // what was set meanwhile counts now
    assert.equal(await page.inputValue('#dims-y'), '30');
    const before = await page.evaluate(() => window.heard.length);
    await run(page);
    const share = await page.evaluate((at) => window.heard[at - 1].share, before);
    const ms = (seconds) => `${(1000 * seconds).toFixed(1)} ms`;
    console.log(
      `Cancel took ${ms(seconds)} on the page, and the worker was free after ${ms(untilFree)}; it told of ${before - n_before} bands after it, at ${(100 * share).toFixed(0)} %`,
    );
    // one band that came home meanwhile, and one whose message was on its way
    assert.ok(before - n_before <= 2, `${before - n_before} bands after Cancel`);
    assert.ok(share < 0.9, `${share} of the mesh was made`);
    assert.equal((await legend(page)).length, 1);
  });
}

test('frames go on while the page meshes', async ({ visit }) => {
  const page = await visit('#cells=6000&sample=knot&backend=cpu', { prepare: watchWorker });
  await hasGeometries(page, 1);
  await page.evaluate(() => {
    window.gaps.length = 0;
  });
  await page.click('#run');
  await page.waitForFunction(() => window.heard.at(-1)?.share === 1, null, { timeout: 180_000 });
  const { heard, gaps } = await page.evaluate(() => ({ heard: window.heard, gaps: window.gaps.sort((a, b) => a - b) }));
  console.log(
    `${gaps.length} frames; ${gaps[gaps.length >> 1].toFixed(1)} ms between them in the middle, ${gaps.at(-1).toFixed(1)} at most`,
  );
  // a page that waits for its mesh draws no frame until all of it is done; one slow frame takes a part of the work, never most of it
  const shares = new Map([[0, 0], ...heard.map(({ frame, share }) => /** @type {[number, number]} */ ([frame, share]))]);
  const ends = [...shares.values()];
  const most = Math.max(...ends.slice(1).map((end, index) => end - ends[index]));
  assert.ok(most < 0.5, `${(100 * most).toFixed(0)} % of the work was done between two frames`);
  await isIdle(page);
});

test('after a change of settings what is shown is said to be of the last mesh', async ({ visit }) => {
  const page = await visit('#cells=20&backend=gpu');
  await take(page, 'cubes', 2);
  await run(page);
  const isStale = () => page.isVisible('#stale');
  assert.equal(await isStale(), false);
  await page.fill('#cells', '24');
  assert.equal(await isStale(), true);
  await page.fill('#cells', '20');
  assert.equal(await isStale(), false);
  await page.fill('.geometry[data-file="epoxy.stl"] .priority', '1');
  assert.equal(await isStale(), true);
  await page.waitForSelector('#mesh-again:enabled');
  await page.click('#mesh-again');
  await page.waitForSelector('#stale', { state: 'hidden' });
  await isIdle(page);
  assert.deepEqual(await legend(page), [
    [1, 1000],
    [2, 500],
  ]);
  // a colour is no setting of the mesh, another model is
  await page.fill('.geometry[data-file="epoxy.stl"] input[type=color]', '#123456');
  assert.equal(await isStale(), false);
  await page.click('[aria-label="Remove epoxy"]');
  assert.equal(await isStale(), true);
});

test('beside the time that is left no other is told, and a small mesh does not tell of a large one', async ({ visit }) => {
  const page = await visit('#cells=20&sample=knot&backend=cpu');
  await hasGeometries(page, 1);
  assert.equal(await page.textContent('#estimate-time'), 'known after the first mesh');
  await run(page);
  const isKnown = (words) =>
    page.waitForFunction((words) => document.querySelector('#estimate-time')?.textContent.startsWith(words), words);
  await page.fill('#cells', '30');
  await isKnown('about ');
  await page.fill('#cells', '6000');
  await isKnown('known after a larger mesh');
  await page.fill('#cells', '900');
  await isKnown('known after a larger mesh');
  await run(page);
  await page.fill('#cells', '6000');
  await isKnown('about ');
  await page.click('#run');
  await page.waitForFunction(() => document.querySelector('#progress').value > 0);
  assert.ok(await page.isHidden('#estimate-time'));
  await page.click('#cancel');
  await isIdle(page);
  assert.ok(await page.isVisible('#estimate-time'));
});

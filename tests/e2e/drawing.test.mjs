// What the 3-D view draws while a mesh is made that takes the place of another: nothing, and nothing moves. It never keeps the page waiting.

import assert from 'node:assert/strict';

import { cellsAreDrawn, hasGeometries, isIdle, test } from './visit.mjs';

/** Before the page's scripts: keeps how long the longest task of the page's own thread was, in milliseconds, and counts what could draw on it in 3-D. */
function watchTasks() {
  delete window.showSaveFilePicker;
  window.longest = 0;
  window.contexts = 0;
  const { getContext } = HTMLCanvasElement.prototype;
  HTMLCanvasElement.prototype.getContext = function (kind, ...more) {
    if (kind !== '2d') window.contexts += 1;
    return getContext.call(this, kind, ...more);
  };
  new PerformanceObserver((list) => {
    for (const { duration } of list.getEntries()) window.longest = Math.max(window.longest, duration);
  }).observe({ type: 'longtask' });
}

/** Waits until the cells of the last mesh are drawn and nothing is drawn any more. */
async function isDrawn(page) {
  await isIdle(page);
  await cellsAreDrawn(page, 60_000);
  await page.waitForFunction(() => document.querySelector('#canvas-3d').dataset.atRest === 'true', null, { timeout: 60_000 });
}

/** In the page: makes the mesh; pictures and size of the view at the click and when the mesh is there. */
function watchRun() {
  const facts = () => {
    const canvas = document.querySelector('#canvas-3d');
    return { pictures: canvas.dataset.pictures, height: canvas.clientHeight };
  };
  return new Promise((resolve) => {
    const found = { before: facts(), frames: [] };
    const frame = () => {
      if (document.body.dataset.phase !== 'meshing') return;
      found.frames.push(facts());
      requestAnimationFrame(frame);
    };
    new MutationObserver(() => {
      if (document.body.dataset.phase === 'idle') resolve({ ...found, after: facts() });
    }).observe(document.body, { attributeFilter: ['data-phase'] });
    document.querySelector('#run').click();
    requestAnimationFrame(frame);
  });
}

test('while the same job is meshed again nothing is drawn in 3-D; the new mesh is', async ({ visit }) => {
  const page = await visit('#dims=60 2000 2000&axis=x&sample=knot&backend=cpu');
  await hasGeometries(page, 1);
  await page.click('#run');
  await isDrawn(page);
  const { before, frames, after } = await page.evaluate(watchRun);
  console.log(`${frames.length} frames while the mesh was made`);
  assert.ok(frames.length > 3, `${frames.length} frames`);
  for (const facts of [...frames, after]) assert.deepEqual(facts, before);
  await page.waitForFunction(() => document.querySelector('#canvas-3d').dataset.meshes === '2');
  assert.equal(await page.locator('#messages .message').count(), 0);
});

test('while a mesh of 1024 cells is made, drawn and turned, nothing is drawn on the thread of the page', async ({ visit }) => {
  const page = await visit('#cells=1024&sample=gear&backend=cpu', { prepare: watchTasks });
  await hasGeometries(page, 1);
  await page.evaluate(() => {
    window.longest = 0;
  });
  await page.click('#run');
  await isDrawn(page);
  const { x, y, width, height } = await page.locator('#canvas-3d').boundingBox();
  await page.mouse.move(x + width / 2, y + height / 2);
  await page.mouse.down();
  for (let step = 1; step <= 40; step += 1) await page.mouse.move(x + width / 2 + 4 * step, y + height / 2 + step);
  await page.mouse.up();
  const { longest, contexts } = await page.evaluate(() => ({ longest: window.longest, contexts: window.contexts }));
  // for whoever reads it: a time depends on the machine. Drawn by three.js on this thread it was some seconds
  console.log(`the longest task took ${longest} ms`);
  assert.equal(contexts, 0);
});

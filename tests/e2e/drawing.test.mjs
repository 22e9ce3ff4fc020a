// What the 3-D view draws while a mesh is made that takes the place of another: nothing, and nothing moves.

import assert from 'node:assert/strict';

import { hasGeometries, isIdle, test } from './visit.mjs';

/**
 * Before the page's scripts: counts WebGL's draws, those of the surface too, and lets a surface have so few faces that this one is
 * coarsened. It comes some frames after the mesh, so that a frame drawn before it is counted.
 */
function countDraws() {
  delete window.showSaveFilePicker;
  window.n_draws = window.n_surfaces = 0;
  for (const name of ['drawElements', 'drawArrays']) {
    const draw = WebGL2RenderingContext.prototype[name];
    WebGL2RenderingContext.prototype[name] = function (...options) {
      window.n_draws += 1;
      // models have no indices, and a box has few
      if (name === 'drawElements' && options[1] > 100) window.n_surfaces += 1;
      return draw.apply(this, options);
    };
  }
  const post = Worker.prototype.postMessage;
  Worker.prototype.postMessage = function (message, ...options) {
    if (message.operation !== 'skin') return post.call(this, message, ...options);
    message.args.maxQuads = 2000;
    return setTimeout(() => post.call(this, message, ...options), 100);
  };
}

/** Waits until the surface is drawn and no frame draws any more. */
async function isDrawn(page) {
  await isIdle(page);
  await page.waitForFunction(() => /triangles$/.test(document.querySelector('#view-status').textContent));
  await page.waitForFunction(async () => {
    const before = window.n_draws;
    for (let frame = 0; frame < 10; frame += 1) await new Promise((resolve) => requestAnimationFrame(resolve));
    return before > 0 && window.n_draws === before;
  });
}

/** In the page: makes the mesh; draws and sizes of the view at the click and when the mesh is there, and the notice meanwhile. */
function watchRun() {
  const facts = () => ({
    n_draws: window.n_draws,
    height: document.querySelector('#canvas-3d').clientHeight,
    notice: document.querySelector('#messages').textContent,
  });
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

test('while the same job is meshed again nothing is drawn in 3-D and the notice of the coarsened surface stays; the new one is drawn once', async ({
  visit,
}) => {
  const page = await visit('#dims=60 2000 2000&axis=x&sample=knot&backend=cpu', { prepare: countDraws });
  await hasGeometries(page, 1);
  await page.click('#run');
  await isDrawn(page);
  await page.evaluate(() => {
    window.n_surfaces = 0;
  });
  const { before, frames, after } = await page.evaluate(watchRun);
  console.log(`${frames.length} frames while the mesh was made`);
  assert.match(before.notice, /drawn with cells of (\d+) × \1 × \1, because it has too many faces/);
  assert.ok(frames.length > 3, `${frames.length} frames`);
  for (const facts of [...frames, after]) assert.deepEqual(facts, before);
  // the new surface is drawn, and said of anew, once
  await isDrawn(page);
  assert.equal(await page.evaluate(() => window.n_surfaces), 1);
  assert.equal(await page.locator('#messages .message').count(), 1);
});

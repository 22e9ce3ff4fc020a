// What used to end nowhere: a model that was moved out of the view, all models removed, a backend that is not there, no WebGL, an edit
// that was a mistake, a reload.

import assert from 'node:assert/strict';

import { expect } from '@playwright/test';

import { boxBetween } from './open_box.mjs';
import {
  beforeDrawing,
  COPPER,
  hasGeometries,
  cellsAreDrawn,
  isIdle,
  keptFiles,
  legend,
  picture3d,
  run,
  slice,
  take,
  test,
  WITHOUT_WEBGL,
  withoutOffscreen,
} from './visit.mjs';
import { WITHOUT_ADAPTER } from './workers.mjs';

const BOX = boxBetween([0, 0, 0], [4, 2, 2]);

/** Adds files to those of the page, which then has so many. */
async function add(page, files, n_files = Object.keys(files).length) {
  const payload = Object.entries(files).map(([name, text]) => ({ name, mimeType: 'model/stl', buffer: Buffer.from(text) }));
  await page.setInputFiles('#file-input', payload);
  await hasGeometries(page, n_files);
}

/** The share of the saved picture of the 3-D view that models cover. */
async function covered(page) {
  return (await picture3d(page)).evaluate(({ data }) => {
    let n = 0;
    // the background is transparent
    for (let at = 0; at < data.length; at += 4) n += data[at + 3] === 255 && Math.abs(data[at] - data[at + 2]) > 30;
    return n / (data.length / 4);
  });
}

test('a model that is moved or scaled stays in the view, and its card has the size and place that it has now', async ({
  visit,
}) => {
  const page = await visit('#cells=20&backend=cpu');
  await add(page, { 'box.stl': BOX });
  const before = await covered(page);
  assert.ok(before > 0.05, `${before}`);
  await page.click('.geometry summary');
  const facts = () => page.$eval('.geometry .facts', (list) => list.innerText.replace(/\s+/g, ' '));
  await page.fill('.geometry .translate', '100 0 0');
  assert.match(await facts(), /Size 4 × 2 × 2 From 100, 0, 0 To 104, 2, 2 Volume 16/);
  assert.ok((await covered(page)) > 0.9 * before);
  await page.fill('.geometry .rotate', '0 0 90');
  assert.match(await facts(), /Size 2 × 4 × 2 From 98, 0, 0 To 100, 4, 2/);
  await page.fill('.geometry .scale', '25.4');
  assert.match(await facts(), /Size 50\.8 × 101\.6 × 50\.8 .* Volume 262193/);
  assert.ok((await covered(page)) > 0.5 * before);
  // ends that are far from zero are told apart
  await page.fill('.geometry .scale', '');
  await page.fill('.geometry .rotate', '');
  await page.fill('.geometry .translate', '10000000 0 0');
  assert.match(await facts(), /From 10000000, 0, 0 To 10000004, 2, 2/);
});

test('once all models are removed the mesh is shown by its cells', async ({ visit }) => {
  const page = await visit('#cells=20&backend=cpu');
  await add(page, { 'box.stl': BOX });
  await run(page);
  await cellsAreDrawn(page);
  await page.check('#show-model');
  await page.click('.geometry button[aria-label^=Remove]');
  await page.waitForSelector('.geometry', { state: 'detached' });
  assert.ok(await page.isChecked('#show-cells'));
  assert.ok(await page.isDisabled('#show-model'));
  assert.ok((await covered(page)) > 0.05);
});

test('where a backend is not there, the last one and its mesh stay', async ({ visit, siteWithWorker }) => {
  const page = await visit('#cells=20&sample=cubes', { url: await siteWithWorker(WITHOUT_ADAPTER) });
  await hasGeometries(page, 2);
  await run(page);
  await page.click('#settings summary');
  await page.selectOption('#backend', 'gpu');
  await page.waitForSelector('#messages [data-code=no-adapter]');
  await isIdle(page);
  assert.equal(await page.inputValue('#backend'), 'auto');
  assert.equal(await page.getAttribute('#device', 'data-backend'), 'cpu');
  assert.equal((await legend(page)).length, 2);
  assert.equal((await slice(page, 'z', 2))[2][2], COPPER);
  await run(page);
  // a backend that is there leaves the mesh, too, until there is another
  await page.selectOption('#backend', 'cpu');
  await page.waitForFunction(() => document.querySelector('#device').textContent === 'Meshing on the processor');
  await isIdle(page);
  assert.equal((await legend(page)).length, 2);
  assert.equal((await slice(page, 'z', 3))[2][2], COPPER);
  assert.ok(await page.isHidden('#stale'));
  await run(page);
  assert.equal((await slice(page, 'z', 2))[2][2], COPPER);
});

for (const [what, prepare] of Object.entries({ 'WebGL 2': undefined, 'canvases in workers': withoutOffscreen }))
  test(`without ${what} the page says so, offers no tool of the 3-D view, and does all else`, async ({ visit }) => {
    const page = await visit('#cells=20&backend=cpu', { prepare });
    if (!prepare) await beforeDrawing(page, WITHOUT_WEBGL);
    await take(page, 'cubes', 2);
    await page.waitForSelector('#no-3d:visible');
    assert.match(await page.textContent('#no-3d'), /no WebGL 2 for workers: there is no 3-D view/);
    await run(page);
    for (const id of ['fit', 'save-3d', 'show-model', 'show-cells']) assert.ok(await page.isDisabled(`#${id}`), id);
    assert.ok(await page.isHidden('#section'));
    assert.equal(await page.getAttribute('#canvas-3d', 'tabindex'), '-1');
    assert.equal((await slice(page, 'z', 2))[2][2], COPPER);
  });

/** Loses the context of the worker that draws when it is told so, and gives it back. */
const LOSE_CONTEXT = `{
  const { getContext } = OffscreenCanvas.prototype;
  let lose;
  OffscreenCanvas.prototype.getContext = function (...options) {
    const gl = getContext.apply(this, options);
    lose ??= gl.getExtension('WEBGL_lose_context');
    return gl;
  };
  new BroadcastChannel('context').onmessage = () => {
    lose.loseContext();
    setTimeout(() => lose.restoreContext(), 300);
  };
}`;

test('a picture whose context is lost is drawn again once there is another', async ({ visit }) => {
  const page = await visit('#cells=20&backend=cpu');
  await beforeDrawing(page, LOSE_CONTEXT);
  await add(page, { 'box.stl': BOX });
  await run(page);
  await cellsAreDrawn(page);
  const before = await covered(page);
  assert.ok(before > 0.05, `${before}`);
  await page.evaluate(() => new BroadcastChannel('context').postMessage('lose'));
  await page.waitForTimeout(1500);
  assert.ok(Math.abs((await covered(page)) / before - 1) < 0.01);
});

test('every edit is undone and done again, with buttons and keys', async ({ visit }) => {
  const page = await visit('#cells=20&backend=cpu');
  assert.ok(await page.isDisabled('#undo'));
  await add(page, { 'box.stl': BOX });
  await page.waitForSelector('#undo:enabled');
  const edits = [
    ['#cells', () => page.fill('#cells', '30'), '20', '30'],
    ['.geometry .flag', () => page.fill('.geometry .flag', '7'), '1', '7'],
    ['.geometry .name', () => page.fill('.geometry .name', 'other'), 'box', 'other'],
    ['.geometry [type=color]', () => page.fill('.geometry [type=color]', '#112233'), '#e83458', '#112233'],
    ['#unit', () => page.selectOption('#unit', 'mm'), '', 'mm'],
  ];
  for (const [, act] of edits) {
    await act();
    await page.waitForTimeout(600);
  }
  const [link] = [page.url()];
  for (const [field, , before, after] of [...edits].reverse()) {
    assert.equal(await page.inputValue(field), after, field);
    await page.click('#undo');
    await isIdle(page);
    await page.waitForFunction(([field, value]) => document.querySelector(field).value === value, [field, before]);
  }
  await page.click('#undo');
  await page.waitForSelector('.geometry', { state: 'detached' });
  assert.ok(await page.isDisabled('#undo'));
  // a file that was removed is read again
  await page.locator('#panes-3d').focus();
  for (let edit = 0; edit <= edits.length; edit += 1) {
    await page.waitForSelector('#redo:enabled');
    await page.keyboard.press('ControlOrMeta+Shift+Z');
    await page.waitForFunction(() => document.querySelector('#status').textContent === 'Done again.');
    await page.evaluate(() => (document.querySelector('#status').textContent = ''));
    await isIdle(page);
  }
  for (const [field, , , after] of edits) assert.equal(await page.inputValue(field), after, field);
  await page.waitForFunction((link) => location.href === link, link);
  await run(page);
  assert.equal((await legend(page))[0][0], 7);
});

test('a reload asks once whether to open the files again, and the next ones open them', async ({ visit, site }) => {
  const page = await visit('#cells=20&backend=cpu');
  await add(page, { 'box.stl': BOX, 'far.stl': boxBetween([6, 0, 0], [8, 2, 2]) });
  await page.fill('.geometry[data-file="far.stl"] .flag', '9');
  await expect.poll(() => keptFiles(page)).toEqual(['box.stl', 'far.stl']);
  await page.reload();
  await isIdle(page);
  const question = page.locator('#messages [data-about=session]');
  assert.match(await question.textContent(), /^The last visit had box\.stl, far\.stl\./);
  assert.equal(await page.locator('.geometry').count(), 0);
  await page.getByRole('button', { name: 'Open again' }).click();
  await hasGeometries(page, 2);
  assert.equal(await page.inputValue('.geometry[data-file="far.stl"] .flag'), '9');
  await run(page);
  assert.deepEqual(
    (await legend(page)).map(([flag]) => flag),
    [1, 9],
  );
  // Back, too, without a question
  await page.goto('about:blank');
  await page.goBack();
  await hasGeometries(page, 2);
  assert.equal(await page.inputValue('.geometry[data-file="far.stl"] .flag'), '9');
  assert.equal(await question.count(), 0);
  // a link with other settings is not changed by them
  await page.goto('about:blank');
  await page.goto(`${site}#cells=33&backend=cpu`);
  await isIdle(page);
  await page.getByRole('button', { name: 'Open again' }).waitFor();
  assert.equal(await page.inputValue('#cells'), '33');
  await page.goBack();
  await page.goBack();
  await hasGeometries(page, 2);
  // what is forgotten is not asked for again
  await page.getByRole('button', { name: 'Forget' }).click();
  await expect.poll(() => keptFiles(page)).toEqual([]);
  await page.reload();
  await isIdle(page);
  assert.equal(await question.count(), 0);
});

test('a link says which files it waits for', async ({ visit }) => {
  const page = await visit(`#cells=20&backend=cpu&g=${encodeURIComponent('file=box.stl&flag=3')}`);
  assert.equal(await page.textContent('#waiting'), 'This link has settings for box.stl: drop or choose that file.');
  await add(page, { 'box.stl': BOX });
  assert.equal(await page.inputValue('.geometry .flag'), '3');
  assert.ok(await page.isHidden('#waiting'));
  const other = await visit('#cells=20&sample=cubes');
  await hasGeometries(other, 2);
  assert.ok(await other.isHidden('#waiting'));
});

// Small things that were seen on the page: words, places, order, focus, and what phones, tablets and forced colours show.

import assert from 'node:assert/strict';

import { expect } from '@playwright/test';

import { boxBetween } from './open_box.mjs';
import { cellsAreDrawn, hasGeometries, legend, picture3d, run, saved, slice, take, test } from './visit.mjs';

const BOX = boxBetween([0, 0, 0], [4, 2, 2]);
const PHONE = { width: 390, height: 844 };
const TABLET = { width: 820, height: 1180 };

/** Adds files to those of the page, which then has so many. */
async function add(page, files, n_files = Object.keys(files).length) {
  const payload = Object.entries(files).map(([name, text]) => ({ name, mimeType: 'model/stl', buffer: Buffer.from(text) }));
  await page.setInputFiles('#file-input', payload);
  await hasGeometries(page, n_files);
}

const box = (page, selector) => page.$eval(selector, (element) => element.getBoundingClientRect().toJSON());

test('labels and errors speak of parts, and of what helps', async ({ visit }) => {
  const page = await visit('#cells=20&padding=2&backend=cpu');
  assert.match(
    await page.textContent('.tagline'),
    /^Turn STL files into an exact voxel mesh, in your browser\. For FDTD, LBM, CFD, FEM\./,
  );
  await page.click('#help-open');
  assert.match(await page.textContent('#help[open]'), /FDTD .* lattice Boltzmann .* CFD .* FEM/s);
  assert.match(await page.getAttribute('#licences', 'href'), /README/);
  await page.keyboard.press('Escape');
  await add(page, { 'box.stl': BOX, 'cubeB.stl': boxBetween([6, 0, 0], [8, 2, 2]) });
  assert.equal(await page.textContent('#estimate-padding'), '20 along the parts, 24 with the padding');
  for (const summary of await page.$$('.scroll summary:visible')) await summary.click();
  const text = await page.textContent('.side');
  for (const words of [
    'Scale, rotate, move',
    'Set the domain box',
    'Align the grid to part boundaries (cells may shrink)',
    'Inside test',
    'even-odd',
    'unspecified',
  ])
    assert.ok(text.includes(words), words);
  await page.fill('.geometry[data-file="cubeB.stl"] .scale', '0');
  assert.equal(await page.textContent('#field-error'), 'Scale of cubeB must not be 0.');
  await page.fill('.geometry[data-file="cubeB.stl"] .scale', '1e-300');
  await page.waitForSelector('#estimate-error, #estimate-cells');
  assert.doesNotMatch(await page.textContent('#estimate'), /geometries\[/);
});

test('what the head of the page says is no warning, and numbers have as many digits as people read', async ({ visit }) => {
  const page = await visit('#sample=cubes&cells=20');
  await hasGeometries(page, 2);
  await run(page);
  assert.match(JSON.parse(await page.textContent('#report')).fallback, /computes on the processor/);
  assert.ok(await page.isHidden('#findings'));
  assert.doesNotMatch(await page.textContent('#result-facts'), /runs/);
  const other = await visit('#cell_size=0.5&backend=cpu');
  await add(other, { 'box.stl': BOX, 'plate.stl': boxBetween([0, 0, 6.3], [8, 4, 6.4]) });
  await run(other);
  assert.match(await other.textContent('#finding-list'), /it is 0\.0999999 thick along z/);
});

test('the last of equal priority wins: cards change places with Alt and an arrow key, and by dragging', async ({ visit }) => {
  const page = await visit('#cell_size=1&backend=cpu');
  await add(page, { 'a.stl': BOX, 'b.stl': boxBetween([2, 0, 0], [6, 2, 2]) });
  await page.setViewportSize({ width: 1280, height: 1200 });
  const order = () => page.$$eval('.geometry', (cards) => cards.map(({ dataset }) => dataset.file));
  await run(page);
  assert.deepEqual(await legend(page), [
    [1, 8],
    [2, 16],
  ]);
  await page.focus('.geometry[data-file="b.stl"] .handle');
  await page.keyboard.press('Alt+ArrowUp');
  assert.deepEqual(await order(), ['b.stl', 'a.stl']);
  assert.equal(await page.textContent('#status'), 'b is part 1 of 2.');
  assert.ok(await page.$eval('.geometry[data-file="b.stl"] .handle', (handle) => handle === document.activeElement));
  assert.ok(await page.isVisible('#stale'));
  await run(page);
  assert.deepEqual(await legend(page), [
    [1, 16],
    [2, 8],
  ]);
  const [from, to] = [
    await box(page, '.geometry[data-file="a.stl"] .handle'),
    await box(page, '.geometry[data-file="b.stl"] .name'),
  ];
  await page.mouse.move(from.left + 8, from.top + 8);
  await page.mouse.down();
  await page.mouse.move(to.left + 20, to.top + 8, { steps: 8 });
  await page.mouse.move(to.left + 24, to.top + 5, { steps: 3 });
  await page.mouse.up();
  assert.deepEqual(await order(), ['a.stl', 'b.stl']);
  assert.ok(!(await page.evaluate(() => document.body.classList.contains('dropping'))), 'a card is no file');
});

test('a name is not of the cells: the mesh stays, and the page says whose names its files have', async ({ visit }) => {
  const page = await visit('#cells=20&sample=cubes&backend=cpu');
  await hasGeometries(page, 2);
  await run(page);
  await page.fill('.geometry .name', 'other');
  assert.equal(await page.textContent('#stale-text'), 'The cells are right; the files of this mesh have the former names.');
  assert.ok(!(await page.evaluate(() => document.body.classList.contains('stale'))));
  await page.fill('#cells', '21');
  assert.match(await page.textContent('#stale-text'), /^Made with other settings/);
  // no two files have one name
  const names = await page.$$eval('#downloads small', (notes) => notes.map(({ textContent }) => textContent.split(':')[0]));
  assert.equal(new Set(names).size, names.length, `${names}`);
  assert.equal((await saved(page, '#download-vtiz')).name, 'copper.zlib.vti');
});

test('a unit of a link is a word, and one that is not in the list is kept', async ({ visit }) => {
  const page = await visit('#unit=parsec%3Cb%3E&sample=cubes&cells=20&backend=cpu');
  await hasGeometries(page, 2);
  assert.equal(await page.inputValue('#unit'), '');
  await expect.poll(() => page.url()).not.toMatch(/parsec/);
  const other = await visit('#unit=parsec&sample=cubes&cells=20&backend=cpu');
  await hasGeometries(other, 2);
  assert.equal(await other.inputValue('#unit'), 'parsec');
  await run(other);
  assert.match(await other.textContent('#result-size'), / parsec$/);
});

test('the focus goes to what is near where something is removed, and nothing scrolls at Run', async ({ visit }) => {
  const page = await visit('#cells=20&backend=cpu');
  await page.setViewportSize({ width: 1280, height: 800 });
  await add(page, { 'a.stl': BOX, 'b.stl': boxBetween([6, 0, 0], [8, 2, 2]) });
  const scrolled = () => page.$eval('.scroll', ({ scrollTop }) => scrollTop);
  await page.$eval('.scroll', (side) => side.scrollTo(0, 120));
  const before = await scrolled();
  await page.focus('#run');
  await run(page);
  await cellsAreDrawn(page);
  assert.equal(await scrolled(), before);
  const isLost = () => page.evaluate(() => document.activeElement === document.body);
  await page.locator('button[aria-label="Remove a"]').press('Enter');
  await hasGeometries(page, 1);
  assert.ok(!(await isLost()));
  await add(page, { 'notes.stl': 'read me' }, 1);
  await page.getByRole('button', { name: 'Dismiss message' }).press('Enter');
  assert.ok(!(await isLost()));
});

test('the cut in 3-D has a position, and the stage does not move from plane to plane', async ({ visit }) => {
  const page = await visit('#cells=20&sample=cubes&unit=mm&backend=cpu');
  await page.setViewportSize({ width: 1440, height: 900 });
  await hasGeometries(page, 2);
  await run(page);
  await cellsAreDrawn(page);
  await page.selectOption('#section-axis', '0');
  assert.equal(await page.textContent('#section-where'), 'x = 10.5 mm');
  await slice(page, 'x', 0);
  const { left, top, width, height } = await box(page, '#canvas-x');
  // the mouse names the cell under it, with its place
  await page.mouse.move(left + width / 2, top + height / 2);
  assert.match(await page.textContent('#readout'), /^cell 0, \d+, \d+ at .* mm: flag \d/);
  for (const index of [1, 9, 10, 19]) {
    await slice(page, 'x', index);
    assert.equal((await box(page, '#canvas-x')).top, top, `${index}`);
  }
});

test('on a tablet the picture stays as large after meshing', async ({ visit }) => {
  const page = await visit('#cells=20&sample=cubes&backend=cpu');
  await page.setViewportSize(TABLET);
  await hasGeometries(page, 2);
  const before = await box(page, '#canvas-3d');
  await run(page);
  await cellsAreDrawn(page);
  const after = await box(page, '#canvas-3d');
  assert.ok(after.height > 0.85 * before.height, `${after.height} of ${before.height}`);
  assert.ok(after.bottom <= TABLET.height);
});

/** In the page: pixels of models in the first and the last columns of a picture, and in all of it. */
function modelPixels({ data, width }) {
  const n = [0, 0];
  for (let at = 0; at < data.length; at += 4) {
    const x = (at / 4) % width;
    // the background is transparent
    if (data[at + 3] < 255 || Math.abs(data[at] - data[at + 2]) <= 30) continue;
    n[1] += 1;
    if (x < 3 || x >= width - 3) n[0] += 1;
  }
  return n;
}

test('where the window becomes narrow, or wide again, the whole model is still in view', async ({ visit }) => {
  const page = await visit('#cells=20&backend=cpu');
  await page.setViewportSize({ width: 1280, height: 800 });
  await add(page, { 'plate.stl': boxBetween([0, 0, 0], [8, 8, 4]) });
  const seen = async () => (await picture3d(page)).evaluate(modelPixels);
  const [, before] = await seen();
  await page.setViewportSize({ width: 820, height: 1180 });
  const [cut, there] = await seen();
  assert.deepEqual([cut, there > 10_000], [0, true]);
  await page.setViewportSize({ width: 1280, height: 800 });
  const [, after] = await seen();
  assert.ok(Math.abs(after / before - 1) < 0.02, `${after} of ${before}`);
});

test('on a phone the model is seen at once, slices are pinched, swiped past and tapped', async ({ visit }) => {
  const page = await visit('#cells=20&backend=cpu');
  await page.setViewportSize(PHONE);
  await take(page, 'cubes', 2);
  const seen = await box(page, '#canvas-3d');
  assert.ok(seen.top >= 0 && seen.bottom <= PHONE.height, `from ${seen.top} to ${seen.bottom}`);
  await run(page);
  await slice(page, 'z', 2);
  await page.locator('#canvas-z').scrollIntoViewIfNeeded();
  const touch = (type, id, x, y) =>
    page.dispatchEvent('#canvas-z', type, {
      pointerId: id,
      pointerType: 'touch',
      clientX: x,
      clientY: y,
      buttons: 1,
      bubbles: true,
    });
  // pointers that are dispatched cannot be captured
  await page.$eval('#canvas-z', (canvas) => (canvas.setPointerCapture = () => {}));
  const { left, top, width, height } = await box(page, '#canvas-z');
  const [x, y] = [left + width / 2, top + height / 2];
  await touch('pointerdown', 1, x - 60, y + 20);
  await touch('pointerup', 1, x - 60, y + 20);
  assert.match(await page.textContent('#readout'), /^cell \d+, \d+, 2 at .*: flag 1, copper$/);
  assert.equal(await page.$eval('#canvas-z', (canvas) => getComputedStyle(canvas).touchAction), 'pan-y');
  await touch('pointerdown', 1, x - 20, y);
  await touch('pointerdown', 2, x + 20, y);
  await touch('pointermove', 2, x + 60, y);
  await touch('pointerup', 1, x - 20, y);
  await touch('pointerup', 2, x + 60, y);
  await expect.poll(async () => Number(await page.getAttribute('#canvas-z', 'data-zoom'))).toBeGreaterThan(1.5);
  assert.equal(await page.$eval('#canvas-z', (canvas) => getComputedStyle(canvas).touchAction), 'none');
});

test('in forced colours the swatches of flags keep their colours', async ({ visit }) => {
  const page = await visit('#cells=20&sample=cubes&backend=cpu');
  await hasGeometries(page, 2);
  await run(page);
  await page.emulateMedia({ forcedColors: 'active' });
  assert.deepEqual(
    await page.$$eval('.swatch', (swatches) => swatches.map((swatch) => getComputedStyle(swatch).backgroundColor)),
    ['rgb(217, 131, 36)', 'rgb(58, 143, 201)'],
  );
});

test('two samples are real models', async ({ visit }) => {
  const page = await visit('#cells=40&backend=cpu');
  await take(page, 'spot', 1);
  assert.match(await page.textContent('.geometry .facts'), /Facets5,856.*Surfaceclosed$/);
  await page.click('#more-samples summary');
  await page.click('#more-samples [data-sample=part]');
  await page.waitForSelector('.geometry[data-file="machined-part.stl"]');
  assert.match(await page.textContent('.geometry .facts'), /not closed: 576 open edges/);
});

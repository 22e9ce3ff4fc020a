// What a mesh found: thin walls, overlaps, geometries without cells; each a line, a mark in 3-D and in the slices, and a place to go to.

import assert from 'node:assert/strict';
import { mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';

import { expect } from '@playwright/test';

import { openEdges } from '../../www/page/view/cast/open_edges.js';
import { runCopied } from './native.mjs';
import { CLOSED_BOX, OPEN_BOX, boxBetween } from './open_box.mjs';
import { cellsAreDrawn, hasGeometries, legend, picture3d, run, test } from './visit.mjs';

/** Two blocks that overlap in 1 x 4 x 4, a plate thinner than a cell, and a block within another that wins. */
const FILES = {
  'left.stl': boxBetween([0, 0, 0], [4, 4, 4]),
  'right.stl': boxBetween([3, 0, 0], [8, 4, 4]),
  'plate.stl': boxBetween([0, 0, 6.1], [8, 4, 6.4]),
};
const CURRENT = [0xe0, 0x10, 0x3c];
const OTHER = [0x7d, 0x2f, 0xb8];

/** Opens the page with files. */
async function visitWith(visit, hash, files, how = {}) {
  const page = await visit(hash, how);
  const payload = Object.entries(files).map(([name, text]) => ({ name, mimeType: 'model/stl', buffer: Buffer.from(text) }));
  await page.setInputFiles('#file-input', payload);
  // a live page meshes by itself
  if (!how.live) await hasGeometries(page, payload.length);
  return page;
}

/** The report on the page. */
async function report(page) {
  return JSON.parse(await page.textContent('#report'));
}

/** Pixels of a colour in the saved picture of the 3-D view, and their mean place as shares of width and height. */
async function pixels(page, colour) {
  return (await picture3d(page)).evaluate(({ data, width, height }, colour) => {
    const sum = [0, 0, 0];
    for (let at = 0; at < data.length; at += 4) {
      if (!colour.every((part, channel) => Math.abs(data[at + channel] - part) <= 9)) continue;
      sum[0] += (at / 4) % width;
      sum[1] += Math.floor(at / 4 / width);
      sum[2] += 1;
    }
    return { n: sum[2], at: [sum[0] / sum[2] / width, sum[1] / sum[2] / height] };
  }, colour);
}

/** Waits until the view has come to a place. */
function isAt(page, place) {
  return page.waitForSelector(`#canvas-3d[data-place="${place.join(' ')}"]`, { state: 'attached' });
}

/** Numbers of marks in the slice that is shown, once it is the one of an index. */
async function marksAt(page, axis, index) {
  await page.waitForSelector(`#canvas-${axis}[data-index="${index}"]`);
  return Number(await page.getAttribute(`#canvas-${axis}`, 'data-marks'));
}

test('thin walls and overlaps are looked for where the box is ticked, and the native command finds the same', async ({
  visit,
}) => {
  const folder = mkdtempSync(path.join(tmpdir(), 'hexcast-'));
  try {
    const page = await visitWith(visit, '#cell_size=0.5&backend=cpu', FILES);
    await page.click('#settings summary');
    assert.ok(await page.isHidden('#thin-cells'));
    await page.getByLabel('Look for thin walls and overlaps').check();
    await page.fill('#thin-cells', '3');
    await run(page);
    const { certificate } = await report(page);
    assert.equal(certificate.thin_cells, 3);
    assert.deepEqual(
      certificate.thin_walls.map(({ geometry, axis, lost }) => [geometry, axis, lost > 0]),
      [['plate', 'z', false]],
    );
    assert.deepEqual(
      certificate.overlaps.map(({ winner, loser, cells, volume }) => [winner, loser, cells, volume]),
      [['right', 'left', 128, 16]],
    );
    for (const [name, text] of Object.entries(FILES)) writeFileSync(path.join(folder, name), text);
    assert.deepEqual((await runCopied(page, folder, [])).certificate, certificate);
    assert.match(await page.inputValue('#copied-text'), / --certify --thin-cells=3 /);
    await page.click('#copy-link');
    const other = await visit(new URL(await page.inputValue('#copied-text')).hash);
    assert.deepEqual([await other.isChecked('#certify'), await other.inputValue('#thin-cells')], [true, '3']);
  } finally {
    rmSync(folder, { recursive: true });
  }
});

test('each finding is a line and a mark, and next flies to it in 3-D and in the slices', async ({ visit }) => {
  // a plate between two rows of centres has no cell at all
  const files = { ...FILES, 'plate.stl': boxBetween([0, 0, 6.3], [8, 4, 6.4]) };
  const page = await visitWith(visit, '#cell_size=0.5&backend=cpu&certify=true', files);
  await run(page);
  const { certificate, geometries } = await report(page);
  const kinds = await page.$$eval('#finding-list li', (lines) => lines.map((line) => line.dataset.kind));
  assert.deepEqual(kinds, ['wall-thin', 'no-cell-thin', 'overlap']);
  const lines = await page.locator('#finding-list li p').allTextContents();
  assert.match(lines[0], /^Geometry "plate" has walls of fewer than 2 cells along z: 128 ray segments, .* of 0 cells at /);
  assert.match(
    lines[1],
    /^Geometry "plate" \(flag 3\) got no cell: it is 0\.\d+ thick along z, a cell is 0\.5; use smaller cells/,
  );
  assert.match(lines[2], /^right and left overlap in 128 cells, a volume of 16: right has them\.$/);
  await cellsAreDrawn(page);
  assert.equal((await pixels(page, CURRENT)).n, 0);
  assert.ok((await pixels(page, OTHER)).n > 20, 'all are marked');
  const [low, high] = geometries[2].bounding_box;
  const middle = low.map((at, axis) => (at + high[axis]) / 2);
  const places = [certificate.thin_walls[0].place, middle, certificate.overlaps[0].place];
  for (const [at, place] of places.entries()) {
    await page.press('#finding-next', 'Enter');
    await isAt(page, place);
    assert.equal(await page.textContent('#finding-at'), `${at + 1} of 3: ${lines[at]}`, 'it is announced');
    assert.equal(await page.getAttribute(`#finding-list li:nth-child(${at + 1})`, 'aria-current'), 'true');
    const { at: seen, n } = await pixels(page, CURRENT);
    assert.ok(n > 20 && Math.abs(seen[0] - 0.5) < 0.01 && Math.abs(seen[1] - 0.5) < 0.01, `${seen}`);
  }
  // in the slices, and backwards
  await page.check('#panes-x');
  assert.equal(
    await marksAt(page, 'x', Math.floor(places[2][0] / 0.5)),
    places.filter((place) => Math.floor(place[0] / 0.5) === Math.floor(places[2][0] / 0.5)).length,
  );
  await page.click('#finding-previous');
  assert.ok(await page.isVisible('#pane-x'), 'the view that is shown stays');
  assert.ok((await marksAt(page, 'x', Math.floor(places[1][0] / 0.5))) >= 1);
  // what helps
  await page.getByRole('button', { name: 'Keep thin walls' }).first().click();
  assert.equal(await fillOf(page, 'plate'), 'separating');
  await run(page);
  assert.doesNotMatch(await page.textContent('#finding-list'), /got no cell/);
});

test('the camera flies to a finding in some frames, and is there at once for people who want no motion', async ({ visit }) => {
  const page = await visitWith(visit, '#cell_size=0.5&backend=cpu&certify=true', FILES);
  await run(page);
  const framesTo = (/** @type {string} */ button) =>
    page.evaluate(async (button) => {
      const { dataset } = document.querySelector('#canvas-3d');
      document.querySelector(button).click();
      let n = 0;
      do {
        await new Promise(requestAnimationFrame);
        n += 1;
      } while (!dataset.place);
      return n;
    }, button);
  await framesTo('#finding-next');
  assert.ok((await framesTo('#finding-next')) > 1);
  await page.emulateMedia({ reducedMotion: 'reduce' });
  assert.equal(await framesTo('#finding-previous'), 1);
});

/** A plate between two rows of centres, which has no cell, beside a block. */
const LOST = { 'block.stl': boxBetween([0, 0, 0], [8, 4, 4]), 'plate.stl': boxBetween([0, 0, 6.3], [8, 4, 6.4]) };
/** Which cells along its surface a part is given. */
const fillOf = (page, name) => page.getByLabel(`Cells of ${name}`, { exact: true }).inputValue();
const counter = (page, name) => page.getByRole('button', { name, exact: true });

/** Opens the page with the plate as cells, meshed without a click. */
async function visitLost(visit) {
  const page = await visitWith(visit, '#cell_size=0.5&backend=cpu', LOST, { live: true });
  await expect(counter(page, '1 problem')).toBeVisible();
  await cellsAreDrawn(page);
  return page;
}

test('a problem is a card with a picture of its place, and their number is seen on every screen', async ({ visit }) => {
  const page = await visitLost(visit);
  for (const [width, height] of [
    [1440, 900],
    [390, 844],
  ]) {
    await page.setViewportSize({ width, height });
    await page.evaluate(() => scrollTo(0, 0));
    await expect(counter(page, '1 problem')).toBeInViewport({ ratio: 1 });
  }
  const card = page.getByRole('list', { name: 'Problems' }).getByRole('listitem');
  await expect(card.getByRole('heading', { name: 'No cells for plate' })).toBeVisible();
  const place = card.getByRole('button', { name: 'Show the place: plate along z, problem 1' });
  await place.scrollIntoViewIfNeeded();
  await expect(place.locator('canvas')).toBeVisible();
  // the plate has its colour, the block is grey
  const [n_blue, n_grey, n_clear] = await place.locator('canvas').evaluate((canvas) => {
    const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
    const n = [0, 0, 0];
    for (let at = 0; at < data.length; at += 4) {
      const [r, g, b, a] = data.subarray(at, at + 4);
      n[a === 0 ? 2 : b - r > 60 ? 0 : Math.abs(b - r) < 40 && Math.abs(g - r) < 20 ? 1 : 3] += 1;
    }
    return n;
  });
  assert.ok(n_blue > 500 && n_grey > 500 && n_clear > 500, `${n_blue} ${n_grey} ${n_clear}`);
});

test('an offer is drawn while it is pointed at or has the focus, and is undone once it was taken', async ({ visit }) => {
  const page = await visitLost(visit);
  const before = await legend(page);
  // that it is thicker then than its surface is a problem, too
  const lost = page.getByRole('heading', { name: 'No cells for plate' });
  const n_meshes = () => page.getAttribute('#canvas-3d', 'data-meshes').then(Number);
  const first = await n_meshes();
  const offer = page.getByRole('button', { name: /^Keep thin walls/ });
  const said = page.getByRole('region', { name: 'View' }).getByText(/plate [1-9]\d* \(now 0\)/);
  await offer.hover();
  await expect(said).toBeVisible();
  await expect.poll(n_meshes).toBe(first + 1);
  assert.deepEqual([await legend(page), await fillOf(page, 'plate')], [before, ''], 'the job and the mesh stay');
  await page.mouse.move(0, 0);
  await expect(said).toHaveCount(0);
  await expect.poll(n_meshes, 'the cells of the page come back').toBe(first + 2);
  await page.waitForSelector('#canvas-3d[data-at-rest=true]');
  // by key
  await offer.focus();
  await expect(said).toBeVisible();
  await page.keyboard.press('Enter');
  assert.equal(await fillOf(page, 'plate'), 'separating');
  await expect(lost).toHaveCount(0);
  const flags = new Map(await legend(page));
  assert.ok(flags.get(2) > 0, JSON.stringify([...flags]));
  await page.getByRole('button', { name: 'Undo it' }).click();
  await expect(lost).toBeVisible();
  assert.deepEqual([await legend(page), await fillOf(page, 'plate')], [before, '']);
  // and by Ctrl+Z
  await offer.click();
  await expect(lost).toHaveCount(0);
  await page.keyboard.press('Control+z');
  await expect(lost).toBeVisible();
  assert.deepEqual(await legend(page), before);
});

test('an offer whose mesh would wait for a click only says what it changes', async ({ visit }) => {
  const page = await visitWith(visit, '#cell_size=0.5&backend=cpu', LOST);
  await run(page);
  await cellsAreDrawn(page);
  const n_meshes = await page.getAttribute('#canvas-3d', 'data-meshes');
  await page.getByRole('button', { name: /^Keep thin walls/ }).hover();
  await expect(page.getByText('plate: keep thin walls.', { exact: true })).toBeVisible();
  await page.waitForTimeout(500);
  assert.equal(await page.getAttribute('#canvas-3d', 'data-meshes'), n_meshes);
});

/** The corners of an ASCII STL. */
const cornersOf = (text) =>
  Float32Array.from([...text.matchAll(/vertex (\S+) (\S+) (\S+)/g)].flatMap((found) => found.slice(1).map(Number)));

test('open edges are those that an odd number of facets have, and all of them are drawn', async ({ visit }) => {
  assert.equal(openEdges(cornersOf(CLOSED_BOX)).length, 0);
  const open = openEdges(cornersOf(OPEN_BOX));
  assert.equal(open.length, 4 * 6);
  for (let at = 2; at < open.length; at += 3) assert.equal(open[at], 2, 'the upper side is missing');
  // 0 and -0 are one place, and a facet with two equal corners has no edge
  const zero = cornersOf(CLOSED_BOX).map((number) => (number === 0 ? -0 : number));
  zero.set(cornersOf(CLOSED_BOX).subarray(0, 9), 0);
  assert.equal(openEdges(Float32Array.from([...zero, 0, 0, 0, 0, 0, 0, 1, 1, 1])).length, 0);
  const drawn = async (text) => {
    const page = await visitWith(visit, '#cells=20&backend=cpu', { 'box.stl': text });
    await run(page);
    await cellsAreDrawn(page);
    return (await pixels(page, [0xff, 0x3b, 0x20])).n;
  };
  assert.equal(await drawn(CLOSED_BOX), 0);
  assert.ok((await drawn(OPEN_BOX)) > 500);
});

test('a part without cells is drawn in stripes over the cells', async ({ visit }) => {
  const page = await visitLost(visit);
  const n_of = async () =>
    (await picture3d(page)).evaluate(({ data }) => {
      let n = 0;
      // the colour of flag 2, however it is lit
      for (let at = 0; at < data.length; at += 4)
        n +=
          data[at + 2] > 100 &&
          Math.abs(data[at] / data[at + 2] - 0.289) < 0.04 &&
          Math.abs(data[at + 1] / data[at + 2] - 0.711) < 0.04;
      return n;
    });
  const striped = await n_of();
  await page.getByRole('radio', { name: 'Model' }).check();
  await page.waitForSelector('#canvas-3d[data-at-rest=true]');
  const whole = await n_of();
  assert.ok(striped > 0.2 * whole && striped < 0.7 * whole, `${striped} of ${whole}`);
});

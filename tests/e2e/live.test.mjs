// What changes is meshed at once, without a click: files, settings, the slider. Every mesh is the one that a click makes.

import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';

import { expect } from '@playwright/test';

import { boxBetween, OPEN_BOX } from './open_box.mjs';
import { cellsAreDrawn, hasGeometries, legend, run, saved, take, test } from './visit.mjs';

const SPOT = 'tests/fixtures/spot.stl';
/** Parts that have cells. */
const N_PARTS = 11;

/** Shows a sample on a page that meshes by itself. @param {import('@playwright/test').Page} page */
async function takeLive(page, sample, n_files) {
  await page.click(`#empty [data-sample=${sample}]`);
  await expect(page.locator('.geometry')).toHaveCount(n_files);
}

/** The number of cells along x, y and z of the mesh that is shown, once they are these. */
const isMeshed = (page, dims) => expect(page.locator('#result-dims')).toContainText(`${dims} =`, { timeout: 60_000 });

/** Shows two cubes of 20 x 10 x 10 cells, cut across x and with a plane across z. */
async function cutCubes(page, cut, plane) {
  await takeLive(page, 'cubes', 2);
  await isMeshed(page, '20 × 10 × 10');
  await cellsAreDrawn(page);
  await page.selectOption('#section-axis', '0');
  await page.locator('#section-at').fill(cut);
  await page.check('#panes-z');
  await page.fill('#plane-z', plane);
  await page.waitForTimeout(500);
}

/** The hash of the flags of the mesh that is shown. */
async function hash(page) {
  await page.evaluate(() => document.querySelector('#hash').click());
  await expect(page.locator('#result-hash')).toHaveText(/^[0-9a-f]{64}$/);
  return page.textContent('#result-hash');
}

test('a file that is chosen is meshed, drawn and said without a click, as a click would', async ({ visit }) => {
  const live = await visit('#cells=40&backend=cpu', { live: true });
  await live.setInputFiles('#file-input', SPOT);
  await isMeshed(live, '22 × 40 × 40');
  await cellsAreDrawn(live);
  await expect(live.locator('#status')).toHaveText(/^Meshed 35,200 cells in /);
  assert.ok(await live.isHidden('#run'), 'there is nothing to click');
  assert.ok(await live.isChecked('#show-cells'));
  const byClick = await visit('#cells=40&backend=cpu');
  await byClick.setInputFiles('#file-input', SPOT);
  await hasGeometries(byClick, 1);
  await run(byClick);
  assert.equal(await hash(live), await hash(byClick));
  // a setting of the cells
  await live.evaluate(() => {
    const fill = document.querySelector('#fill');
    fill.value = 'conservative';
    fill.dispatchEvent(new Event('change', { bubbles: true }));
  });
  await expect(live.locator('#report')).toContainText('"conservative"');
  assert.ok(await live.isHidden('#stale'));
});

test('while the slider moves mesh follows mesh, none older after a newer, and the last is of where it stays', async ({
  visit,
}) => {
  const page = await visit('#cells=16&backend=cpu', { live: true });
  await takeLive(page, 'knot', 1);
  await cellsAreDrawn(page);
  await page.evaluate(() => {
    window.shown = [];
    // those that are coarse while it moves are no older ones
    const look = () => {
      if (!document.body.hasAttribute('data-coarse')) window.shown.push(document.querySelector('#legend .cells').dataset.cells);
    };
    new MutationObserver(look).observe(document.querySelector('#legend'), { childList: true });
  });
  await page.focus('#fineness');
  for (let n = 0; n < 24; n += 1) {
    await page.keyboard.press('ArrowRight');
    await page.waitForTimeout(30);
  }
  assert.equal(await page.inputValue('#cells'), '128');
  await expect(page.locator('#fineness')).toHaveAttribute('aria-valuetext', /^128 cells along the longest axis, 0/);
  await expect(page.locator('#result-dims')).toContainText('128', { timeout: 60_000 });
  const shown = (await page.evaluate(() => window.shown)).map(Number);
  assert.ok(shown.length > 2, `${shown.length} meshes were shown`);
  assert.deepEqual(
    shown,
    [...shown].sort((one, other) => one - other),
  );
  // the focus stays where it was
  assert.equal(await page.evaluate(() => document.activeElement.id), 'fineness');
  const byClick = await visit('#cells=128&backend=cpu');
  await take(byClick, 'knot', 1);
  await run(byClick);
  assert.equal(await hash(page), await hash(byClick));
  assert.deepEqual(await legend(page), await legend(byClick));
});

test('where meshes are slow, coarser ones follow the slider, and files wait for the one where it stays', async ({ visit }) => {
  // rays that make it slow on any machine
  const page = await visit('#cells=200&fractions=true&fraction_rays=16&backend=cpu', { live: true });
  await takeLive(page, 'knot', 1);
  await expect(page.locator('#result-dims')).toContainText('200 ×', { timeout: 60_000 });
  await cellsAreDrawn(page);
  await page.evaluate(() => {
    window.seen = [];
    const isInert = () => document.querySelector('#leave').inert;
    const look = () => {
      if (document.body.hasAttribute('data-coarse'))
        window.seen.push([document.querySelector('#result-dims').textContent, isInert()]);
    };
    new MutationObserver(look).observe(document.body, { attributeFilter: ['data-coarse'] });
  });
  await page.focus('#fineness');
  for (let n = 0; n < 16; n += 1) {
    await page.keyboard.press(n % 2 ? 'ArrowRight' : 'ArrowLeft');
    await page.waitForTimeout(100);
  }
  await expect(page.locator('body')).not.toHaveAttribute('data-coarse', { timeout: 60_000 });
  await expect(page.locator('#result-dims')).toContainText(`${await page.inputValue('#cells')} ×`, { timeout: 60_000 });
  const seen = await page.evaluate(() => window.seen);
  assert.ok(seen.length > 0, 'coarse cells were shown');
  assert.ok(
    seen.every(([dims, isInert]) => isInert && Number.parseInt(dims, 10) <= 120),
    JSON.stringify(seen),
  );
  assert.equal(await page.evaluate(() => document.querySelector('#leave').inert), false);
});

test('the slider sets the size that leads: cells, their length, the largest of graded lines', async ({ visit }) => {
  const page = await visit('#cell_size=1.25&backend=cpu', { live: true });
  await takeLive(page, 'cubes', 2);
  await isMeshed(page, '16 × 8 × 8');
  await page.focus('#fineness');
  for (let n = 0; n < 8; n += 1) await page.keyboard.press('ArrowRight');
  await expect(page.locator('#cell-size')).toHaveValue('0.625');
  await isMeshed(page, '32 × 16 × 16');
  await page.check('#graded');
  await expect(page.locator('#fineness')).toHaveAttribute('aria-valuetext', /^32 cells/);
  await page.focus('#fineness');
  for (let n = 0; n < 8; n += 1) await page.keyboard.press('ArrowLeft');
  await expect(page.locator('#graded-most')).toHaveValue('1.25');
  await isMeshed(page, '16 × 8 × 8');
});

test('a large mesh waits for a click; until then the page says of what its pictures are', async ({ visit }) => {
  const page = await visit('#cells=20&backend=cpu', { live: true });
  await takeLive(page, 'cubes', 2);
  await isMeshed(page, '20 × 10 × 10');
  await page.fill('#cells', '2000');
  await page.waitForSelector('#run:enabled');
  await expect(page.locator('#stale')).toBeVisible();
  await expect(page.locator('#estimate-cells')).toContainText('2000 × 1000 × 1000');
  await isMeshed(page, '20 × 10 × 10');
  // small again: nothing has changed
  await page.fill('#cells', '20');
  await expect(page.locator('#run')).toBeHidden();
  await expect(page.locator('#stale')).toBeHidden();
});

test('a mesh that takes long has a button that cancels it, and is not tried again before something changes', async ({
  visit,
}) => {
  const page = await visit('#cells=400&fractions=true&fraction_rays=16&backend=cpu', { live: true });
  await takeLive(page, 'knot', 1);
  await page.waitForSelector('#cancel', { timeout: 60_000 });
  await page.click('#cancel');
  await expect(page.locator('#status')).toHaveText('Cancelled; nothing was lost.');
  await page.waitForSelector('#run:enabled');
  assert.ok(await page.isHidden('#results'));
  await page.fill('#cells', '24');
  await expect(page.locator('#legend tr')).toHaveCount(1, { timeout: 60_000 });
  assert.ok(await page.isHidden('#run'));
});

test('what cannot be meshed is said once, and goes with the change that mends it', async ({ visit }) => {
  const page = await visit('#cells=20&open=error&backend=cpu', { live: true });
  await page.setInputFiles('#file-input', { name: 'box.stl', mimeType: '', buffer: Buffer.from(OPEN_BOX) });
  const error = page.locator('#messages .error[data-code=surface-open]');
  await expect(error).toHaveCount(1);
  await page.fill('#cells', '21');
  // another job fails anew, and the first message goes
  await expect(error).toHaveCount(1);
  await error.getByRole('button', { name: 'Use the winding number' }).click();
  await expect(page.locator('#legend tr')).toHaveCount(1);
  await expect(error).toHaveCount(0);
});

test('a file of columns stays until something changes', async ({ visit }) => {
  const page = await visit('#cells=20&backend=cpu', { live: true });
  await takeLive(page, 'cubes', 2);
  await isMeshed(page, '20 × 10 × 10');
  const { bytes } = await saved(page, '#download-hxc');
  await page.fill('#cells', '24');
  await isMeshed(page, '24 × 12 × 12');
  await page.setInputFiles('#file-input', { name: 'before.hxc', mimeType: '', buffer: bytes });
  await isMeshed(page, '20 × 10 × 10');
  await page.waitForSelector('#run:enabled');
  await page.fill('#cells', '28');
  await isMeshed(page, '28 × 14 × 14');
});

test('undo goes back to the mesh before, planes and cuts stay at their places', async ({ visit }) => {
  const page = await visit('#cells=20&backend=cpu', { live: true });
  await cutCubes(page, '5', '2');
  await page.fill('#cells', '80');
  await isMeshed(page, '80 × 40 × 40');
  await expect(page.locator('#canvas-z')).toHaveAttribute('data-index', '10');
  await page.check('#panes-3d');
  await cellsAreDrawn(page);
  await expect(page.locator('#section-at')).toHaveValue('22');
  await page.click('#undo');
  await isMeshed(page, '20 × 10 × 10');
  await expect(page.locator('#section-at')).toHaveValue('5');
});

test('coarse meshes do not move planes and cuts: they stay where they were put', async ({ visit }) => {
  const page = await visit('#cells=20&backend=cpu', { live: true });
  await cutCubes(page, '6', '3');
  await page.fill('#cells', '6');
  await isMeshed(page, '6 × 3 × 3');
  await expect(page.locator('#canvas-z')).toHaveAttribute('data-index', '1');
  await page.waitForTimeout(500);
  await page.fill('#cells', '20');
  await isMeshed(page, '20 × 10 × 10');
  await expect(page.locator('#canvas-z')).toHaveAttribute('data-index', '3');
  await page.check('#panes-3d');
  await cellsAreDrawn(page);
  await expect(page.locator('#section-at')).toHaveValue('6');
});

test('who switches it off meshes by a click, on the next visit, too', async ({ visit }) => {
  const page = await visit('#cells=20&backend=cpu', { live: true });
  await page.evaluate(() => document.querySelector('#live').click());
  await take(page, 'cubes', 2);
  assert.ok(await page.isHidden('#results'));
  await expect(page).toHaveURL(/sample=cubes/);
  await page.reload();
  assert.equal(await page.isChecked('#live'), false);
  await hasGeometries(page, 2);
  await page.check('#live');
  await isMeshed(page, '20 × 10 × 10');
});

test('a file of a mesh that is replaced meanwhile is written to its end', async ({ visit }) => {
  const page = await visit('#cells=400&backend=cpu', { live: true });
  await takeLive(page, 'cubes', 2);
  await isMeshed(page, '400 × 200 × 200');
  const download = page.waitForEvent('download');
  // at once, before the file is there
  await page.evaluate(() => {
    document.querySelector('#download-vtiz').click();
    const cells = document.querySelector('#cells');
    cells.value = '20';
    cells.dispatchEvent(new Event('input', { bubbles: true }));
  });
  await isMeshed(page, '20 × 10 × 10');
  const file = readFileSync(await (await download).path(), 'latin1');
  assert.match(file.slice(0, 2000), /WholeExtent="0 400 0 200 0 200"/);
  assert.match(file.slice(-100), /<\/VTKFile>/);
  assert.equal(await page.textContent('#messages'), '');
});

test('many parts are a row each, with their cells; a button opens the details of one', async ({ visit }) => {
  const page = await visit('#cells=100&backend=cpu', { live: true });
  await page.setViewportSize({ width: 1440, height: 900 });
  // the last one lies between the centres of cells: 0.035 of a length of 100
  const parts = Array.from({ length: N_PARTS }, (_, at) => boxBetween([8 * at, 0, 0], [8 * at + 6, 50, at + 1]));
  parts.push(boxBetween([0, 0, 20.1], [100, 50, 20.135]));
  await page.setInputFiles(
    '#file-input',
    parts.map((text, at) => ({ name: `part${at}.stl`, mimeType: '', buffer: Buffer.from(text) })),
  );
  await expect(page.locator('.geometry')).toHaveCount(parts.length);
  await expect(page.locator('.of-part').first()).not.toBeEmpty({ timeout: 60_000 });
  // parts that have no cell are said where they are listed
  const { flags } = JSON.parse(await page.textContent('#report'));
  const lost = flags.filter(({ cells }) => cells === 0).map(({ name }) => name);
  const said = await page.$$eval('.geometry:has(.bad)', (cards) => cards.map((card) => card.querySelector('.name').value));
  assert.deepEqual(said, lost);
  assert.deepEqual(said, [`part${N_PARTS}`]);
  const bottom = (selector) => page.$eval(selector, (element) => element.getBoundingClientRect().bottom);
  const rows = await page.$$eval('.geometry', (cards) => cards.map((card) => card.getBoundingClientRect().height));
  assert.ok(
    rows.every((height) => height < 48),
    `rows of ${rows} pixels`,
  );
  assert.ok((await bottom('#fineness')) < 900, 'the slider is in view');
  await page.getByRole('button', { name: 'Details of part3' }).click();
  const card = page.locator('.geometry[data-file="part3.stl"]');
  await expect(card.locator('.facts')).toBeVisible();
  await expect(page.locator('.drawer:visible')).toHaveCount(1);
  await card.locator('.priority').fill('3');
  await expect(page.locator('#report')).toContainText('"priority": 3');
  // it stays open where the list is drawn anew
  await page.getByRole('button', { name: 'Remove part5' }).click();
  await expect(page.locator('.drawer:visible')).toHaveCount(1);
});

/** Opens parts by their names. */
const openParts = (page, parts) =>
  page.setInputFiles(
    '#file-input',
    Object.entries(parts).map(([name, text]) => ({ name: `${name}.stl`, mimeType: '', buffer: Buffer.from(text) })),
  );

test('what helps one part helps all alike with one button, which undo takes back', async ({ visit }) => {
  const page = await visit('#cells=40&backend=cpu', { live: true });
  const parts = {
    small: boxBetween([1, 1, 1], [3, 3, 3]),
    other: boxBetween([5, 1, 1], [7, 3, 3]),
    large: boxBetween([0, 0, 0], [10, 5, 5]),
  };
  await openParts(page, parts);
  await expect(page.locator('#findings-count')).toHaveText('2 problems');
  await expect(page.getByRole('button', { name: /^Let it win: all 2/ })).toHaveCount(1);
  await page.waitForTimeout(500);
  await page.getByRole('button', { name: /^Let it win: all 2/ }).click();
  await expect(page.locator('#findings-count')).toHaveText('No problems found');
  assert.deepEqual(await legend(page), [
    [1, 512],
    [2, 512],
    [3, 40 * 20 * 20 - 1024],
  ]);
  await page.click('#undo');
  await expect(page.locator('#findings-count')).toHaveText('2 problems');
});

test('thin metal on a thick part is kept with one button, and the thick part stays as it is', async ({ visit }) => {
  const page = await visit('#cells=40&backend=cpu', { live: true });
  const parts = {
    below: boxBetween([1, 1, -0.03], [9, 4, 0]),
    above: boxBetween([2, 1, 1], [8, 4, 1.03]),
    board: boxBetween([0, 0, 0], [10, 5, 1]),
  };
  await openParts(page, parts);
  await expect(page.locator('#findings-count')).toHaveText('2 problems');
  const of = async (flag) => new Map(await legend(page)).get(flag);
  const whole = 40 * 20 * 4;
  assert.equal(await of(3), whole);
  await page.getByRole('button', { name: /^Keep thin walls: all 2/ }).click();
  await expect.poll(() => of(1)).toBe(32 * 12);
  assert.equal(await of(2), 24 * 12);
  assert.ok((await of(3)) >= whole - (32 + 24) * 12, 'the board has no cell more, and what the metal leaves of it');
  await expect(page.getByText(/got no cell/)).toHaveCount(0);
});

test('who comes without a file sees a part as cells, which goes with the first file', async ({ visit }) => {
  const page = await visit('', { live: true });
  await cellsAreDrawn(page);
  await expect(page.locator('#messages')).toContainText('This is a sample, a gear: drop your own files anywhere on the page.');
  await expect(page.locator('.geometry')).toHaveCount(1);
  assert.equal(new URL(page.url()).hash, '');
  await page.setInputFiles('#file-input', SPOT);
  await expect(page.locator('.geometry[data-file="spot.stl"]')).toHaveCount(1);
  await expect(page.locator('.geometry')).toHaveCount(1);
  await expect(page.locator('#legend tr')).toContainText('spot');
  assert.equal(await page.textContent('#messages'), '');
  // a second file joins the first
  await page.setInputFiles('#file-input', {
    name: 'box.stl',
    mimeType: '',
    buffer: Buffer.from(boxBetween([1, 1, 1], [2, 2, 2])),
  });
  await expect(page.locator('.geometry')).toHaveCount(2);
});

test('undo ends a mesh that is made, and the mesh before comes back', async ({ visit }) => {
  const page = await visit('#cells=24&fractions=true&fraction_rays=16&backend=cpu', { live: true });
  await takeLive(page, 'knot', 1);
  await expect(page.locator('#legend tr')).toHaveCount(1, { timeout: 60_000 });
  const before = await legend(page);
  await page.waitForTimeout(500);
  await page.fill('#cells', '400');
  await page.waitForSelector('#cancel', { timeout: 60_000 });
  await page.click('#undo');
  await expect(page.locator('#cells')).toHaveValue('24');
  await expect(page.locator('#cancel')).toBeHidden();
  await expect(page.locator('#stale')).toBeHidden();
  await expect(page.locator('#status')).not.toHaveText(/Cancelled/);
  // where the mesh of 400 cells was there before the click, the page makes that of 24 again
  await expect.poll(() => legend(page)).toEqual(before);
});

test('a mesh of a part that is removed meanwhile is not shown', async ({ visit }) => {
  const page = await visit('#cells=24&fractions=true&fraction_rays=16&backend=cpu', { live: true });
  await takeLive(page, 'cubes', 2);
  await expect(page.locator('#legend tr')).toHaveCount(2, { timeout: 60_000 });
  await page.waitForTimeout(500);
  await page.fill('#cells', '400');
  await page.evaluate(async () => {
    const cancel = document.querySelector('#cancel');
    while (cancel.hidden) await new Promise(requestAnimationFrame);
    window.shown = [];
    const look = () => window.shown.push(document.querySelector('#result-dims').textContent);
    new MutationObserver(look).observe(document.querySelector('#legend'), { childList: true });
    document.querySelector('.geometry button[aria-label^=Remove]').click();
  });
  await expect(page.locator('#legend tr')).toHaveCount(1, { timeout: 60_000 });
  await expect(page.locator('#cancel')).toBeHidden();
  assert.ok((await page.evaluate(() => window.shown)).every((dims) => !/^400 × 200/.test(dims)));
  await expect(page.locator('#result-dims')).toContainText('400 × 400');
});

/** What is seen of a mesh: from where, cut where, which plane in which tab, which flags. */
const looks = (page) =>
  page.evaluate(() => {
    const { sight } = document.querySelector('#canvas-3d').dataset;
    const { eye, target, centre } = JSON.parse(sight);
    return {
      eye: eye.map((at, axis) => (at + centre[axis]).toPrecision(3)),
      target: target.map((at, axis) => (at + centre[axis]).toFixed(2)),
      cut: [document.querySelector('#section-axis').value, document.querySelector('#section-at').value],
      plane: [document.querySelector('#panes-y').checked, document.querySelector('#plane-y').value],
      slices: document.querySelector('#pane-3d').hidden,
      shown: [...document.querySelectorAll('#legend input')].map(({ checked }) => checked),
    };
  });

test('a link opens meshed, and shows it as it was looked at', async ({ visit }) => {
  const page = await visit('#cells=20&backend=cpu', { live: true });
  await takeLive(page, 'cubes', 2);
  await cellsAreDrawn(page);
  for (let n = 0; n < 3; n += 1) await page.press('#canvas-3d', 'ArrowRight');
  await page.press('#canvas-3d', '+');
  await page.selectOption('#section-axis', '0');
  await page.locator('#section-at').fill('5');
  await page.uncheck('#legend tr[data-flag="2"] input');
  await page.check('#panes-y');
  await page.fill('#plane-y', '7');
  await expect(page).toHaveURL(/camera=.*&cut=0\+.*&at=.*&panes=y&hidden=2/);
  const before = await looks(page);
  assert.deepEqual([before.cut, before.plane, before.slices, before.shown], [['0', '5'], [true, '7'], true, [true, false]]);
  const other = await visit(new URL(page.url()).hash, { live: true });
  await isMeshed(other, '20 × 10 × 10');
  await expect(other.locator('#panes-y')).toBeChecked();
  await expect(other.locator('#plane-y')).toHaveValue('7');
  await other.check('#panes-3d');
  await cellsAreDrawn(other);
  await expect.poll(() => looks(other)).toEqual({ ...before, plane: [false, before.plane[1]], slices: false });
  // whatever is changed there, the link follows
  await other.selectOption('#section-axis', '');
  await expect(other).not.toHaveURL(/cut=|panes=/);
});

// The four panes: one crosshair in all of them, keys and double clicks, the inspector, what is measured, and axes that are stretched.

import assert from 'node:assert/strict';

import { expect } from '@playwright/test';

import { cellsAreDrawn, hasGeometries, legend, run, saved, test } from './visit.mjs';

/** Opens two cubes of 20 x 10 x 10 cells, meshed. */
async function cubes(visit, more = '') {
  const page = await visit(`#cells=20&sample=cubes&backend=cpu&unit=mm${more}`);
  await hasGeometries(page, 2);
  await run(page);
  await cellsAreDrawn(page);
  return page;
}

const pane = (page, name) => page.getByRole('region', { name, exact: true });
const choose = (page, name) => page.getByRole('group', { name: 'Panes' }).getByRole('radio', { name, exact: true }).check();
/** Which panes are seen. */
const shown = async (page) => {
  const names = ['xy', '3-D', 'xz', 'yz'];
  const seen = await Promise.all(names.map((name) => pane(page, name).isVisible()));
  return names.filter((_, at) => seen[at]).join(' ');
};
/** The planes of the slices across x, y and z. */
const planes = async (page) => (await Promise.all(['x', 'y', 'z'].map((axis) => page.inputValue(`#plane-${axis}`)))).join();
/** Where the middle of a cell of a slice lies in its canvas, in CSS pixels. */
const placeOf = (page, axis, i, j) =>
  page.$eval(
    `#canvas-${axis}`,
    ({ dataset }, [i, j]) => {
      const [left, top, scaleX, scaleY, height] = ['left', 'top', 'scaleX', 'scaleY', 'height'].map((key) =>
        Number(dataset[key]),
      );
      return { x: (left + (i + 0.5) * scaleX) / devicePixelRatio, y: (top + (height - j - 0.5) * scaleY) / devicePixelRatio };
    },
    [i, j],
  );
const areDrawn = (page, [x, y, z]) =>
  Promise.all(
    [
      ['x', x],
      ['y', y],
      ['z', z],
    ].map(([axis, index]) => page.waitForSelector(`#canvas-${axis}[data-index="${index}"]`)),
  );
const facts = (page, list) =>
  page.$$eval(`${list} dt`, (terms) =>
    Object.fromEntries(terms.map((term) => [term.textContent, term.nextElementSibling.textContent])),
  );

test('keys 1 to 4, a double click and Escape go between one pane and all four', async ({ visit }) => {
  const page = await cubes(visit);
  assert.equal(await shown(page), '3-D');
  await choose(page, 'Four');
  assert.equal(await shown(page), 'xy 3-D xz yz');
  const alone = { 1: 'xy', 2: 'xz', 3: 'yz', 4: '3-D' };
  for (const [key, name] of Object.entries(alone)) {
    await page.keyboard.press(key);
    assert.equal(await shown(page), name);
    await page.keyboard.press(key === '2' ? 'Escape' : key);
    assert.equal(await shown(page), 'xy 3-D xz yz');
  }
  await page.locator('#canvas-x').dblclick();
  assert.equal(await shown(page), 'yz');
  await page.locator('#canvas-x').dblclick();
  assert.equal(await shown(page), 'xy 3-D xz yz');
  // what is typed in a field is no key
  await page.focus('#cells');
  await page.keyboard.type('1');
  assert.equal(await shown(page), 'xy 3-D xz yz');
  await page.setViewportSize({ width: 390, height: 844 });
  await expect.poll(() => shown(page)).toBe('3-D');
  await expect(page.getByRole('radio', { name: 'Four' })).toBeHidden();
});

test('a press and a drag in a slice, a click in 3-D, and keys move the crosshair of all panes', async ({ visit }) => {
  const page = await cubes(visit, '&panes=four');
  await areDrawn(page, [10, 5, 5]);
  assert.equal(await planes(page), '10,5,5');
  await page.locator('#canvas-z').click({ position: await placeOf(page, 'z', 3, 7) });
  await areDrawn(page, [3, 7, 5]);
  await page.locator('#canvas-x').click({ position: await placeOf(page, 'x', 2, 8) });
  await areDrawn(page, [3, 2, 8]);
  // a drag
  const { x, y } = await page.locator('#canvas-z').boundingBox();
  const [from, to] = [await placeOf(page, 'z', 3, 2), await placeOf(page, 'z', 16, 4)];
  await page.mouse.move(x + from.x, y + from.y);
  await page.mouse.down();
  await page.mouse.move(x + (from.x + to.x) / 2, y + (from.y + to.y) / 2);
  await page.mouse.move(x + to.x, y + to.y);
  await expect.poll(() => planes(page)).toBe('16,4,8');
  await page.mouse.up();
  await page.locator('#canvas-y').press('Shift+ArrowUp');
  await expect.poll(() => planes(page)).toBe('16,4,9');
  const box = await page.locator('#canvas-3d').boundingBox();
  await page.locator('#canvas-3d').click({ position: { x: box.width * 0.4, y: box.height * 0.55 } });
  await expect(page.locator('#readout')).toHaveText(/^cell .*: flag \d/);
  const [, cell] = /^cell (\d+, \d+, \d+) at /.exec(await page.textContent('#readout'));
  await expect.poll(() => planes(page)).toBe(cell.replaceAll(' ', ''));
  await areDrawn(page, cell.split(', '));
});

test('the wheel zooms a slice at the pointer, and Shift and a drag move it', async ({ visit }) => {
  const page = await cubes(visit, '&panes=z');
  await page.waitForSelector('#canvas-z[data-index="5"]');
  const { x, y } = await page.locator('#canvas-z').boundingBox();
  const before = await placeOf(page, 'z', 4, 8);
  await page.mouse.move(x + before.x, y + before.y);
  await page.mouse.wheel(0, -600);
  await expect.poll(async () => Number(await page.getAttribute('#canvas-z', 'data-zoom'))).toBeGreaterThan(3);
  const after = await placeOf(page, 'z', 4, 8);
  assert.ok(Math.hypot(after.x - before.x, after.y - before.y) < 3, JSON.stringify({ before, after }));
  await page.keyboard.down('Shift');
  await page.mouse.down();
  await page.mouse.move(x + before.x + 40, y + before.y + 30);
  await page.mouse.up();
  await page.keyboard.up('Shift');
  const moved = await placeOf(page, 'z', 4, 8);
  assert.ok(Math.hypot(moved.x - after.x - 40, moved.y - after.y - 30) < 3, JSON.stringify({ after, moved }));
  assert.equal(await planes(page), '10,5,5', 'the crosshair stays');
});

test('the inspector has the cell, what is beside it, its column, and which parts claim it', async ({ visit }) => {
  const page = await cubes(visit, '&panes=four');
  const inspector = page.getByRole('region', { name: 'Cell', exact: true });
  await expect(inspector).toBeHidden();
  await areDrawn(page, [10, 5, 5]);
  await page.locator('#canvas-z').press('Enter');
  await expect(inspector).toBeVisible();
  await page.locator('#canvas-y').click({ position: await placeOf(page, 'y', 10, 4) });
  await expect
    .poll(() => facts(page, '#inspector-facts'))
    .toEqual({ Index: '10, 5, 4', Centre: '10.5, 5.5, 4.5 mm', Size: '1 mm', Flag: '2 epoxy' });
  const beside = await page.$$eval('#inspector-beside tr', (rows) =>
    rows.map((row) => [...row.children].map((cell) => cell.textContent)),
  );
  assert.deepEqual(beside, [
    ['x', '1 copper', '2 epoxy'],
    ['y', '2 epoxy', '2 epoxy'],
    ['z', '2 epoxy', 'background'],
  ]);
  // the rays go along x
  const column = () =>
    page.$$eval('#inspector-runs tr', (rows) => rows.map((row) => [...row.children].map((cell) => cell.textContent).join(' | ')));
  assert.deepEqual(await column(), ['1 copper | 0 to 9 | 0 to 10', '2 epoxy | 10 to 19 | 10 to 20']);
  assert.equal(await page.textContent('#inspector-runs [aria-current] th'), '2 epoxy');
  // it follows the crosshair
  await page.locator('#canvas-y').press('Shift+ArrowUp');
  await expect.poll(column).toEqual(['1 copper | 0 to 9 | 0 to 10', 'background | 10 to 19 | 10 to 20']);
  // where the results are below the panes it lies over these, and on a phone below them
  for (const size of [
    { width: 1000, height: 800 },
    { width: 390, height: 844 },
  ]) {
    await page.setViewportSize(size);
    await expect(page.locator('#view').getByRole('region', { name: 'Cell', exact: true })).toBeVisible();
  }
  await page.locator('#inspector-close').press('Enter');
  await expect(inspector).toBeHidden();
});

test('which parts claim a cell is said with the reason, and is what the mesh does', async ({ visit }) => {
  const page = await visit('#cells=20&sample=shells&backend=cpu&panes=z');
  await hasGeometries(page, 2);
  await run(page);
  await page.waitForSelector('#canvas-z[data-index]');
  const { x, y, width, height } = await page.locator('#canvas-z').boundingBox();
  await page.mouse.click(x + width / 2, y + height / 2);
  const ask = async () => {
    await page.getByRole('button', { name: 'Which parts claim it?' }).click();
    await expect(page.locator('#claims')).toBeVisible();
    return page.textContent('#claims-answer');
  };
  assert.equal(await ask(), '2 parts claim this cell: core has it, as its priority 1 is above 0 of coating.');
  const rows = await page.$$eval('#claims-rows tr', (all) => all.map((row) => row.children[0].textContent));
  assert.deepEqual(rows, ['coating', 'core']);
  const cells = await legend(page);
  await page.fill('.geometry .priority >> nth=1', '0');
  await run(page);
  assert.equal(await ask(), '2 parts claim this cell: core has it, as it comes after coating, which has the same priority 0.');
  assert.deepEqual(await legend(page), cells, 'the mesh stays what it was');
  // beside the parts
  await page.locator('#canvas-z').click({ position: await placeOf(page, 'z', 0, 0) });
  assert.equal(await ask(), 'No part claims this cell: it is background.');
});

test('two cells are measured in slices and in 3-D, with the keyboard, too', async ({ visit }) => {
  const page = await cubes(visit, '&panes=four');
  await areDrawn(page, [10, 5, 5]);
  const button = page.getByRole('button', { name: 'Measure' });
  await button.press('Enter');
  await expect(button).toHaveAttribute('aria-pressed', 'true');
  await expect(page.locator('#view-prompt')).toHaveText(/click the first cell/);
  await page.locator('#canvas-z').click({ position: await placeOf(page, 'z', 2, 1) });
  await expect(page.locator('#view-prompt')).toHaveText(/click the second cell/);
  await areDrawn(page, [2, 1, 5]);
  await page.locator('#canvas-z').focus();
  for (let n = 0; n < 3; n += 1) await page.keyboard.press('Shift+ArrowRight');
  for (let n = 0; n < 4; n += 1) await page.keyboard.press('Shift+ArrowUp');
  await page.keyboard.press('Enter');
  const expected = {
    'From cell': '2, 1, 5',
    'To cell': '5, 5, 5',
    'Between their centres': '5 mm',
    dx: '3 mm, 3 cells',
    dy: '4 mm, 4 cells',
    dz: '0 mm, 0 cells',
    'With both cells': '4 × 5 × 1 mm',
    '': '4 × 5 × 1 cells',
  };
  await expect.poll(() => facts(page, '#measured-facts')).toEqual(expected);
  // in a mesh of other cells the points stay where they are
  await page.fill('#cells', '40');
  await page.waitForSelector('#run:enabled');
  await run(page);
  await expect.poll(async () => (await facts(page, '#measured-facts')).dy).toBe('4 mm, 8 cells');
  // both ends and the line are drawn in the slice
  const drawn = await page.$eval('#canvas-z', (canvas) => {
    const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
    let n = 0;
    for (let at = 0; at < data.length; at += 4) n += data[at] === 0xb0 && data[at + 1] === 0x40 && data[at + 2] === 0x90;
    return n;
  });
  assert.ok(drawn > 50, `${drawn} pixels`);
  await page.keyboard.press('Escape');
  await expect(button).toHaveAttribute('aria-pressed', 'false');
  await expect(page.locator('#measured')).toBeHidden();
});

test('an axis is stretched in pictures alone: slices, scale bars, the word, and the link; files stay', async ({ visit }) => {
  const page = await cubes(visit, '&panes=four');
  await areDrawn(page, [10, 5, 5]);
  const scales = () => page.$eval('#canvas-y', ({ dataset }) => Number(dataset.scaleY) / Number(dataset.scaleX));
  assert.equal(await scales(), 1);
  const bar = pane(page, 'xz').locator('.gauges span').last();
  await expect(bar).toHaveText(/^\d+ mm$/);
  const { bytes } = await saved(page, '#download-raw');
  await page.getByRole('combobox', { name: 'Stretch' }).selectOption({ label: 'z 4 times' });
  await expect.poll(scales).toBeCloseTo(4, 5);
  await expect(page.locator('#stretched')).toHaveText('z is drawn 4 times as long');
  await expect(bar).toHaveText(/^\d+ mm of x$/);
  assert.ok(bytes.equals((await saved(page, '#download-raw')).bytes));
  await expect(page).toHaveURL(/stretch=2\+4/);
  await page.getByRole('combobox', { name: 'Stretch' }).selectOption({ label: 'z to fit' });
  await expect.poll(scales).toBeCloseTo(2, 5);
  // a cell below the pointer is what it was
  await page.locator('#canvas-y').click({ position: await placeOf(page, 'y', 4, 6) });
  await expect(page.locator('#readout')).toHaveText(/^cell 4, 5, 6 at 4\.5, 5\.5, 6\.5 mm: flag 1, copper$/);
});

// From dropped files to the file of a program: what is asked, in how many clicks, and what is typed next; and the list of all formats.

import assert from 'node:assert/strict';
import { mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import path from 'node:path';

import { expect } from '@playwright/test';

import { runCopied, writeSample } from './native.mjs';
import { OPEN_BOX, boxBetween } from './open_box.mjs';
import { cellsAreDrawn, COPPER, EPOXY, hasGeometries, run, saved, test } from './visit.mjs';

/** Opens two cubes of 20 x 10 x 10 cells, meshed. */
async function cubes(visit, more = '') {
  const page = await visit(`#cells=20&sample=cubes&backend=cpu${more}`);
  await hasGeometries(page, 2);
  await run(page);
  return page;
}

/** A board of twelve parts, one of them open, in millimetres. */
const BOARD = {
  balls: boxBetween([61, 21, 1], [72, 32, 2]),
  chip: boxBetween([60, 20, 2], [75, 35, 4]),
  connector: boxBetween([30, -8, -2], [39, 0, 6]),
  feed: boxBetween([33, 0, 1], [36, 20, 2]),
  ground: boxBetween([0, 0, -1], [100, 80, 0]),
  lid_open: OPEN_BOX,
  patch: boxBetween([20, 20, 1], [48, 58, 2]),
  pin: boxBetween([34, -7, 1], [35, 1, 2]),
  screw: boxBetween([90, 70, 1], [95, 75, 5]),
  substrate: boxBetween([0, 0, 0], [100, 80, 1]),
  traces: boxBetween([55, 5, 1], [88, 19, 2]),
  vias: boxBetween([49, 7, 0], [54, 71, 1]),
};
const PROGRAM = 'For which program?';
const UNIT = 'Lengths of the files are in';

/** Chooses from a list: one click opens it, another takes a line. */
async function choose(page, label, value) {
  await page.getByRole('combobox', { name: label, exact: true }).selectOption(value);
  return 2;
}

test('from a dropped board of twelve parts to the file of openEMS: at most 12 clicks, and the bytes of the command', async ({
  visit,
  folder,
}) => {
  const page = await visit('#backend=cpu', { live: true });
  const files = Object.entries(BOARD).map(([name, text]) => [`${name}.stl`, text]);
  const payload = files.map(([name, text]) => ({ name, mimeType: 'model/stl', buffer: Buffer.from(text) }));
  await page.setInputFiles('#file-input', payload);
  await page.waitForFunction(() => document.querySelectorAll('#legend tr').length === 12);
  let clicks = await choose(page, PROGRAM, 'openEMS');
  const save = page.getByRole('button', { name: 'Save balls.csx.xml' });
  await expect(save).toBeDisabled();
  await expect(page.locator('#program-missing')).toHaveText('Still to say: the unit, and what 12 parts are made of.');
  clicks += await choose(page, UNIT, 'mm');
  clicks += await choose(page, 'All without one', { label: 'Metal (PEC)' });
  clicks += await choose(page, 'What substrate is made of', { label: 'FR-4, eps_r=4.4' });
  await expect(save).toBeEnabled();
  assert.equal(await page.locator('#messages .error').count(), 0);
  // the answers are in the mesh, and nobody asked for one
  const { name, bytes } = await saved(page, '#program-save');
  clicks += 1;
  assert.ok(clicks <= 12, `${clicks} clicks`);
  assert.equal(name, 'balls.csx.xml');
  await expect(page.locator('#program-status')).toHaveText('Saved.');
  await expect(page.locator('#program-next')).toContainText('structure.ReadFromXML("balls.csx.xml")');
  for (const [file, text] of files) writeFileSync(path.join(folder, file), text);
  await runCopied(page, folder, ['-o', 'board.csx.xml']);
  assert.ok(bytes.equals(readFileSync(path.join(folder, 'board.csx.xml'))), `${bytes.length} bytes`);
  assert.match(bytes.toString(), /<Material [^>]*Name="substrate"/);
});

test('a program asks only for what is not said, and where meshes wait for a click its answers do not', async ({
  visit,
  folder,
}) => {
  const page = await cubes(visit, '&unit=mm');
  await choose(page, PROGRAM, 'OpenFOAM');
  await expect(page.getByLabel(UNIT)).toBeHidden();
  await expect(page.getByRole('table', { name: 'Materials of parts' })).toBeHidden();
  assert.equal((await saved(page, '#program-save')).name, 'copper.foam.zip');
  // materials are of use to this one, and it does without
  await choose(page, PROGRAM, 'Abaqus, CalculiX');
  await expect(page.getByRole('button', { name: 'Save copper.inp' })).toBeEnabled();
  await choose(page, 'What copper is made of', { label: 'Copper' });
  await choose(page, PROGRAM, 'gprMax');
  const save = page.getByRole('button', { name: 'Save copper.in.zip' });
  await expect(page.locator('#program-missing')).toHaveText('Still to say: what 2 parts are made of.');
  await choose(page, 'What copper is made of', { label: 'Copper, sigma=58000000' });
  await expect(page.locator('#program-missing')).toHaveText('Still to say: what one part is made of.');
  await choose(page, 'What epoxy is made of', { label: 'other …' });
  await page.getByLabel('Numbers of epoxy').fill('eps_r=3.6, sigma=1e-3');
  await expect(save).toBeEnabled();
  await expect(page.locator('#stale')).toBeHidden();
  // both kinds of numbers are of the part, and its field in the list has them
  await expect(page.locator('.material').first()).toHaveValue('E=120000000000 nu=0.34 density=8960 sigma=58000000');
  await choose(page, PROGRAM, 'openEMS');
  await expect(page.getByLabel('What epoxy is made of')).toBeHidden();
  const { bytes } = await saved(page, '#program-save');
  await writeSample('cubes', folder);
  await runCopied(page, folder, ['-o', 'all.csx.xml']);
  assert.ok(bytes.equals(readFileSync(path.join(folder, 'all.csx.xml'))), `${bytes.length} bytes`);
  // cells of other settings wait for their click
  await page.getByLabel('Cells along the longest axis').fill('21');
  await expect(page.locator('#stale')).toBeVisible();
});

test('arrays for lbmpy, Palabos and taufactor are those of their recipes', async ({ visit, folder }) => {
  const page = await cubes(visit);
  await writeSample('cubes', folder);
  for (const [program, words, file] of [
    ['lbmpy', ['--axis-order=xyz'], 'array.npy'],
    ['Palabos', [], 'array.raw'],
    ['taufactor', ['--map=0=1,1=0,2=0'], 'array.npy'],
  ]) {
    await choose(page, PROGRAM, program);
    const { bytes } = await saved(page, '#program-save');
    mkdirSync(path.join(folder, program));
    await runCopied(page, folder, [...words, '-o', `${program}/${file}`]);
    assert.ok(bytes.equals(readFileSync(path.join(folder, program, file))), program);
  }
});

test('a file of cells says its own unit: where it has none, a program that needs one says so', async ({ visit }) => {
  const page = await cubes(visit);
  const { bytes } = await saved(page, '#download-hxc');
  const other = await visit('#backend=cpu');
  await other.setInputFiles('#file-input', { name: 'cells.hxc', mimeType: '', buffer: bytes });
  await other.waitForSelector('#legend tr');
  await choose(other, PROGRAM, 'OpenFOAM');
  await expect(other.locator('#program-missing')).toContainText('a unit, without which OpenFOAM has no lengths');
  await expect(other.getByRole('button', { name: /^Save .*foam/ })).toBeDisabled();
  await choose(other, PROGRAM, 'Gmsh');
  await expect(other.getByRole('button', { name: /^Save .*msh/ })).toBeEnabled();
});

test('the list of formats is searched by name, ending and program, and gone through with the arrow keys', async ({ visit }) => {
  const page = await cubes(visit);
  const search = page.getByRole('searchbox', { name: 'All formats' });
  const found = () =>
    page
      .getByRole('list', { name: 'All formats' })
      .getByRole('button')
      .evaluateAll((all) => all.map(({ id }) => id));
  for (const [words, ids] of [
    ['magica', ['download-vox']],
    ['.NPY', ['download-npy']],
    ['openems', ['download-csx-xml']],
    ['palabos', ['download-raw']],
    ['vtk compressed', ['download-vtiz']],
    ['no such format', []],
  ]) {
    await search.fill(words);
    assert.deepEqual(await found(), ids, words);
    await expect(page.locator('#files-found')).toHaveText(/^(None|\d+) of \d+ formats$/);
  }
  await search.fill('numpy');
  await search.press('ArrowDown');
  await expect(page.locator('#download-npz')).toBeFocused();
  await page.keyboard.press('ArrowDown');
  const [download] = await Promise.all([page.waitForEvent('download'), page.keyboard.press('Enter')]);
  assert.equal(download.suggestedFilename(), 'copper.npy');
  await page.keyboard.press('ArrowUp');
  await page.keyboard.press('ArrowUp');
  await expect(search).toBeFocused();
  // another mesh does not end a search
  await page.selectOption('#unit', 'mm');
  await expect(page.locator('#result-size')).toContainText('mm');
  assert.deepEqual((await found()).includes('download-vti'), false);
});

/** Width and height of a saved picture, and whether the strip below the first rows has a pixel of a colour. */
async function strip(page, colours) {
  const { bytes } = await saved(page, '#save-3d');
  return page.evaluate(
    async ([base64, colours]) => {
      const blob = new Blob([Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0))]);
      const { width, height } = await createImageBitmap(blob);
      const { clientWidth, clientHeight } = document.querySelector('#canvas-3d');
      const context = new OffscreenCanvas(width, height).getContext('2d');
      context.drawImage(await createImageBitmap(blob), 0, 0);
      const top = Math.round((width * clientHeight) / clientWidth);
      const pixels = height > top ? context.getImageData(0, top, width, height - top).data : [];
      const seen = new Set();
      for (let at = 0; at < pixels.length; at += 4) seen.add(String(pixels.slice(at, at + 3)));
      return {
        size: [width / clientWidth, top / clientHeight],
        strip: height - top,
        seen: colours.map((colour) =>
          seen.has(String([1, 3, 5].map((from) => Number.parseInt(colour.slice(from, from + 2), 16)))),
        ),
      };
    },
    [bytes.toString('base64'), colours],
  );
}

test('the picture is saved at twice the size, with a legend of the flags that are seen', async ({ visit }) => {
  const page = await visit('#cells=20&sample=cubes&backend=cpu&unit=mm');
  await hasGeometries(page, 2);
  const models = await strip(page, []);
  assert.deepEqual([models.size, models.strip], [[2, 2], 0], 'models have none');
  await run(page);
  await cellsAreDrawn(page);
  const both = await strip(page, [COPPER, EPOXY]);
  assert.deepEqual(
    [both.size, both.seen],
    [
      [2, 2],
      [true, true],
    ],
  );
  assert.ok(both.strip > 80, `${both.strip} rows`);
  await page.getByRole('checkbox', { name: 'Show flag 2, epoxy' }).uncheck();
  assert.deepEqual((await strip(page, [COPPER, EPOXY])).seen, [true, false]);
  // the view has its own size again
  await page.waitForSelector('#canvas-3d[data-at-rest=true]');
  assert.ok(await page.$eval('#canvas-3d', ({ width, clientWidth }) => width === Math.round(clientWidth * devicePixelRatio)));
});

// The mesh compared with that of a file, and pictures of slices: what the native command finds and draws.

import assert from 'node:assert/strict';
import { execFileSync, spawnSync } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';

import { expect } from '@playwright/test';

import { PROGRAM } from './native.mjs';
import { hasGeometries, isIdle, legend, run, saved, slice, test } from './visit.mjs';

/** Balls of which the later has the cells of both: with more cells along surfaces, flags change in more than one way. */
const SETTINGS = '#dims=31+29+37&axis=y&backend=cpu&sample=shells';

let folder;
test.beforeEach(() => (folder = mkdtempSync(path.join(tmpdir(), 'hexcast-compare-'))));
test.afterEach(() => rmSync(folder, { recursive: true, force: true }));

/** Meshes twice, with other cells along surfaces; the page shows the second mesh. Both are in files: `before.hxc` and `after.hxc`. */
async function meshedTwice(visit) {
  const page = await visit(SETTINGS);
  await hasGeometries(page, 2);
  await run(page);
  const before = (await saved(page, '#download-hxc')).bytes;
  await page.evaluate(() => {
    for (const details of document.querySelectorAll('#settings details, #compare')) details.open = true;
  });
  await page.selectOption('#fill', 'conservative');
  await page.waitForSelector('#run:enabled');
  await run(page);
  const after = (await saved(page, '#download-hxc')).bytes;
  writeFileSync(path.join(folder, 'before.hxc'), before);
  writeFileSync(path.join(folder, 'after.hxc'), after);
  return { page, before };
}

/** What the native command finds, with the mask of all cells. */
function native(one, other) {
  const mask = path.join(folder, 'mask.raw');
  const files = [one, other].map((name) => path.join(folder, name));
  const { status, stdout, stderr } = spawnSync(PROGRAM, ['diff', ...files, '--json', '-o', mask], { encoding: 'utf8' });
  assert.equal(status, 1, stderr);
  return { ...JSON.parse(stdout), mask: readFileSync(mask) };
}

const rows = (page) =>
  page.$$eval('#compare-pairs tr', (all) =>
    all.map((row) => [row.dataset.pair, ...[...row.children].slice(0, 3).map((cell) => cell.textContent)]),
  );

test('pairs of flags are those of the native command, a button goes to the first cell, and slices mark what differs', async ({
  visit,
}) => {
  const { page, before } = await meshedTwice(visit);
  await page.setInputFiles('#compare-input', { name: 'before.hxc', mimeType: '', buffer: before });
  await page.waitForSelector('#compare-pairs tr');
  const found = native('after.hxc', 'before.hxc');
  assert.ok(found.pairs.length >= 2, JSON.stringify(found.pairs));
  const names = (await page.$$eval('#legend th', (all) => all.map((one) => one.textContent.trim()))).map((text) =>
    text.split(' '),
  );
  const named = (flag) => (flag === 0 ? '0 background' : names.find(([number]) => Number(number) === flag).join(' '));
  assert.deepEqual(
    await rows(page),
    found.pairs.map(({ one, other, cells }) => [`${one} ${other}`, named(one), named(other), cells.toLocaleString('en')]),
  );
  const count = found.cells.toLocaleString('en');
  await expect(page.locator('#compare-answer')).toHaveText(
    `${count} of ${(31 * 29 * 37).toLocaleString('en')} cells differ; slices mark them.`,
  );

  const [nx, ny] = [31, 29];
  await page.check('#panes-x');
  await page.uncheck('#mesh-lines');
  // where cells are small, stripes would miss some: these are filled
  await page.setViewportSize({ width: 260, height: 400 });
  await page.waitForFunction(() => Number(document.querySelector('#canvas-x').dataset.scaleY) < 8);
  const cells = (await slice(page, 'x', 15)).flatMap((row, z) => row.map((colour, y) => [colour, y, z]));
  const mark = await page.$eval('#canvas-x', (canvas) => getComputedStyle(canvas).getPropertyValue('--mark').trim());
  assert.ok(cells.filter(([colour]) => colour === mark).length > 20);
  for (const [colour, y, z] of cells) assert.equal(colour === mark, found.mask[15 + nx * (y + ny * z)] === 1, `${y}, ${z}`);
  await page.setViewportSize({ width: 1280, height: 720 });

  for (const { one, other, first } of found.pairs) {
    await page.click(`#compare-pairs [data-pair="${one} ${other}"] button`);
    await expect(page.locator('#readout')).toContainText(`cell ${first.join(', ')} at`);
    assert.equal(await page.inputValue('#plane-x'), String(first[0]));
    const flag = one === 0 ? 'background' : `flag ${one}`;
    await expect(page.locator('#readout')).toContainText(flag);
  }

  let n_hatched = 0;
  for (const z of [18, 9]) {
    await slice(page, 'z', z);
    await page.waitForFunction(() => /marked cells differ from before\.hxc/.test(document.querySelector('#note-z').textContent));
    const hatched = await page.$eval('#canvas-z', hatchedCells);
    const expected = Array.from({ length: ny }, (_, j) =>
      Array.from({ length: nx }, (_, i) => found.mask[i + nx * (j + ny * z)] === 1),
    );
    assert.deepEqual(hatched, expected, `plane ${z}`);
    n_hatched += hatched.flat().filter(Boolean).length;
  }
  assert.ok(n_hatched > 20, `${n_hatched}`);

  const mask = await saved(page, '#compare-save');
  assert.match(mask.name, /-differs\.hxc$/);
  writeFileSync(path.join(folder, 'mask.hxc'), mask.bytes);
  execFileSync(PROGRAM, ['convert', path.join(folder, 'mask.hxc'), path.join(folder, 'ours.raw')]);
  assert.ok(readFileSync(path.join(folder, 'ours.raw')).equals(found.mask));

  await page.click('#compare-clear');
  assert.deepEqual(await rows(page), []);
  await expect(page.locator('#note-z')).toHaveText('');
});

/** In the page: which cells have both black and white pixels, `[j][i]`. @param {HTMLCanvasElement} canvas */
function hatchedCells(canvas) {
  const [left, top, dx, dy, width, height] = ['left', 'top', 'scaleX', 'scaleY', 'width', 'height'].map((key) =>
    Number(canvas.dataset[key]),
  );
  const copy = new OffscreenCanvas(canvas.width, canvas.height).getContext('2d', { willReadFrequently: true });
  copy.drawImage(canvas, 0, 0);
  const { data } = copy.getImageData(0, 0, canvas.width, canvas.height);
  return Array.from({ length: height }, (_, j) =>
    Array.from({ length: width }, (_, i) => {
      const seen = new Set();
      // without the outermost pixels, which may be those of the cell beside it or of the cursor
      for (let y = Math.ceil(top + (height - 1 - j) * dy) + 2; y < top + (height - j) * dy - 2; y += 1)
        for (let x = Math.ceil(left + i * dx) + 2; x < left + (i + 1) * dx - 2; x += 1) {
          const at = 4 * (x + canvas.width * y);
          seen.add(`${data[at]},${data[at + 1]},${data[at + 2]}`);
        }
      return seen.has('0,0,0') && seen.has('255,255,255');
    }),
  );
}

test('a file that is dropped there is compared, and does not take the place of the mesh; others are refused in words', async ({
  visit,
}) => {
  const { page, before } = await meshedTwice(visit);
  const flags = await legend(page);
  const drop = (name, bytes) =>
    page.evaluate(
      ([name, bytes]) => {
        const files = new DataTransfer();
        files.items.add(new File([Uint8Array.from(bytes)], name));
        const event = new DragEvent('drop', { dataTransfer: files, bubbles: true, cancelable: true });
        document.querySelector('#compare').dispatchEvent(event);
      },
      [name, [...bytes]],
    );
  await drop('old.hxc', before);
  await page.waitForSelector('#compare-pairs tr');
  await isIdle(page);
  assert.deepEqual(await legend(page), flags);

  await drop('after.hxc', readFileSync(path.join(folder, 'after.hxc')));
  await expect(page.locator('#compare-answer')).toHaveText('All 33,263 cells have the same flags.');
  assert.equal(await page.isVisible('#compare-result'), false);

  await drop('letter.hxc', Buffer.from('Dear Sir'));
  const error = page.locator('#messages [role=alert]');
  await expect(error).toContainText('letter.hxc');
  assert.equal(await error.getAttribute('data-code'), 'columns-corrupt');
  await error.getByRole('button', { name: 'Dismiss message' }).click();

  // of another number of cells
  await page.fill('#dims-x', '30');
  await page.waitForSelector('#run:enabled');
  await drop('old.hxc', before);
  await page.waitForSelector('#compare-pairs tr');
  await run(page);
  // what was found was of the mesh before
  assert.deepEqual(await rows(page), []);
  await drop('old.hxc', before);
  await expect(error).toContainText('30 x 29 x 37 cells, the other 31 x 29 x 37');
});

test('the picture of a slice that is saved is that of the native command', async ({ visit }) => {
  const { page } = await meshedTwice(visit);
  const draws = async (name, words) => {
    const { name: offered, bytes } = await saved(page, `#save-${name[0]}`);
    assert.match(offered, new RegExp(`-${name}\\.png$`));
    const picture = path.join(folder, 'native.png');
    execFileSync(PROGRAM, ['slice', path.join(folder, 'after.hxc'), '-o', picture, '-q', '--size=1200', ...words]);
    assert.ok(readFileSync(picture).equals(bytes), `${name}: ${bytes.length} bytes`);
  };
  await slice(page, 'x', 11);
  const at = (cells, n) => `--at=${(100 * (cells + 0.5)) / n}%`;
  await draws('x11', ['--axis=x', at(11, 31)]);
  await slice(page, 'y', 3);
  await page.uncheck('#mesh-lines');
  const [[hidden], [shown]] = await legend(page);
  await page.uncheck(`#legend tr[data-flag="${hidden}"] input[type=checkbox]`);
  await draws('y3', ['--axis=y', at(3, 29), '--no-lines', `--flags=0,${shown}`]);
  await page.click('#zoom-in-y');
  const { name, bytes } = await saved(page, '#save-view-y');
  assert.match(name, /-y3-view\.png$/);
  const size = await page.$eval('#canvas-y', ({ width, height }) => [width, height]);
  assert.deepEqual([bytes.readUInt32BE(16), bytes.readUInt32BE(20)], size);
});

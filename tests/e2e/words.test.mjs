// The page says the true reason, names what helps, and has a button that does it.

import assert from 'node:assert/strict';

import { CLOSED_BOX, LID, OPEN_BOX, boxBetween } from './open_box.mjs';
import { hasGeometries, legend, run, saved, test } from './visit.mjs';

/** Adds files to those of the page, which then has so many. */
async function add(page, files, n_files = Object.keys(files).length) {
  const payload = Object.entries(files).map(([name, text]) => ({ name, mimeType: 'model/stl', buffer: Buffer.from(text) }));
  await page.setInputFiles('#file-input', payload);
  await hasGeometries(page, n_files);
}

test('a file that is dropped twice is said to be there twice, before the mesh and after it', async ({ visit }) => {
  const page = await visit('#cells=20&backend=cpu');
  await add(page, { 'box.stl': CLOSED_BOX });
  await add(page, { 'copy of box.stl': CLOSED_BOX }, 2);
  assert.match(
    await page.textContent('#messages'),
    /^The surface of copy of box\.stl is that of box\.stl, at the same place: the later gets all cells of both\./,
  );
  await run(page);
  assert.match(await page.textContent('#finding-list'), /"box" \(flag 1\) got no cell: .* copy of box\.stl is on the page twice/);
  await page.getByRole('button', { name: 'Remove it' }).click();
  await page.waitForFunction(() => document.querySelectorAll('.geometry').length === 1);
  assert.equal(await page.getAttribute('.geometry', 'data-file'), 'copy of box.stl');
  // at another place it is no copy
  await add(page, { 'box.stl': CLOSED_BOX }, 2);
  await page.getByRole('button', { name: 'Remove the copy' }).click();
  await page.waitForFunction(() => document.querySelectorAll('.geometry').length === 1);
  assert.equal(await page.getAttribute('.geometry', 'data-file'), 'copy of box.stl');
});

test('patches of a boundary are said to be parts of one surface, and joined', async ({ visit }) => {
  const page = await visit('#cells=20&backend=cpu');
  await add(page, { 'tub.stl': OPEN_BOX, 'lid.stl': LID });
  const message = page.locator('#messages .message', { hasText: 'parts of one closed surface' });
  assert.match(
    await message.textContent(),
    /^tub\.stl and lid\.stl are parts of one closed surface: apart, none of them has an inside\./,
  );
  await run(page);
  assert.match(await page.textContent('#finding-list'), /With lid it is one closed surface, of which it is a part\./);
  await page.locator('#finding-list').getByRole('button', { name: 'Join the parts' }).first().click();
  await hasGeometries(page, 1);
  assert.match(await page.textContent('.geometry .facts'), /Facets12.*Surfaceclosed$/);
  const { name, bytes } = await saved(page, 'text=Save joined.stl');
  assert.deepEqual([name, bytes.length], ['joined.stl', 84 + 50 * 12]);
  await run(page);
  assert.deepEqual(await legend(page), [[1, 2000]]);
  assert.equal(await page.locator('#finding-list li').count(), 0);
  // an open surface that nothing completes is not offered a part
  const other = await visit('#cells=20&backend=cpu');
  await add(other, { 'tub.stl': OPEN_BOX, 'other.stl': OPEN_BOX.replaceAll('vertex 4', 'vertex 5') });
  await run(other);
  assert.doesNotMatch(await other.textContent('body'), /parts of one closed surface/);
});

test('cells are compared with facets only where nothing else takes cells, and known overlaps are named', async ({ visit }) => {
  const page = await visit('#cell_size=0.5&backend=cpu');
  await add(page, { 'left.stl': boxBetween([0, 0, 0], [4, 4, 4]), 'right.stl': boxBetween([3, 0, 0], [8, 4, 4]) });
  const volumes = () => page.$$eval('#legend td:last-child small', (cells) => cells.map((cell) => cell.textContent));
  await run(page);
  assert.deepEqual(await volumes(), ['', '0.00 % vs facets']);
  await page.click('#settings summary');
  await page.check('#certify');
  await run(page);
  assert.deepEqual(await volumes(), ['128 more in right', '0.00 % vs facets']);
  // what is hidden can be let win
  const other = await visit('#cell_size=0.5&backend=cpu');
  await add(other, { 'core.stl': boxBetween([1, 1, 1], [2, 2, 2]), 'coat.stl': boxBetween([0, 0, 0], [4, 4, 4]) });
  await run(other);
  assert.match(
    await other.textContent('#finding-list'),
    /"core" \(flag 1\) got no cell: its cells are those of "coat" \(flag 2\)/,
  );
  await other.getByRole('button', { name: 'Let it win' }).click();
  assert.equal(await other.inputValue('.geometry .priority'), '1');
  await run(other);
  assert.deepEqual(await legend(other), [
    [1, 8],
    [2, 504],
  ]);
});

test('a file is split only where its solids are closed', async ({ visit }) => {
  const page = await visit('#cells=20&backend=cpu');
  await add(page, { 'patches.stl': OPEN_BOX + LID });
  assert.match(await page.textContent('.geometry .note'), /^2 solids, of which none is closed: they are meshed as one geometry$/);
  assert.equal(await page.locator('.split').count(), 0);
  await add(page, { 'two.stl': CLOSED_BOX + boxBetween([6, 0, 0], [8, 2, 2]) }, 2);
  assert.equal(await page.locator('.geometry[data-file="two.stl"] .split').count(), 1);
});

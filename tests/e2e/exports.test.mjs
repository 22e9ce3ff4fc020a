// Files for solvers on the page: those that the native command writes, with the flags and the form that the page asks for.

import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { mkdirSync, mkdtempSync, readFileSync, readdirSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';

import { runCopied, writeSample } from './native.mjs';
import { hasGeometries, run, saved, test } from './visit.mjs';

const SETTINGS =
  'dims=31+29+37&padding=2&axis=y&g=file%3Dcore.stl%26name%3Dcore+of+it%26flag%3D9%26priority%3D2%26translate%3D6+0+1&sample=shells&backend=cpu';
const SUMMARY = '#exports > summary';

/** The buttons of the list, by what they save. */
const offered = (page) => page.$$eval('#exports-list button', (buttons) => buttons.map(({ id }) => id.replace('download-', '')));

test('a case of OpenFOAM, text, and the cells of some flags are the files of the native command', async ({ visit }) => {
  const folder = mkdtempSync(path.join(tmpdir(), 'hexcast-'));
  try {
    const page = await visit(`#unit=mm&${SETTINGS}`);
    await hasGeometries(page, 2);
    for (const [index, material] of ['eps_r=2.25, sigma=1e-3', 'pec'].entries()) {
      const card = page.locator('.geometry').nth(index);
      await card.locator('summary:text-is("Material")').click();
      await card.locator('.material').fill('eps=2');
      assert.match(await card.locator('.material').evaluate(({ validationMessage }) => validationMessage), /eps_r, mu_r/);
      await card.locator('.material').fill(material);
    }
    await page.waitForFunction(() => location.hash.includes('material%3Dpec'));
    await run(page);
    await page.click(SUMMARY);
    assert.deepEqual(await offered(page), ['foam', 'inp', 'msh', 'csx', 'openmc', 'nrrd', 'vox']);
    await writeSample('shells', folder);
    mkdirSync(path.join(folder, 'case'));
    await runCopied(page, folder, [
      '--compress=6',
      '-o',
      'case/mesh.foam',
      '-o',
      'all.nrrd',
      '-o',
      'geometry.xml',
      '-o',
      'all.vox',
      '-o',
      'all.csx.xml',
    ]);
    const { name, bytes } = await saved(page, '#download-foam');
    assert.equal(name, 'coating.foam.zip');
    const archive = path.join(folder, name);
    writeFileSync(archive, bytes);
    execFileSync('python3', ['-m', 'zipfile', '-e', archive, path.join(folder, 'unpacked')]);
    const parts = ['points', 'faces', 'owner', 'neighbour', 'boundary', 'cellZones'].map((part) => `constant/polyMesh/${part}`);
    assert.equal(readdirSync(path.join(folder, 'unpacked'), { recursive: true }).length, parts.length + 3);
    for (const part of [...parts, 'mesh.foam']) {
      const [ours, theirs] = ['unpacked', 'case'].map((where) => readFileSync(path.join(folder, where, part)));
      assert.ok(ours.equals(theirs), `${part}: ${ours.length} bytes, ${theirs.length} by the native command`);
    }
    for (const [id, file] of [
      ['nrrd', 'all.nrrd'],
      ['openmc', 'geometry.xml'],
      ['vox', 'all.vox'],
      ['csx', 'all.csx.xml'],
    ]) {
      const made = await saved(page, `#download-${id}`);
      assert.ok(made.bytes.equals(readFileSync(path.join(folder, file))), file);
      if (id === 'openmc') assert.equal(made.name, 'geometry.xml');
    }
    // text, and the cells of some flags
    await page.fill('#export-flags', '9, 0');
    await page.check('#export-ascii');
    await runCopied(page, folder, ['--export-flags=9,0', '--ascii', '-o', 'some.msh', '-o', 'some.inp']);
    for (const ending of ['msh', 'inp']) {
      const made = await saved(page, `#download-${ending}`);
      assert.ok(made.bytes.equals(readFileSync(path.join(folder, `some.${ending}`))), ending);
    }
    // the reason is said where the button is
    await page.click('#download-csx');
    await page.waitForSelector('#messages [data-code=export-material]');
    assert.match(await page.textContent('#messages'), /openEMS needs to know what flag 0 is made of/);
    // a flag that no cell has
    await page.fill('#export-flags', '9, 77');
    assert.equal(await page.$$eval('#exports-list button:enabled', ({ length }) => length), 0);
    assert.equal(
      await page.$eval('#export-flags', ({ validationMessage }) => validationMessage),
      'these are flags of the mesh: 0, 1, 9',
    );
    await page.fill('#export-flags', '');
    assert.equal(await page.$$eval('#exports-list button:disabled', ({ length }) => length), 0);
  } finally {
    rmSync(folder, { recursive: true });
  }
});

test('only files that the mesh can be are offered: without a unit, of cubes, and of cells that differ in size', async ({
  visit,
}) => {
  const page = await visit('#cells=20&sample=cubes&backend=cpu');
  await hasGeometries(page, 2);
  await run(page);
  await page.click(SUMMARY);
  assert.deepEqual(await offered(page), ['msh', 'nrrd', 'vox', 'binvox']);
  assert.ok(await page.isVisible('#exports-unit'));
  await page.selectOption('#unit', 'cm');
  await page.check('#graded');
  await page.fill('#graded-most', '0.2');
  await run(page);
  assert.deepEqual(await offered(page), ['foam', 'inp', 'msh', 'csx']);
  assert.ok(!(await page.isVisible('#exports-unit')));
});

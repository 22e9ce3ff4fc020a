// Files for solvers on the page: those that the native command writes, with the flags and the form that the page asks for.

import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { mkdirSync, mkdtempSync, readFileSync, readdirSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';

import { expect } from '@playwright/test';

import { runCopied, writeSample } from './native.mjs';
import { hasGeometries, run, saved, test } from './visit.mjs';

const SETTINGS =
  'dims=31+29+37&padding=2&axis=y&g=file%3Dcore.stl%26name%3Dcore+of+it%26flag%3D9%26priority%3D2%26translate%3D6+0+1&sample=shells&backend=cpu';
const SUMMARY = '#file-options > summary';
/** Files of programs. */
const EXPORTS = ['foam', 'inp', 'msh', 'xdmf', 'csx-xml', 'in', 'geometry-xml', 'nrrd', 'vox', 'glb', 'stl', 'binvox'];

/** The files of programs in the list, and those that nobody can click. */
const offered = async (page, which = '') => {
  const ids = await page.$$eval(`#downloads button${which}`, (buttons) => buttons.map(({ id }) => id.replace('download-', '')));
  return ids.filter((id) => EXPORTS.includes(id));
};
const ARRAYS = ['npz', 'npy', 'raw', 'sidecar'];

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
    assert.deepEqual(await offered(page), [
      'foam',
      'inp',
      'msh',
      'xdmf',
      'csx-xml',
      'in',
      'geometry-xml',
      'nrrd',
      'vox',
      'glb',
      'stl',
    ]);
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
      '-o',
      'mesh.xdmf',
      '-o',
      'mesh.in',
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
      ['geometry-xml', 'geometry.xml'],
      ['vox', 'all.vox'],
      ['csx-xml', 'all.csx.xml'],
    ]) {
      const made = await saved(page, `#download-${id}`);
      assert.ok(made.bytes.equals(readFileSync(path.join(folder, file))), file);
      if (id === 'geometry-xml') assert.equal(made.name, 'geometry.xml');
    }
    // HDF5 beside text: another crate writes its bytes
    for (const [id, parts, numbers] of [
      ['xdmf', ['mesh.xdmf'], 'mesh.h5'],
      ['in', ['mesh.in', 'mesh_materials.json'], 'mesh_geo.h5'],
    ]) {
      const made = await saved(page, `#download-${id}`);
      assert.equal(made.name, `coating.${id}.zip`);
      const inner = path.join(folder, id);
      writeFileSync(`${inner}.zip`, made.bytes);
      execFileSync('python3', ['-m', 'zipfile', '-e', `${inner}.zip`, inner]);
      assert.deepEqual(readdirSync(inner).sort(), [...parts, numbers].sort());
      for (const part of parts)
        assert.ok(readFileSync(path.join(inner, part)).equals(readFileSync(path.join(folder, part))), part);
      assert.equal(readFileSync(path.join(inner, numbers)).toString('latin1', 0, 8), '\x89HDF\r\n\x1a\n');
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
    await page.click('#download-csx-xml');
    await page.waitForSelector('#messages [data-code=export-material]');
    assert.match(await page.textContent('#messages'), /openEMS needs to know what flag 0 is made of/);
    // a flag that no cell has
    await page.fill('#export-flags', '9, 77');
    assert.deepEqual(await offered(page, ':enabled'), []);
    assert.equal(
      await page.$eval('#export-flags', ({ validationMessage }) => validationMessage),
      'these are flags of the mesh: 0, 1, 9',
    );
    await page.fill('#export-flags', '');
    assert.deepEqual(await offered(page, ':disabled'), []);
  } finally {
    rmSync(folder, { recursive: true });
  }
});

test('arrays in another order, stores, what was measured and the background are the files of the native command', async ({
  visit,
}) => {
  const folder = mkdtempSync(path.join(tmpdir(), 'hexcast-'));
  try {
    const page = await visit(`#unit=mm&links=true&stencil=D3Q7&fractions=true&background=eps_r%3D1.5&${SETTINGS}`);
    await hasGeometries(page, 2);
    await page.click('#background-of > summary');
    assert.equal(await page.inputValue('#background'), 'eps_r=1.5');
    await page.fill('#background', 'eps=2');
    assert.match(await page.$eval('#background', ({ validationMessage }) => validationMessage), /eps_r, mu_r/);
    await page.fill('#background', 'eps_r=1.0006, sigma=1e-9');
    await page.waitForFunction(() => location.hash.includes('background=eps_r%3D1.0006+sigma%3D1e-9'));
    for (const index of [0, 1]) {
      const card = page.locator('.geometry').nth(index);
      await card.locator('summary:text-is("Material")').click();
      await card.locator('.material').fill('eps_r=3');
    }
    await run(page);
    await writeSample('shells', folder);
    const read = (name) => readFileSync(path.join(folder, name));
    await runCopied(page, folder, ['--compress=6', '-o', 'all.zarr.zip', '--links=all.links', '--fractions=all.solid.vti']);
    await runCopied(page, folder, ['--compress=6', '--fractions=all.solid.zarr.zip']);
    await runCopied(page, folder, ['--fractions=all.solid.npy']);
    for (const [id, ending] of [
      ['zarr', 'zarr.zip'],
      ['links-records', 'links'],
      ['solid-vti', 'solid.vti'],
      ['solid-npy', 'solid.npy'],
      ['solid-zarr', 'solid.zarr.zip'],
    ]) {
      const said = await page.getAttribute(`#download-${id} .size`, 'data-bytes');
      const { name, bytes } = await saved(page, `#download-${id}`);
      assert.equal(name, `coating.${ending}`);
      assert.ok(bytes.equals(read(`all.${ending}`)), `${name}: ${bytes.length} bytes`);
      if (said !== null) assert.equal(bytes.length, Number(said), name);
    }
    assert.equal(await page.isVisible('#download-solid-vtr'), false);
    await page.click(SUMMARY);
    await page.selectOption('#export-order', 'xyz');
    await page.fill('#export-map', '9=0, 0=1');
    const words = ['--axis-order=xyz', '--map=9=0,0=1', '--compress=6'];
    await runCopied(page, folder, [...words, '-o', 'turned.npy', '-o', 'turned.npz', '-o', 'turned.raw']);
    for (const [id, ending] of [
      ['npy', 'npy'],
      ['npz', 'npz'],
      ['raw', 'raw'],
      ['sidecar', 'raw.json'],
    ]) {
      const { name, bytes } = await saved(page, `#download-${id}`);
      assert.ok(bytes.equals(read(`turned.${ending}`)), `${name}: ${bytes.length} bytes`);
    }
    // a number that is none, and a flag that is given twice
    for (const wrong of ['9=256', '9=1, 9=2', '9', 'a=1']) {
      await page.fill('#export-map', wrong);
      for (const id of ARRAYS) assert.ok(await page.isDisabled(`#download-${id}`), `${id}: ${wrong}`);
      assert.match(await page.$eval('#export-map', ({ validationMessage }) => validationMessage), /^such as 1=0, 0=1/);
    }
    await page.fill('#export-map', '');
    assert.equal(await page.$$eval('#downloads button:disabled', ({ length }) => length), 0);
    // flag 0 has a material
    await page.fill('#export-flags', '0, 9');
    await runCopied(page, folder, ['--export-flags=0,9', '-o', 'all.csx.xml']);
    const { bytes } = await saved(page, '#download-csx-xml');
    assert.ok(bytes.equals(read('all.csx.xml')) && bytes.includes('1.0006'), 'openEMS');
  } finally {
    rmSync(folder, { recursive: true });
  }
});

test('only files that the mesh can be are offered: of cubes, and of cells that differ in size; a unit is asked for', async ({
  visit,
}) => {
  const page = await visit('#cells=20&sample=cubes&backend=cpu');
  await hasGeometries(page, 2);
  await run(page);
  assert.deepEqual(await offered(page), EXPORTS);
  // what needs a unit asks for it
  await page.getByRole('button', { name: /^OpenFOAM .* asks for the unit$/ }).click();
  await expect(page.getByLabel('For which program?')).toHaveValue('OpenFOAM');
  await expect(page.getByLabel('Lengths of the files are in')).toBeFocused();
  await page.keyboard.press('c');
  await expect(page.getByLabel('Unit of the files')).toHaveValue('cm');
  await expect(page.locator('#result-size')).toContainText('cm');
  await page.check('#graded');
  await page.fill('#graded-most', '0.2');
  await run(page);
  assert.deepEqual(await offered(page), ['foam', 'inp', 'msh', 'xdmf', 'csx-xml', 'glb', 'stl']);
});

test('cells cut at the surface are those of the native command', async ({ visit }) => {
  const folder = mkdtempSync(path.join(tmpdir(), 'hexcast-'));
  try {
    const page = await visit('#cells=16&padding=2&unit=mm&cut_cells=true&cut_fluid=0&sample=shells&backend=cpu');
    await hasGeometries(page, 1);
    await expect(page.getByLabel('Cells cut at the surface (OpenFOAM, AMReX)')).toBeChecked();
    await expect(page.getByLabel('Flag that is cut, 0 for the background')).toHaveValue('0');
    await run(page);
    await page.click(SUMMARY);
    await writeSample('shells', folder);
    await runCopied(page, folder, ['-o', 'coating.eb']);
    for (const [id, files] of [
      ['foam', 7],
      ['eb', 32],
    ]) {
      const { name, bytes } = await saved(page, `#download-${id}`);
      const unpacked = path.join(folder, `of-${id}`);
      writeFileSync(path.join(folder, name), bytes);
      execFileSync('python3', ['-m', 'zipfile', '-e', path.join(folder, name), unpacked]);
      const names = readdirSync(unpacked, { recursive: true, withFileTypes: true }).filter((entry) => entry.isFile());
      assert.equal(names.length, files);
      for (const { parentPath, name: part } of names) {
        const inner = path.relative(unpacked, path.join(parentPath, part)).replace(/^mesh\b/, 'coating');
        const ours = readFileSync(path.join(parentPath, part));
        assert.ok(ours.equals(readFileSync(path.join(folder, inner))), inner);
      }
      await expect(page.locator(`li:has(#download-${id})`)).toContainText('Saved.');
    }
  } finally {
    rmSync(folder, { recursive: true, force: true });
  }
});

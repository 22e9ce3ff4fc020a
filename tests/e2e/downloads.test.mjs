// Files out: byte for byte those of the native command, by every way that browsers have to save them.

import assert from 'node:assert/strict';
import { createHash } from 'node:crypto';
import { createReadStream, mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';

import { runCopied, writeSample } from './native.mjs';
import { hasGeometries, isIdle, legend, run, saved, test } from './visit.mjs';

/** The page's download and the name that the native command gives the same file. */
const FILES = [
  ['vti', 'plain.vti'],
  ['vtiz', 'zlib.vti'],
  ['npy', 'plain.npy'],
  ['raw', 'plain.raw'],
  ['sidecar', 'plain.raw.json'],
  ['hxc', 'plain.hxc'],
];
const PACKED = [
  ['npy-bits', 'bits.npy'],
  ['raw-bits', 'bits.raw'],
  ['sidecar-bits', 'bits.raw.json'],
];

/** Saves every file of a job from the page and from the native command, and compares them. */
async function compareWithNative(visit, sample, n_files, settings, isPacked) {
  const folder = mkdtempSync(path.join(tmpdir(), 'hexcast-'));
  try {
    const page = await visit(`#${settings}&sample=${sample}&backend=gpu`);
    await hasGeometries(page, n_files);
    await run(page);
    await writeSample(sample, folder);
    const outputs = (...names) => names.flatMap((name) => ['-o', name]);
    await runCopied(page, folder, ['--compress=none', ...outputs('plain.vti', 'plain.npy', 'plain.raw')]);
    const report = await runCopied(page, folder, ['--compress=6', '--hash=sha256', ...outputs('zlib.vti', 'plain.hxc')]);
    if (isPacked) await runCopied(page, folder, ['--bits', '--compress=none', ...outputs('bits.npy', 'bits.raw')]);
    for (const [id, name] of isPacked ? [...FILES, ...PACKED] : FILES) {
      const said = await page.getAttribute(`#download-${id} .size`, 'data-bytes');
      const { bytes } = await saved(page, `#download-${id}`);
      const expected = readFileSync(path.join(folder, name));
      assert.ok(expected.equals(bytes), `${sample}, ${id}: ${bytes.length} bytes, ${expected.length} by the native command`);
      if (said !== null) assert.equal(bytes.length, Number(said), id);
    }
    assert.equal(await page.isVisible('#download-npy-bits'), isPacked);
    const cells = await legend(page);
    assert.deepEqual(
      cells,
      report.flags.map(({ flag, cells }) => [flag, cells]),
    );
    await page.click('#results summary:text-is("Report")');
    await page.click('#hash');
    await page.waitForFunction(() => document.querySelector('#result-hash').textContent.length === 64);
    assert.equal(await page.textContent('#result-hash'), report.flags_sha256);
  } finally {
    rmSync(folder, { recursive: true });
  }
}

test('a sample: every download is the native file, packed ones too', ({ visit }) =>
  compareWithNative(visit, 'knot', 1, 'cells=53&unit=mm', true));

test('two geometries with priorities: every download is the native file', ({ visit }) =>
  compareWithNative(
    visit,
    'shells',
    2,
    'dims=31+29+37&padding=2&rule=nonzero&axis=y&g=file%3Dcore.stl%26name%3Dcore+of+it%26flag%3D9%26priority%3D2%26translate%3D6+0+1',
    false,
  ));

test('a column file opens again, and files are named after the model', async ({ site, visit }) => {
  const page = await visit('#cells=20&sample=cubes&unit=mm&backend=gpu');
  await hasGeometries(page, 2);
  await run(page);
  const { bytes: sidecar } = await saved(page, '#download-sidecar');
  assert.equal(JSON.parse(sidecar).unit, 'mm');
  await page.click('#results summary:text-is("Report")');
  const { bytes: report } = await saved(page, '#save-report');
  assert.deepEqual(JSON.parse(report).dims, [20, 10, 10]);
  const { name, bytes: columns } = await saved(page, '#download-hxc');
  assert.equal(name, 'copper.hxc');
  await page.goto(`${site}?empty`);
  await isIdle(page);
  await page.setInputFiles('#file-input', { name: 'again.hxc', mimeType: '', buffer: columns });
  await page.waitForSelector('#legend tr');
  assert.deepEqual(await legend(page), [
    [1, 1000],
    [2, 500],
  ]);
  assert.equal(await page.isVisible('#stale'), false);
});

test('where the browser lets one pick a place, files are streamed to it', async ({ visit }) => {
  const page = await visit('#cells=20&sample=cubes&backend=gpu');
  await hasGeometries(page, 2);
  await run(page);
  // the private file system stands for the place that the user would pick
  await page.evaluate(() => {
    window.showSaveFilePicker = async ({ suggestedName }) =>
      (await navigator.storage.getDirectory()).getFileHandle(suggestedName, { create: true });
  });
  const read = (name) =>
    page.evaluate(async (name) => {
      const file = await (await (await navigator.storage.getDirectory()).getFileHandle(name)).getFile();
      return [...new Uint8Array(await file.arrayBuffer())];
    }, name);
  for (const [id, name] of [
    ['npy', 'copper.npy'],
    ['sidecar', 'copper.raw.json'],
  ]) {
    await page.click(`#download-${id}`);
    await page.waitForFunction((id) => document.querySelector(`#download-${id} + [role=status]`).textContent === 'Saved.', id);
    const picked = Buffer.from(await read(name));
    await page.evaluate(() => {
      window.picker = window.showSaveFilePicker;
      window.showSaveFilePicker = undefined;
    });
    assert.ok(picked.equals((await saved(page, `#download-${id}`)).bytes), name);
    await page.evaluate(() => {
      window.showSaveFilePicker = window.picker;
    });
  }
  // whoever closes the dialogue has changed his mind: nothing is saved, and nothing is wrong
  await page.evaluate(() => {
    window.showSaveFilePicker = async () => {
      throw new DOMException('closed', 'AbortError');
    };
  });
  await page.click('#download-raw');
  await page.waitForFunction(() => document.querySelector('#download-raw + [role=status]').textContent === 'Cancelled.');
  assert.equal(await page.textContent('#messages'), '');
});

/** Names of the files that the page holds in its private file system. */
function privateNames(page) {
  return page.evaluate(async () => {
    const names = [];
    const root = await navigator.storage.getDirectory();
    const folder = await root.getDirectoryHandle('hexcast-downloads').catch(() => null);
    for await (const name of folder?.keys() ?? []) names.push(name);
    return names;
  });
}

test('without a picker large files go through the private file system, which is emptied by the next visit', async ({
  site,
  visit,
}) => {
  const page = await visit('#dims=1024 512 490&sample=cubes&backend=gpu');
  await hasGeometries(page, 2);
  await run(page);
  const [download] = await Promise.all([page.waitForEvent('download', { timeout: 120_000 }), page.click('#download-raw')]);
  const hash = createHash('sha256');
  for await (const piece of createReadStream(await download.path())) hash.update(piece);
  assert.deepEqual(await privateNames(page), ['copper.raw']);
  const { bytes: sidecar } = await saved(page, '#download-sidecar');
  assert.match(JSON.parse(sidecar).flags_hash, /^hx1-[0-9a-f]{32}$/);
  await page.click('#results summary:text-is("Report")');
  await page.click('#hash');
  await page.waitForFunction(() => document.querySelector('#result-hash').textContent.length === 64);
  assert.equal(await page.textContent('#result-hash'), hash.digest('hex'));
  // a small one needs no file system
  await saved(page, '#download-hxc');
  assert.deepEqual(await privateNames(page), ['copper.raw']);
  await page.goto(`${site}?empty`);
  await isIdle(page);
  await page.waitForFunction(async () => {
    const root = await navigator.storage.getDirectory();
    return root.getDirectoryHandle('hexcast-downloads').then(
      () => false,
      () => true,
    );
  });
});

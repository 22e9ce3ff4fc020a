// Cells that differ in size, and what is measured beside the cells: drawn as they are, saved as the native command writes them.

import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';

import { PROGRAM, runCopied, writeSample } from './native.mjs';
import { COPPER, EPOXY, hasGeometries, legend, run, saved, take, test } from './visit.mjs';

const LINES = 'graded=1.1&min_size=0.05&growth=1.4&absorbing=2&padding=1.5&padding_by=length';
const PARTS = '&g=file%3Dcopper.stl%26flag%3D1%26metal%3Dtrue&g=file%3Depoxy.stl%26flag%3D2%26min_cells%3D5';

/** Runs an act with a folder that holds a sample. */
async function inFolder(sample, act) {
  const folder = mkdtempSync(path.join(tmpdir(), 'hexcast-'));
  try {
    await writeSample(sample, folder);
    await act(folder);
  } finally {
    rmSync(folder, { recursive: true });
  }
}

/** The report that the page shows. */
async function reportOf(page) {
  return JSON.parse(await page.textContent('#report'));
}

/** Colours in the middles of the cells of the slice shown, `[j][i]`, found by the lines alone; null for the background. */
function coloursOf(page, xs, ys) {
  return page.$eval(
    '#canvas-z',
    (canvas, [xs, ys]) => {
      const [left, top, dx, dy, width, height] = ['left', 'top', 'scaleX', 'scaleY', 'width', 'height'].map((key) =>
        Number(canvas.dataset[key]),
      );
      const copy = new OffscreenCanvas(canvas.width, canvas.height).getContext('2d', { willReadFrequently: true });
      copy.fillStyle = getComputedStyle(canvas).getPropertyValue('--cells-background').trim();
      const background = copy.fillStyle;
      copy.drawImage(canvas, 0, 0);
      const { data } = copy.getImageData(0, 0, canvas.width, canvas.height);
      const middle = (lines, index) => ((lines[index] + lines[index + 1]) / 2 - lines[0]) / (lines[lines.length - 1] - lines[0]);
      return ys.slice(1).map((_, j) =>
        xs.slice(1).map((_, i) => {
          const x = Math.floor(left + middle(xs, i) * dx * width);
          const y = Math.floor(top + (1 - middle(ys, j)) * dy * height);
          const at = 4 * (x + canvas.width * y);
          const found = `#${[...data.slice(at, at + 3)].map((part) => part.toString(16).padStart(2, '0')).join('')}`;
          return found === background ? null : found;
        }),
      );
    },
    [xs, ys],
  );
}

/** Flags of a plane across z, from the bytes of a raw file. */
function plane(raw, [nx, ny], z) {
  const colours = [null, COPPER, EPOXY];
  const row = (j) => Array.from({ length: nx }, (_, i) => colours[raw[i + nx * (j + ny * z)]]);
  return Array.from({ length: ny }, (_, j) => row(j));
}

test('graded lines: cells are drawn in their sizes, and files are those of the native command', async ({ visit }) => {
  await inFolder('cubes', async (folder) => {
    const page = await visit(
      `#${LINES}&fractions=true&fraction_rays=0&fraction_edges=true&fraction_centroids=true&links=true&stencil=D3Q7&staggered=true&conformal=true&distance=true&unit=mm&sample=cubes${PARTS}`,
    );
    await hasGeometries(page, 2);
    await page.waitForSelector('#estimate-courant');
    const lines = await page.textContent('#estimate-lines');
    const facts = await page.textContent('#estimate');
    assert.match(facts, /Cells from0\.47\d* to 1\.0\d* mm/);
    assert.match(facts, /Courant step.*mm \/ c, .*e-1\d s/);
    await run(page);
    const report = await reportOf(page);
    assert.equal(lines, report.dims.map((n) => n + 1).join(', '));
    const outputs = (...names) => names.flatMap((name) => ['-o', name]);
    const native = await runCopied(page, folder, ['--compress=6', ...outputs('z.vtr', 'z.npz', 'plain.hxc')]);
    await runCopied(page, folder, ['--compress=none', ...outputs('plain.vtr', 'plain.raw')]);
    // the last run wrote these without compression
    await runCopied(page, folder, ['--compress=6']);
    assert.equal(report.flags_hash, native.flags_hash);
    for (const key of ['grading', 'links', 'fractions', 'staggered', 'conformal', 'distance'])
      assert.deepEqual(report[key], native[key], key);
    const files = {
      vtr: 'plain.vtr',
      vtrz: 'z.vtr',
      npz: 'z.npz',
      raw: 'plain.raw',
      hxc: 'plain.hxc',
      links: 'copper-links.npz',
      fractions: 'copper-fractions.npz',
      staggered: 'copper-staggered.npz',
      conformal: 'copper-conformal.npz',
      'distance-npz': 'copper-distance.npz',
    };
    for (const [id, name] of Object.entries(files)) {
      const { bytes } = await saved(page, `#download-${id}`);
      const expected = readFileSync(path.join(folder, name));
      assert.ok(expected.equals(bytes), `${id}: ${bytes.length} bytes, ${expected.length} by the native command`);
    }
    assert.equal(await page.$('#download-vti'), null, 'image data has equal cells');
    const raw = readFileSync(path.join(folder, 'plain.raw'));
    await page.check('#panes-z');
    // a mesh line may run through the middle of a cell of one pixel
    await page.uncheck('#mesh-lines');
    const z = Math.floor(report.dims[2] / 2);
    const { x, y } = report.grading;
    assert.deepEqual(await coloursOf(page, x, y), plane(raw, report.dims, z));
    // what was saved is opened again
    const other = await visit('');
    const buffer = readFileSync(path.join(folder, 'plain.hxc'));
    await other.setInputFiles('#file-input', { name: 'plain.hxc', mimeType: '', buffer });
    await other.waitForSelector('#legend tr');
    assert.deepEqual(await legend(other), await legend(page));
    assert.equal(await other.textContent('#result-lines'), lines);
    await other.check('#panes-z');
    await other.uncheck('#mesh-lines');
    await other.waitForFunction(() => document.querySelector('#canvas-z').dataset.index);
    assert.deepEqual(await coloursOf(other, x, y), plane(raw, report.dims, z));
  });
});

test('the fields of graded lines follow the switch, and a link has them', async ({ visit }) => {
  const page = await visit('');
  await take(page, 'cubes', 2);
  assert.equal(await page.isVisible('#graded-fields'), false);
  assert.equal(await page.isVisible('.geometry .metal'), false);
  await page.check('#graded');
  await page.fill('#graded-most', '0.8');
  await page.fill('#graded-least', '0.02');
  await page.fill('#graded-growth', '1.25');
  await page.fill('#graded-absorbing', '3');
  await page.check('.geometry[data-file="copper.stl"] .metal');
  await page.fill('.geometry[data-file="epoxy.stl"] .max-size', '0.4');
  await page.fill('.geometry[data-file="epoxy.stl"] .min-cells', '3');
  await page.click('#copy-command');
  const command = await page.inputValue('#copied-text');
  assert.equal(
    command,
    'hexcast mesh copper.stl:name=copper,flag=1,metal=true epoxy.stl:name=epoxy,flag=2,max_size=0.4,min_cells=3 --graded=0.8 --min-size=0.02 --growth=1.25 --absorbing=3 -o copper.vtr',
  );
  await page.click('#copy-link');
  const other = await visit(new URL(await page.inputValue('#copied-text')).hash);
  await hasGeometries(other, 2);
  await other.click('#copy-command');
  assert.equal(await other.inputValue('#copied-text'), command);
  await other.fill('#graded-most', '0');
  await other.waitForSelector('#field-error');
  await other.fill('#graded-most', '0.8');
  await other.waitForSelector('#field-error', { state: 'detached' });
  // a number of cells takes over
  await other.fill('#cells', '20');
  // what lies below the fields moves until the estimate is there
  await other.waitForSelector('#estimate-lines', { state: 'detached' });
  assert.equal(await other.isVisible('#graded-fields'), false);
  await other.click('#copy-command');
  assert.equal(
    await other.inputValue('#copied-text'),
    'hexcast mesh copper.stl:name=copper,flag=1 epoxy.stl:name=epoxy,flag=2 --cells=20 -o copper.vti',
  );
});

test('several sizes of cells are compared as by the native command', async ({ visit }) => {
  await inFolder('cubes', async (folder) => {
    const page = await visit('#cells=30&padding=2&sample=cubes');
    await hasGeometries(page, 2);
    await page.click('#converge summary');
    await page.fill('#converge-sizes', '24 9 13');
    await page.click('#converge-run');
    await page.waitForSelector('#converge-chart svg');
    const args = [
      'converge',
      'copper.stl:name=copper,flag=1',
      'epoxy.stl:name=epoxy,flag=2',
      '--sizes=9,13,24',
      '--padding-cells=2',
      '--json',
      '--backend=cpu',
    ];
    const native = JSON.parse(
      execFileSync(PROGRAM, args, { cwd: folder, encoding: 'utf8', stdio: ['ignore', 'pipe', 'ignore'] }),
    );
    const { bytes } = await saved(page, '#converge-json');
    const untimed = (levels) => levels.map(({ seconds: _, ...level }) => level);
    assert.deepEqual(untimed(JSON.parse(bytes)), untimed(native));
    const rows = await page.$$eval('#converge-tables .levels[data-flag="1"] tbody tr', (all) =>
      all.map((row) => row.cells[1].textContent),
    );
    assert.deepEqual(
      rows.map((text) => Number(text.replace('−', '-').replace(' %', '')).toPrecision(2)),
      native.map(({ flags }) => (100 * flags[0].volume_error).toPrecision(2)),
    );
    const chart = (await saved(page, '#converge-svg')).bytes.toString();
    assert.match(chart, /^<svg xmlns=/);
    await page.click('#converge-tables tbody tr:nth-child(2) button');
    // padding adds to it
    assert.equal(await page.inputValue('#cells'), '13');
    await page.fill('#converge-sizes', '0');
    await page.click('#converge-run');
    assert.equal(await page.$eval('#converge-sizes', (input) => input.validity.valid), false);
  });
});

/** Lines of a user's own around the sample of cubes, not equally far from each other on any axis. */
const LISTS = { x: [-1, 0, 1, 3, 6, 10, 13, 20, 22], y: [0, 2.5, 4, 10], z: [-0.5, 0, 1, 2, 9.5, 10, 11] };

test('lines of a file are meshed as the native command meshes them, and a link asks for the file', async ({ visit }) => {
  await inFolder('cubes', async (folder) => {
    const text = JSON.stringify(LISTS);
    writeFileSync(path.join(folder, 'lists.json'), text);
    const page = await visit('#padding=2&domain=0+0+0+1+1+1');
    await take(page, 'cubes', 2);
    await page.click('#settings > details > summary');
    assert.equal(await page.isVisible('#domain-choice'), true);
    await page.setInputFiles('#lines-input', { name: 'lists.json', mimeType: '', buffer: Buffer.from(text) });
    await page.waitForFunction(() => document.querySelector('#estimate-lines')?.textContent === '9, 4, 7');
    assert.equal(await page.textContent('#lines-given'), 'lists.json: 9, 4, 7 lines');
    assert.equal(await page.isVisible('#domain-choice'), false);
    await page.check('#links');
    await page.selectOption('#stencil', 'D3Q7');
    await page.fill('#fluid', '0 2');
    await run(page);
    const report = await reportOf(page);
    const native = await runCopied(page, folder, []);
    assert.equal(report.flags_hash, native.flags_hash);
    assert.deepEqual([report.dims, report.grading, report.links], [native.dims, native.grading, native.links]);
    assert.deepEqual(native.links.fluid, [0, 2]);
    // the address names the file; who opens it is asked for it
    const hash = await page.evaluate(() => location.hash);
    assert.match(hash, /lines=lists\.json/);
    assert.match(hash, /fluid=0\+2/);
    const other = await visit(hash);
    // the parts of the sample may be there already
    assert.match(await other.textContent('#waiting'), /settings for lists\.json[,:] /);
    await other.setInputFiles('#lines-input', { name: 'lists.json', mimeType: '', buffer: Buffer.from(text) });
    await other.waitForFunction(() => !document.querySelector('#waiting')?.textContent?.includes('lists.json'));
    await page.click('#remove-lines');
    assert.equal(await page.isVisible('#domain-choice'), true);
    await page.click('#copy-command');
    assert.doesNotMatch(await page.inputValue('#copied-text'), /--lines/);
  });
});

test('a file of lines that is wrong is refused in words', async ({ visit }) => {
  const page = await visit('');
  for (const [text, words] of [
    ['{', /wrong\.json: This is not JSON/],
    ['[]', /there is no list "x"/],
    ['{"x": [0, 1], "y": [0, "1"], "z": [0, 1]}', /Line 1 of "y" is "1", not a number/],
    ['{"x": [0, 1], "y": [0, 1], "z": [0, 1], "w": 2}', /a key "w" besides x, y and z/],
  ]) {
    await page.setInputFiles('#lines-input', { name: 'wrong.json', mimeType: '', buffer: Buffer.from(text) });
    await page.waitForFunction(
      (source) => new RegExp(source).test(document.querySelector('.message.error')?.textContent ?? ''),
      words.source,
    );
    await page.click('.message.error .icon');
  }
  assert.equal(await page.isVisible('#lines-given'), false);
});

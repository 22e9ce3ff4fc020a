// Files in: dropped, several at once, whole folders, malformed, and of points.

import assert from 'node:assert/strict';
import { copyFileSync, mkdirSync, mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';

import { ROOT } from '../../scripts/run.mjs';
import { sampleTexts } from './samples.mjs';
import { hasGeometries, isIdle, run, test } from './visit.mjs';

test('a malformed file gives a sentence and loses nothing', async ({ visit }) => {
  const page = await visit('#cells=20&sample=gear&backend=gpu');
  await hasGeometries(page, 1);
  await page.setInputFiles('#file-input', {
    name: 'letter.stl',
    mimeType: 'model/stl',
    buffer: Buffer.from('Dear Sir or Madam'),
  });
  await page.waitForSelector('#messages [role=alert]');
  const text = await page.textContent('#messages [role=alert] p');
  assert.match(text, /letter\.stl/);
  assert.match(text, /[.!?]$/);
  assert.match(await page.getAttribute('#messages [role=alert]', 'data-code'), /^stl-/);
  await hasGeometries(page, 1);
  await run(page);
});

test('a 3MF and a GLB are read, and the first unit becomes that of the settings', async ({ visit }) => {
  const page = await visit('#cells=40');
  await page.setInputFiles(
    '#file-input',
    ['3mf', 'glb'].map((ending) => path.join(ROOT, `tests/fixtures/scene.${ending}`)),
  );
  await hasGeometries(page, 2);
  assert.equal(await page.inputValue('#unit'), 'mm');
  await run(page);
  const findings = await page.textContent('#finding-list');
  assert.match(findings, /scene\.glb is in m, the job in mm: numbers are taken as they are/);
  await page.getByRole('button', { name: 'Scale scene.glb by 1000' }).click();
  await run(page);
  assert.deepEqual(
    JSON.parse(await page.textContent('#report')).findings.filter(({ code }) => code === 'unit-differs'),
    [],
  );
});

test('dropped files are read, several at once', async ({ visit }) => {
  const page = await visit('');
  const files = [...(await sampleTexts('cubes')), ...(await sampleTexts('gear'))];
  await page.evaluate((files) => {
    const dataTransfer = new DataTransfer();
    for (const [name, text] of files) {
      dataTransfer.items.add(new File([Uint8Array.from(text, (letter) => letter.charCodeAt(0))], name));
    }
    document.querySelector('#canvas-3d').dispatchEvent(new DragEvent('drop', { dataTransfer, bubbles: true, cancelable: true }));
  }, files);
  await hasGeometries(page, 3);
  assert.deepEqual(await page.$$eval('.geometry .flag', (inputs) => inputs.map((input) => input.value)), ['1', '2', '3']);
  await page.click('[aria-label="Remove epoxy"]');
  await hasGeometries(page, 2);
});

test('a sample takes the place of what there is, also of one that is still being read', async ({ visit }) => {
  const page = await visit('');
  await page.evaluate(() => {
    for (const id of ['gear', 'knot', 'cubes']) document.querySelector(`#empty [data-sample=${id}]`).click();
  });
  await hasGeometries(page, 2);
  await isIdle(page);
  assert.deepEqual(await page.$$eval('.geometry', (cards) => cards.map((card) => card.dataset.file)), [
    'copper.stl',
    'epoxy.stl',
  ]);
});

/**
 * Drops entries as browsers hand them over: files, and folders that are read a part at a time.
 *
 * @param {[string, object]} tree names with the sample file that they hold, a text, or a folder of the same kind
 */
async function dropTree(page, tree) {
  const samples = Object.fromEntries(await Promise.all(['knot', 'gear'].map(async (id) => [id, (await sampleTexts(id))[0][1]])));
  await page.evaluate(
    ({ tree, samples }) => {
      const entryOf = (name, value) => {
        if (typeof value === 'string') {
          const bytes = Uint8Array.from(samples[value] ?? value, (letter) => letter.charCodeAt(0));
          return { isFile: true, isDirectory: false, name, file: (resolve) => resolve(new File([bytes], name)) };
        }
        const entries = Object.entries(value).map(([name, value]) => entryOf(name, value));
        // two a call: a folder is read until nothing more comes
        const createReader = () => ({ readEntries: (resolve) => resolve(entries.splice(0, 2)) });
        return { isFile: false, isDirectory: true, name, createReader };
      };
      const items = Object.entries(tree).map(([name, value]) => ({ kind: 'file', webkitGetAsEntry: () => entryOf(name, value) }));
      const event = new Event('drop', { bubbles: true, cancelable: true });
      Object.defineProperty(event, 'dataTransfer', { value: { items: [{ kind: 'string' }, ...items] } });
      document.body.dispatchEvent(event);
    },
    { tree, samples },
  );
}

test('a dropped folder is searched for models, folders in it too', async ({ visit }) => {
  const page = await visit('');
  await dropTree(page, {
    parts: {
      'a.stl': 'knot',
      'notes.txt': 'read me',
      inner: { 'b.STL': 'gear', deeper: { 'c.stl': 'knot' } },
      'd.stl': 'gear',
    },
    'e.stl': 'knot',
  });
  await hasGeometries(page, 5);
  const names = await page.$$eval('.geometry', (cards) => cards.map((card) => card.dataset.file));
  assert.deepEqual(names.sort(), ['a.stl', 'b.STL', 'c.stl', 'd.stl', 'e.stl']);
  assert.equal(await page.locator('#messages [role=alert]').count(), 0);
  assert.equal(await page.locator('#messages').getByRole('button', { name: 'Remove the copy' }).count(), 3);
});

/** Drops files and folders of this machine onto the page: the browser's own drag, as from a file manager. */
async function dropPaths(page, files) {
  const session = await page.context().newCDPSession(page);
  const { x, y, width, height } = await page.locator('#canvas-3d').boundingBox();
  const data = { items: [], files, dragOperationsMask: 1 };
  for (const type of ['dragEnter', 'dragOver', 'drop']) {
    await session.send('Input.dispatchDragEvent', { type, x: x + width / 2, y: y + height / 2, data });
  }
  await session.detach();
}

test('a folder of the disk is dropped, with folders in it and files beside it', async ({ visit }) => {
  const folder = mkdtempSync(path.join(tmpdir(), 'hexcast-drop-'));
  const put = (name, from) => {
    const file = path.join(folder, name);
    mkdirSync(path.dirname(file), { recursive: true });
    if (from) copyFileSync(path.join(ROOT, 'tests/fixtures', from), file);
    else writeFileSync(file, 'read me');
    return file;
  };
  // more files than a browser hands over at once
  const names = Array.from({ length: 120 }, (_, index) => `parts/notes/${index}.txt`);
  for (const name of names) put(name);
  put('parts/cow.stl', 'spot.stl');
  put('parts/inner/deeper/CUBE.STL', 'bin_header_solid_cube.stl');
  const beside = put('beside.stl', 'ascii_two_solids_mixed_case.stl');
  try {
    const page = await visit('');
    await dropPaths(page, [path.join(folder, 'parts'), beside]);
    await hasGeometries(page, 3);
    const files = await page.$$eval('.geometry', (cards) => cards.map((card) => card.dataset.file));
    assert.deepEqual(files.sort(), ['CUBE.STL', 'beside.stl', 'cow.stl']);
    assert.equal(await page.textContent('#messages'), '');
    await run(page);
    await dropPaths(page, [path.join(folder, 'parts/notes')]);
    await page.waitForSelector('#messages [role=status]');
    assert.match(
      await page.textContent('#messages'),
      /^The folder has no file of a surface \(STL, OBJ, PLY, OFF, 3MF, GLB, STEP, IGES\)\./,
    );
  } finally {
    rmSync(folder, { recursive: true });
  }
});

test('a folder without models, and a file that is none, are said to be that', async ({ visit }) => {
  const page = await visit('');
  await dropTree(page, { empty: { 'notes.txt': 'read me', 'more.txt': 'and me' } });
  await page.waitForSelector('#messages [role=status]');
  assert.match(
    await page.textContent('#messages'),
    /^The folder has no file of a surface \(STL, OBJ, PLY, OFF, 3MF, GLB, STEP, IGES\)\./,
  );
  await dropTree(page, { 'notes.txt': 'read me' });
  await page.waitForSelector('#messages [role=alert]');
  assert.match(await page.textContent('#messages [role=alert]'), /notes\.txt/);
  await isIdle(page);
});

test('of facets that are points, however many, nothing is drawn but the model; files too large to be kept are asked about', async ({
  visit,
}) => {
  const page = await visit('#cells=16&backend=gpu');
  const isAsked = () => page.evaluate(() => !dispatchEvent(new Event('beforeunload', { cancelable: true })));
  await page.evaluate(() => {
    const n_facets = 5_000_001;
    const view = new DataView(new ArrayBuffer(84 + 50 * n_facets));
    view.setUint32(80, n_facets, true);
    // a tetrahedron; all other facets are points in its corner
    const corners = [
      [0, 0, 0],
      [8, 0, 0],
      [0, 8, 0],
      [0, 0, 8],
    ];
    [
      [0, 2, 1],
      [0, 1, 3],
      [0, 3, 2],
      [1, 2, 3],
    ].forEach((facet, at) =>
      facet
        .flatMap((corner) => corners[corner])
        .forEach((number, place) => view.setFloat32(84 + 50 * at + 12 + 4 * place, number, true)),
    );
    const dataTransfer = new DataTransfer();
    dataTransfer.items.add(new File([view], 'dust.stl'));
    document.body.dispatchEvent(new DragEvent('drop', { dataTransfer, bubbles: true, cancelable: true }));
  });
  await page.waitForSelector('.geometry', { timeout: 120_000 });
  await hasGeometries(page, 1);
  await page.waitForFunction(() => /5,000,001, drawn with 4/.test(document.querySelector('.geometry .facts').textContent));
  assert.equal(await page.textContent('#messages'), '');
  assert.ok(await isAsked());
  await run(page);
  await page.getByRole('button', { name: 'Remove dust' }).click();
  await page.setInputFiles('#file-input', path.join(ROOT, 'tests/fixtures/spot.stl'));
  await hasGeometries(page, 1);
  assert.ok(!(await isAsked()), 'smaller ones are kept');
});

test('before it is meshed a model says its facets, its box, its volume and whether it is closed', async ({ visit }) => {
  const page = await visit('');
  await page.setInputFiles(
    '#file-input',
    ['spot.stl', 'featuretype.stl'].map((file) => path.join(ROOT, 'tests/fixtures', file)),
  );
  await hasGeometries(page, 2);
  const facts = await page.$$eval('.geometry', (cards) =>
    cards.map((card) =>
      Object.fromEntries([...card.querySelectorAll('dt')].map((term) => [term.textContent, term.nextElementSibling.textContent])),
    ),
  );
  assert.deepEqual(facts[0], {
    Facets: '5,856',
    Size: '0.943104 × 1.69043 × 1.71791',
    From: '-0.471552, -0.736784, -0.668909',
    To: '0.471552, 0.953646, 1.049',
    Volume: '0.718259',
    Surface: 'closed',
  });
  assert.equal(facts[1].Volume, 'about 11.6277');
  assert.equal(facts[1].Surface, 'not closed: 576 open edges');
  await page.selectOption('#unit', 'mm');
  assert.match(await page.textContent('.geometry .facts'), /0\.718259 mm³/);
});

test('the solids of a file are one geometry or several, with flags that no other has', async ({ visit }) => {
  const page = await visit('#cells=60&backend=gpu');
  const files = ['ascii_two_solids_mixed_case.stl', 'bin_header_solid_cube.stl'].map((file) =>
    path.join(ROOT, 'tests/fixtures', file),
  );
  await page.setInputFiles('#file-input', files);
  await hasGeometries(page, 2);
  await page.fill('.geometry:nth-child(2) .name', 'block');
  await page.click('.geometry:nth-child(2) summary');
  // 100 long: as long as a solid, and beside both
  await page.fill('.geometry:nth-child(2) .scale', '0.01');
  await page.fill('.geometry:nth-child(2) .translate', '2.5 0.5 0.5');
  const flags = () => page.$$eval('.geometry .flag', (inputs) => inputs.map((input) => Number(input.value)));
  const meshed = async () => {
    await page.waitForSelector('#run:enabled');
    await run(page);
    return page.$$eval('#legend tr', (rows) =>
      rows.map((row) => `${row.querySelector('th').textContent}: ${row.querySelector('.cells').dataset.cells}`),
    );
  };
  assert.deepEqual(await meshed(), ['1 ascii_two_solids_mixed_case: 2000', '2 block: 1000']);
  await page.check('.split');
  assert.deepEqual(await flags(), [3, 2]);
  assert.ok(await page.isDisabled('.geometry .name'));
  assert.deepEqual(await meshed(), ['2 block: 1000', '3 CubeExportedFromCAD: 1000', '4 TranslatedCubeExportedFromCAD: 1000']);
  await page.uncheck('.split');
  assert.deepEqual(await meshed(), ['2 block: 1000', '3 ascii_two_solids_mixed_case: 2000']);
});

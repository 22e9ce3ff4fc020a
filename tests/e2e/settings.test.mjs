// The fields: links restore them, copies spell them out, sizes follow each other, and what cannot be is said before it is tried.

import assert from 'node:assert/strict';

import { hasGeometries, take, test } from './visit.mjs';

test('a link restores the parameters and never holds the geometry', async ({ visit }) => {
  const page = await visit('');
  await take(page, 'cubes', 2);
  await page.fill('#cell-size', '0.5');
  await page.click('#settings summary');
  await page.fill('#padding', '1 2 3');
  await page.selectOption('#rule', 'nonzero');
  await page.fill('#close-gaps', '3');
  await page.selectOption('#axis', 'x');
  await page.selectOption('#unit', 'mm');
  await page.fill('.geometry[data-file="copper.stl"] .priority', '3');
  await page.fill('.geometry[data-file="epoxy.stl"] .name', 'FR4 board');
  await page.click('.geometry[data-file="epoxy.stl"] summary');
  await page.fill('.geometry[data-file="epoxy.stl"] .about', '15 5 0');
  await page.fill('.geometry[data-file="epoxy.stl"] .rotate', '0 0 90');
  await page.click('#copy-command');
  const command = await page.inputValue('#copied-text');
  assert.equal(
    command,
    "hexcast mesh copper.stl:name=copper,flag=1,priority=3 'epoxy.stl:name=FR4 board,flag=2,rotate=0/0/90,about=15/5/0' --padding-cells=1,2,3 --cell-size=0.5 --rule=nonzero --close-gaps=3 --axis=x --unit=mm -o copper.vti",
  );
  await page.click('#copy-link');
  const link = await page.inputValue('#copied-text');
  assert.ok(link.length < 600, `${link.length} characters`);
  const other = await visit(new URL(link).hash);
  await hasGeometries(other, 2);
  assert.equal(await other.inputValue('#close-gaps'), '3');
  await other.click('#copy-command');
  assert.equal(await other.inputValue('#copied-text'), command);
});

/** Values of the linked fields and of the estimate beside them. */
function linked(page) {
  return page.evaluate(() => {
    const value = (id) => document.getElementById(id).value;
    const text = (id) => document.getElementById(id)?.textContent;
    return {
      cells: value('cells'),
      size: value('cell-size'),
      dims: ['x', 'y', 'z'].map((axis) => value(`dims-${axis}`)).join(' '),
      total: text('estimate-cells'),
      memory: text('estimate-memory'),
      file: text('estimate-file'),
    };
  });
}

test('whichever size is set, the others follow, with memory and the size of the file', async ({ visit }) => {
  const page = await visit('#sample=cubes&backend=cpu');
  await hasGeometries(page, 2);
  /** Fills a field and waits for the estimate of so many cells. */
  const fill = async (field, value, total) => {
    const { memory } = await linked(page);
    await page.fill(field, value);
    await page.waitForFunction((total) => document.querySelector('#estimate-cells')?.textContent === total, total);
    const found = await linked(page);
    assert.match(found.memory, /^about \d+(\.\d+)? kB$/);
    assert.notEqual(found.memory, memory);
    return found;
  };
  const { cells, size, dims, file } = await fill('#cells', '40', '16,000 (40 × 20 × 20)');
  assert.deepEqual([cells, size, dims, file], ['40', '0.5', '40 20 20', '16.0 kB, a byte a cell']);
  const bySize = await fill('#cell-size', '2', '250 (10 × 5 × 5)');
  assert.deepEqual([bySize.cells, bySize.dims, bySize.file], ['10', '10 5 5', '250 bytes, a byte a cell']);
  const byThree = await fill('#cell-size', '0.5 0.25 1', '16,000 (40 × 40 × 10)');
  assert.deepEqual([byThree.cells, byThree.dims], ['40', '40 40 10']);
  const byDims = await fill('#dims-y', '80', '32,000 (40 × 80 × 10)');
  assert.deepEqual([byDims.cells, byDims.size], ['80', '0.5 0.125 1']);
});

test('a field that holds what it must not is a sentence, and nothing is meshed until it is right', async ({ visit }) => {
  const page = await visit('#sample=cubes&cells=20');
  await hasGeometries(page, 2);
  await page.click('#settings summary');
  await page.click('.geometry summary');
  const wrong = [
    ['#cells', '-5', /^Cells along the longest axis: this is a whole number from 1 on\.$/, '20'],
    ['#cell-size', '0,5', /^Cell size: this is a length greater than 0/, '1'],
    ['#dims-y', '0', /^Cells on y: this is a whole number/, '10'],
    ['#padding', '1.5', /^Padding: this is a whole number of cells from 0/, '2'],
    ['.geometry .flag', '256', /^Flag of copper: .*255\.$/, '7'],
    ['.geometry .priority', '', /^Priority of copper: .+\.$/, '1'],
    ['.geometry .rotate', '90', /^Rotate copper.*: numbers, separated by spaces\.$/, '0 0 90'],
  ];
  for (const [field, value, sentence, right] of wrong) {
    await page.fill(field, value);
    assert.match(await page.textContent('#field-error'), sentence);
    assert.ok(await page.isDisabled('#run'), field);
    await page.fill(field, right);
    await page.waitForSelector('#field-error', { state: 'detached' });
    await page.waitForSelector('#run:enabled');
  }
  // a field that follows another is right again
  await page.fill('#cells', '1.5');
  await page.fill('#cell-size', '2');
  await page.waitForSelector('#field-error', { state: 'detached' });
  assert.equal(await page.locator('#settings input:invalid').count(), 0);
  // a box of one's own has six numbers
  await page.check('#domain-given');
  await page.fill('#domain-x0', '');
  assert.match(await page.textContent('#field-error'), /^Domain from x: /);
  await page.fill('#domain-x0', '500');
  assert.match(await page.textContent('#estimate-error'), /^Domain is 500 to .* along x; allowed: /);
  assert.ok(await page.isDisabled('#run'));
  await page.uncheck('#domain-given');
  await page.waitForSelector('#run:enabled');
});

test("a box of one's own may have padding, too", async ({ visit }) => {
  const page = await visit('#cell_size=0.5&padding=1');
  await take(page, 'cubes', 2);
  const says = (dims) =>
    page.waitForFunction((dims) => document.querySelector('#estimate-cells')?.textContent?.endsWith(`(${dims})`), dims);
  await says('42 × 22 × 22');
  await page.click('#settings > details > summary');
  // the box that it begins with has the padding of before
  await page.check('#domain-given');
  assert.equal(await page.inputValue('#padding'), '0');
  await says('42 × 22 × 22');
  await page.fill('#padding', '1 2 3');
  await says('44 × 26 × 28');
  await page.click('#copy-command');
  assert.match(await page.inputValue('#copied-text'), / --domain=\S+ --padding-cells=1,2,3 --cell-size=0.5/);
});

/** Before the page's scripts: a disk with room for 10 GB, and a machine with enough memory. */
function smallDisk() {
  navigator.storage.estimate = async () => ({ quota: 11e9, usage: 1e9 });
  Object.defineProperty(navigator, 'deviceMemory', { value: 8 });
}

test('what will not fit is said before it is tried', async ({ visit }) => {
  const page = await visit('#sample=knot', { prepare: smallDisk });
  await hasGeometries(page, 1);
  /** Asks for so many cells, and waits until the page says this of it. */
  const says = async (cells, sentence) => {
    await page.fill('#cells', String(cells));
    const isSaid = (text) =>
      new RegExp(text).test([...document.querySelectorAll('#estimate .warn')].map((element) => element.textContent).join());
    await page.waitForFunction(isSaid, sentence.source, { timeout: 20_000 }).catch(() => {});
    assert.match((await page.locator('#estimate .warn').allTextContents()).join(), sentence);
  };
  await says(1000, /^$/);
  await says(12_000, /^This needs about \d+ MB; the tab may run out of memory\./);
  await says(30_000, /^A page cannot hold [\d.]+ GB in memory: the mesh is stored in the browser's private files/);
  await says(
    50_000,
    /^This will not fit: it needs about [\d.]+ GB, and a page can hold 2\.80 GB in memory or 10\.0 GB on disk\. Take larger cells/,
  );
  await says(300_000, /^\d+ cells along \w: at most 262142 fit\. /);
  await says(1e11, /^4\d{9} cells along \w: at most 262142 fit\. /);
  assert.ok(await page.isDisabled('#run'));
  await says(64, /^$/);
  await page.waitForSelector('#run:enabled');
});

// Files of CAD: converted where they are dropped, with names, colours and the unit, and again for much smaller cells.

import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import path from 'node:path';

import { ROOT } from '../../scripts/run.mjs';
import { PALETTE } from '../../www/page/state/palette.js';
import { hasGeometries, isIdle, run, test } from './visit.mjs';

const MACHINE = path.join(ROOT, 'tests/fixtures/machine.step');
/** A real assembly: one of the tests of occt-import-js. */
const AS1 = path.join(ROOT, 'node_modules/occt-import-js/test/testfiles/cax-if/as1-oc-214.stp');

/** Drops a file onto the page. */
async function drop(page, name, base64) {
  await page.evaluate(
    ([name, base64]) => {
      const dataTransfer = new DataTransfer();
      dataTransfer.items.add(new File([Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0))], name));
      document.body.dispatchEvent(new DragEvent('drop', { dataTransfer, bubbles: true, cancelable: true }));
    },
    [name, base64],
  );
}

/** Files of Open CASCADE that a page loads. */
function loadedOf(page) {
  const loaded = [];
  page.on('request', (request) => /occt/.test(request.url()) && loaded.push(path.basename(request.url())));
  return loaded;
}

const triangles = (page) => page.getByText(/at most [\d.]+ mm from the surface/).textContent();

test('a dropped STEP file has its bodies as parts, with names, colours and the unit', async ({ visit }) => {
  const page = await visit('#cells=64');
  const loaded = loadedOf(page);
  await drop(page, 'machine.step', readFileSync(MACHINE).toString('base64'));
  await hasGeometries(page, 1);
  assert.deepEqual(loaded.map((name) => path.extname(name)).sort(), ['.js', '.wasm']);
  assert.equal(await page.getByLabel('Unit').inputValue(), 'mm');
  assert.match(await page.getByText(/from the surface/).textContent(), /^of 6 bodies, at most 0\.103\d* mm from the surface$/);
  assert.ok(await page.getByLabel(/Each of the 6 solids is a geometry/).isChecked());
  await run(page);
  const report = JSON.parse(await page.textContent('#report'));
  const names = ['machine/block rounded', 'machine/tube', 'machine/pair/ball', 'machine/pair/ring'];
  assert.deepEqual(
    report.flags.map(({ flag, name }) => [flag, name]),
    [...names, 'machine/pair/ball 2', 'machine/pair/ring 2'].map((name, at) => [at + 1, name]),
  );
  assert.ok(report.flags.every(({ cells }) => cells > 100));
  assert.equal(report.unit, 'mm');
  const parts = page.getByRole('list', { name: 'Geometries' });
  assert.equal(
    await parts.getByLabel('Colour of machine', { exact: true }).inputValue(),
    PALETTE[0],
    'the first body has none of its own',
  );
  // those of the file are in the link, and in the rows of what the cells are
  const colours = await page
    .locator('#legend .swatch')
    .evaluateAll((swatches) => swatches.map((one) => getComputedStyle(one).backgroundColor));
  assert.deepEqual(colours.slice(1, 4), ['rgb(0, 102, 204)', 'rgb(255, 0, 0)', 'rgb(0, 153, 0)']);
});

test('conversion is cancelled within half a second, and the page goes on', async ({ visit }) => {
  const page = await visit('#cells=64');
  // so fine that it takes long
  await page.getByRole('textbox', { name: 'Cell size' }).fill('0.0001');
  await page.getByLabel('Files of surfaces', { exact: true }).setInputFiles(AS1);
  const cancel = page.getByRole('button', { name: 'Cancel: Converting as1-oc-214.stp' });
  await cancel.waitFor();
  const since = Date.now();
  await cancel.click();
  await page.getByText('Cancelled; as1-oc-214.stp was not read.').waitFor();
  assert.ok(Date.now() - since < 500, `${Date.now() - since} ms`);
  await isIdle(page);
  await page.getByRole('textbox', { name: 'Cell size' }).fill('2');
  await page.getByLabel('Files of surfaces', { exact: true }).setInputFiles(MACHINE);
  await hasGeometries(page, 1);
  await run(page);
});

test('cells that are more than twice as small or large have the file converted again, others do not', async ({ visit }) => {
  const page = await visit('#cells=64');
  await page.getByLabel('Files of surfaces', { exact: true }).setInputFiles(MACHINE);
  await hasGeometries(page, 1);
  const first = await triangles(page);
  const cells = page.getByLabel('Cells along the longest axis');
  await cells.fill('120');
  await page.waitForTimeout(2500);
  assert.equal(await triangles(page), first);
  await cells.fill('200');
  const fine = page.getByText(/at most 0\.0329\d* mm from the surface/);
  await fine.waitFor({ timeout: 60_000 });
  await isIdle(page);
  const report = async () => {
    await run(page);
    return JSON.parse(await page.textContent('#report'));
  };
  const ball = (4 / 3) * Math.PI * 125;
  const off = (await report()).flags.map(({ mesh_volume }) => mesh_volume)[2] - ball;
  assert.ok(Math.abs(off) < 4 * Math.PI * 25 * 0.033, `${off}`);
  await cells.fill('32');
  await page.getByText(/at most 0\.20\d* mm from the surface/).waitFor({ timeout: 60_000 });
  assert.ok(await page.getByRole('button', { name: 'Undo' }).isEnabled(), 'the settings were edited');
});

test('a file over 100 MB is said before it is tried, and what is no STEP says so', async ({ visit }) => {
  const page = await visit('#cells=64');
  await page.evaluate(() => {
    const dataTransfer = new DataTransfer();
    dataTransfer.items.add(new File([new Uint8Array(101e6)], 'ship.step'));
    document.body.dispatchEvent(new DragEvent('drop', { dataTransfer, bubbles: true, cancelable: true }));
  });
  await page.getByText(/ship\.step has 101 MB: above 100 MB the 2 GiB/).waitFor();
  await page
    .getByRole('alert')
    .getByText(/ship\.step is neither STEP nor IGES by its first line/)
    .waitFor();
});

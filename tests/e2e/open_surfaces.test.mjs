// Surfaces that are not closed: how their cells are decided is a choice, and what was found of them is shown with its place.

import assert from 'node:assert/strict';
import { mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';

import { runCopied } from './native.mjs';
import { OPEN_BOX } from './open_box.mjs';
import { cellsAreDrawn, hasGeometries, legend, picture3d, run, slice, test } from './visit.mjs';

/** Drops the box onto the page. */
async function dropBox(page) {
  await page.evaluate((text) => {
    const dataTransfer = new DataTransfer();
    dataTransfer.items.add(new File([text], 'box.stl'));
    document.body.dispatchEvent(new DragEvent('drop', { dataTransfer, bubbles: true, cancelable: true }));
  }, OPEN_BOX);
  await hasGeometries(page, 1);
}

/** The report on the page. */
async function report(page) {
  return JSON.parse(await page.textContent('#report'));
}

/** Where the ring is in the saved picture: the mean of its pixels, as shares of width and height; null where there is none. */
async function ringAt(page) {
  return page.evaluate(
    ({ data, width, height }) => {
      const sum = [0, 0, 0];
      for (let at = 0; at < data.length; at += 4) {
        if (![0xe0, 0x10, 0x3c].every((part, channel) => Math.abs(data[at + channel] - part) <= 2)) continue;
        sum[0] += (at / 4) % width;
        sum[1] += Math.floor(at / 4 / width);
        sum[2] += 1;
      }
      return sum[2] > 0 ? [sum[0] / sum[2] / width, sum[1] / sum[2] / height] : null;
    },
    await picture3d(page),
  );
}

test('an open surface is a finding, and its button shows the longest open edge', async ({ visit }) => {
  const page = await visit('#cells=20&backend=gpu');
  await dropBox(page);
  assert.match(await page.textContent('.geometry .facts'), /not closed: 4 open edges/);
  await run(page);
  // the box is whole
  assert.deepEqual(await legend(page), [[1, 2000]]);
  const [open] = (await report(page)).open;
  assert.deepEqual([open.policy, open.open_edges, open.holes, open.doubtful_cells], ['winding', 4, 1, 2000]);
  const { findings } = await report(page);
  assert.deepEqual(
    findings.map(({ code, geometry, points, values }) => [code, geometry.name, points, values.open_edges, values.doubtful_cells]),
    [['surface-open', 'box', [open.longest_at], 4, 2000]],
  );
  const [text, ...others] = await page.locator('#finding-list li p').allTextContents();
  assert.deepEqual(others, []);
  assert.match(
    text,
    /^Geometry "box" is not closed: open edges 4, loops 1, .*2000 of 2000 cells were doubtful .* by the winding number\.$/,
  );
  assert.doesNotMatch(await page.textContent('#legend'), /vs facets/, 'the volume of its facets depends on the origin');
  await cellsAreDrawn(page);
  assert.equal(await ringAt(page), null);
  // from the slices, with the keyboard
  await slice(page, 'z', 4);
  await page.getByRole('button', { name: 'Show the place: box, problem 1' }).press('Enter');
  await page.waitForSelector('#pane-3d:visible #canvas-3d[data-place]');
  assert.equal(await page.getAttribute('#canvas-3d', 'data-place'), open.longest_at.join(' '));
  assert.ok(await page.isChecked('#show-model'), 'the cells close the hole');
  const [x, y] = await ringAt(page);
  assert.ok(Math.abs(x - 0.5) < 0.01 && Math.abs(y - 0.5) < 0.01, `the ring is at ${x}, ${y}`);
  // another mesh has other findings
  await page.selectOption('#unit', 'mm');
  await run(page);
  await cellsAreDrawn(page);
  assert.equal(await ringAt(page), null);
});

test('the choice for open surfaces is in the job, the command, the program and the link', async ({ visit }) => {
  const folder = mkdtempSync(path.join(tmpdir(), 'hexcast-'));
  try {
    const page = await visit('#cells=20&backend=cpu');
    await dropBox(page);
    const copied = async (what) => {
      await page.click(`#copy-${what}`);
      return page.inputValue('#copied-text');
    };
    assert.doesNotMatch(await copied('command'), /--open/);
    assert.doesNotMatch(await copied('link'), /open=/);
    await page.click('#settings summary');
    await page.getByLabel('Open surfaces').selectOption('vote of three axes');
    assert.match(await copied('command'), / --open=vote /);
    assert.match(await copied('js'), /^ {4}open: "vote",$/m);
    await run(page);
    assert.equal((await report(page)).open[0].policy, 'vote');
    assert.match(await page.textContent('#finding-list p'), /doubtful and were decided by most of their even rays\.$/);
    writeFileSync(path.join(folder, 'box.stl'), OPEN_BOX);
    const native = await runCopied(page, folder, []);
    assert.deepEqual((await report(page)).open, native.open);
    // the choice makes the mesh one of other settings
    await page.selectOption('#open', 'parity');
    await page.selectOption('#axis', 'z');
    assert.ok(await page.isVisible('#stale'));
    await run(page);
    assert.equal(
      await page.locator('#finding-list [data-kind=surface-open]').count(),
      0,
      'rays of one axis do not look for holes',
    );
    assert.match(await page.textContent('#finding-list'), /200 of 200 rays do not leave every geometry they enter/);
    // cells along surfaces are a choice, too
    assert.doesNotMatch(await copied('command'), /--fill/);
    await page.getByLabel('Cells along surfaces').selectOption('keep thin walls');
    assert.match(await copied('link'), /[#&]fill=separating(&|$)/);
    await page.selectOption('#open', 'winding');
    await run(page);
    const [filled] = (await report(page)).filled;
    assert.deepEqual([filled.fill, filled.shell], ['separating', false]);
    assert.deepEqual((await runCopied(page, folder, [])).filled, [filled]);
    await page.selectOption('#fill', 'centre');
    // an error says what to do
    await page.selectOption('#open', 'error');
    const link = await copied('link');
    await page.click('#run');
    await page.waitForSelector('#messages [data-code=surface-open]');
    await page.getByRole('button', { name: 'Use the winding number' }).click();
    assert.equal(await page.inputValue('#open'), 'winding');
    await run(page);
    assert.deepEqual(await legend(page), [[1, 2000]]);
    assert.match(link, /[#&]open=error(&|$)/);
    const other = await visit(new URL(link).hash);
    assert.equal(await other.inputValue('#open'), 'error');
  } finally {
    rmSync(folder, { recursive: true });
  }
});

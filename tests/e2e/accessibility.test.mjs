// For everybody: axe-core finds nothing on the page in any of its states, and all of it is reached with the keyboard.

import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { createRequire } from 'node:module';

import { expect } from '@playwright/test';

import { OPEN_BOX } from './open_box.mjs';
import { COPPER, hasGeometries, isIdle, keptFiles, run, saved, slice, take, test, withoutOffscreen } from './visit.mjs';
import { WITHOUT_ADAPTER } from './workers.mjs';

const AXE = readFileSync(createRequire(import.meta.url).resolve('axe-core/axe.min.js'), 'utf8');
/** The rules of WCAG 2.2 up to AA, and what else axe-core holds to be good practice. */
const RULES = ['wcag2a', 'wcag2aa', 'wcag21a', 'wcag21aa', 'wcag22aa', 'best-practice'];
const PHONE = { width: 390, height: 844 };

/** Fails where axe-core finds anything in what is shown now: in the light, its colours in the dark, and on a phone. */
async function isSound(page, what) {
  const screen = page.viewportSize();
  const looks = {
    light: { colorScheme: 'light', rules: RULES },
    dark: { colorScheme: 'dark', rules: ['color-contrast'] },
    phone: { size: PHONE, rules: RULES },
  };
  for (const [look, { colorScheme = 'light', size = screen, rules }] of Object.entries(looks)) {
    // colours change at once where motion is not wanted
    await page.emulateMedia({ colorScheme, reducedMotion: 'reduce' });
    await page.setViewportSize(size);
    const found = await page.evaluate(async (rules) => {
      const { violations, passes } = await globalThis.axe.run({ runOnly: rules });
      return {
        n_passed: passes.length,
        violations: violations.map(({ id, nodes }) => `${id}: ${nodes.map(({ target }) => target.join(' ')).join(', ')}`),
      };
    }, rules);
    assert.deepEqual(found.violations, [], `${what}, ${look}`);
    assert.ok(found.n_passed >= (rules === RULES ? 20 : 1), `${what}, ${look}: ${found.n_passed} rules applied`);
    assert.equal(
      await page.evaluate(() => document.documentElement.scrollWidth - innerWidth),
      0,
      `${what}, ${look}: nothing lies beside the screen`,
    );
  }
  await page.setViewportSize(screen);
}

test('axe-core finds nothing: empty, models and mistakes, a mesh and its slices', async ({ visit }) => {
  const page = await visit('#cells=20&backend=gpu');
  await page.evaluate(AXE);
  await isSound(page, 'empty');
  const files = ['ascii_two_solids_mixed_case', 'featuretype', 'bin_count_too_big'].map((file) => `tests/fixtures/${file}.stl`);
  await page.setInputFiles('#file-input', files);
  await page.waitForSelector('#messages [role=alert]');
  await hasGeometries(page, 2);
  for (const summary of await page.$$('.side summary:visible')) await summary.click();
  await page.setInputFiles('#file-input', { name: 'box.stl', mimeType: 'model/stl', buffer: Buffer.from(OPEN_BOX) });
  await hasGeometries(page, 3);
  await page.fill('#padding', '-1');
  await isSound(page, 'models and mistakes');
  await page.fill('#padding', '1');
  await page.check('#certify');
  await page.waitForSelector('#run:enabled');
  await run(page);
  for (const summary of await page.$$('#results summary')) await summary.click();
  await page.selectOption('#section-axis', '0');
  await page.getByRole('combobox', { name: 'For which program?' }).selectOption('openEMS');
  await page
    .getByRole('combobox', { name: /^What .* is made of$/ })
    .first()
    .selectOption({ label: 'other …' });
  assert.equal(await page.locator('#finding-list [data-kind=surface-open] button').count(), 1);
  await page.click('#finding-next');
  await isSound(page, 'a mesh');
  await page.fill('#cells', '21');
  await slice(page, 'x', 4);
  await isSound(page, 'slices, of other settings');
});

test('axe-core finds nothing: four panes, a cell that is inspected, and what is measured', async ({ visit }) => {
  const page = await visit('#cells=20&backend=cpu&sample=cubes&panes=four');
  await hasGeometries(page, 2);
  await page.evaluate(AXE);
  await run(page);
  await page.waitForSelector('#canvas-z[data-index]');
  await page.focus('#canvas-z');
  await page.keyboard.press('Enter');
  await page.click('#claims-find');
  await page.waitForSelector('#claims:visible');
  await page.click('#measure');
  await page.focus('#canvas-z');
  await page.keyboard.press('Enter');
  await page.keyboard.press('Shift+ArrowLeft');
  await page.keyboard.press('Enter');
  await page.waitForSelector('#measured:visible');
  await page.selectOption('#stretch', '2 4');
  await isSound(page, 'four panes');
});

test('axe-core finds nothing: help, the question about the last visit, an error of a file', async ({ visit }) => {
  const page = await visit('#cells=20&backend=cpu');
  await page.evaluate(AXE);
  await page.click('#help-open');
  await isSound(page, 'help');
  await page.keyboard.press('Escape');
  await page.setInputFiles('#file-input', { name: 'box.stl', mimeType: 'model/stl', buffer: Buffer.from(OPEN_BOX) });
  await hasGeometries(page, 1);
  await expect.poll(() => keptFiles(page)).toEqual(['box.stl']);
  await page.reload();
  await isIdle(page);
  await page.waitForSelector('#messages [data-about=session]');
  await page.evaluate(AXE);
  await isSound(page, 'the question about the last visit');
  await page.setInputFiles('#file-input', { name: 'letter.stl', mimeType: 'model/stl', buffer: Buffer.from('Dear Sir') });
  await page.waitForSelector('#messages [role=alert]');
  await isSound(page, 'an error of a file');
});

test('axe-core finds nothing: a comparison with a mesh file, which is reached with the keyboard', async ({ visit }) => {
  const page = await visit('#cells=20&backend=cpu&sample=cubes');
  await hasGeometries(page, 2);
  await page.evaluate(AXE);
  await run(page);
  const { bytes } = await saved(page, '#download-hxc');
  await page.evaluate(() => (document.querySelector('#settings details').open = true));
  await page.selectOption('#fill', 'conservative');
  await page.waitForSelector('#run:enabled');
  await run(page);
  // the mesh gives the focus back to the button that began it
  await page.waitForFunction(() => document.activeElement.id === 'run');
  // asked for in time: the browser may take a while until it hands the question for a file over
  const asked = page.waitForEvent('filechooser');
  await page.focus('#compare summary');
  await page.keyboard.press('Enter');
  await page.keyboard.press('Tab');
  await page.waitForFunction(() => document.activeElement.id === 'compare-choose');
  await page.keyboard.press('Enter');
  const chooser = await asked;
  await chooser.setFiles({ name: 'before.hxc', mimeType: '', buffer: bytes });
  await page.waitForSelector('#compare-pairs tr');
  assert.equal(await page.evaluate(() => document.activeElement.id), 'compare-choose', 'the focus is where it was');
  await isSound(page, 'a comparison');
  await page.keyboard.press('Tab');
  await page.keyboard.press('Enter');
  await expect(page.locator('#readout')).toContainText('cell ');
  await isSound(page, 'a cell that differs');
});

test('axe-core finds nothing: no WebGL, no GPU', async ({ visit, siteWithWorker }) => {
  const page = await visit('#cells=20&backend=cpu', { prepare: withoutOffscreen });
  await page.evaluate(AXE);
  await take(page, 'cubes', 2);
  await page.waitForSelector('#no-3d:visible');
  await isSound(page, 'no WebGL');
  const other = await visit('#cells=20&backend=cpu', { url: await siteWithWorker(WITHOUT_ADAPTER) });
  await other.evaluate(AXE);
  await other.evaluate(() => (document.querySelector('#settings details').open = true));
  await other.selectOption('#backend', 'gpu');
  await other.waitForSelector('#messages [data-code=no-adapter]');
  await isSound(other, 'no GPU');
});

/** In the worker: slices of large files never come. */
const STANDSTILL = `
  const read = Blob.prototype.arrayBuffer;
  Blob.prototype.arrayBuffer = function () {
    return this.size < 4000000 ? read.call(this) : new Promise(() => {});
  };
`;

test('axe-core finds nothing while a file is read and while a mesh is made', async ({ visit, siteWithWorker }) => {
  const page = await visit('#cells=9000&backend=cpu', { url: await siteWithWorker(STANDSTILL) });
  await page.evaluate(AXE);
  await page.setInputFiles('#file-input', { name: 'large.stl', mimeType: 'model/stl', buffer: Buffer.alloc(9e6) });
  await page.waitForSelector('#tasks progress');
  await isSound(page, 'a file is read');
  await page.getByRole('button', { name: 'Cancel: Reading large.stl' }).click();
  await isIdle(page);
  await take(page, 'knot', 1);
  await page.click('#run');
  await page.waitForFunction(() => document.querySelector('#progress').value > 0);
  await isSound(page, 'a mesh is made');
  await page.click('#cancel');
  await isIdle(page);
});

test('from the sample to a file with the keyboard alone, and nothing that has the focus is covered', async ({ visit }) => {
  const page = await visit('#cells=20&backend=gpu');
  const isAt = () =>
    page.evaluate(() => document.activeElement.id || document.activeElement.dataset.sample || document.activeElement.className);
  /** Presses Tab until an element has the focus; whatever gets it on the way can be seen. */
  const tabTo = async (wanted) => {
    for (let presses = 0; presses < 80; presses += 1) {
      await page.keyboard.press('Tab');
      const { at, isSeen } = await page.evaluate(focused);
      assert.ok(isSeen, `${at} is covered`);
      if (at === wanted) return;
    }
    assert.fail(`${wanted} is not reached`);
  };
  await page.keyboard.press('Tab');
  await page.keyboard.press('Enter');
  assert.equal(await isAt(), 'view', 'the first link leads to the view');
  await tabTo('cubes');
  await page.keyboard.press('Enter');
  await hasGeometries(page, 2);
  await tabTo('cell-size');
  await page.keyboard.type('1');
  await tabTo('run');
  await page.keyboard.press('Enter');
  await page.waitForSelector('#legend tr', { timeout: 180_000 });
  assert.equal(await isAt(), 'run', 'the focus is where it was');
  await tabTo('panes-3d');
  await page.keyboard.press('ArrowRight');
  await tabTo('plane-z');
  await page.keyboard.press('ControlOrMeta+a');
  await page.keyboard.type('7.4');
  await tabTo('canvas-z');
  assert.equal(await page.inputValue('#plane-z'), '7');
  await page.keyboard.press('x');
  await page.keyboard.press('Home');
  assert.equal((await slice(page, 'x', 0))[0][0], COPPER);
  const [download] = await Promise.all([
    page.waitForEvent('download'),
    tabTo('download-npy').then(() => page.keyboard.press('Enter')),
  ]);
  assert.equal(download.suggestedFilename(), 'copper.npy');
});

/** In the page: the element that has the focus, and whether it, or the label that stands for it, is what is seen in its place. */
function focused() {
  const element = document.activeElement;
  const { left, top, width, height } = element.getBoundingClientRect();
  const seen = document.elementFromPoint(left + width / 2, top + height / 2);
  const isSeen = element === document.body || element.contains(seen) || Boolean(element.closest('label')?.contains(seen));
  return { at: element.id || element.dataset.sample || element.className || element.tagName, isSeen };
}

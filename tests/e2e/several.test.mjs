// Several parts edited at once: selected with the mouse and with the keys, changed together, and undone in one step.

import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { createRequire } from 'node:module';

import { expect } from '@playwright/test';

import { boxBetween } from './open_box.mjs';
import { hasGeometries, legend, run, test } from './visit.mjs';

const AXE = readFileSync(createRequire(import.meta.url).resolve('axe-core/axe.min.js'), 'utf8');
const NAMES = ['a', 'b', 'c', 'd'];
const SAID = (n) => `${n} parts are selected: what is set for one is set for all.`;

async function four(visit) {
  const page = await visit('#cell_size=1&backend=cpu');
  const files = NAMES.map((name, at) => ({
    name: `${name}.stl`,
    mimeType: 'model/stl',
    buffer: Buffer.from(boxBetween([3 * at, 0, 0], [3 * at + 2, 2, 2])),
  }));
  await page.setInputFiles('#file-input', files);
  await hasGeometries(page, 4);
  return page;
}

const handle = (page, name) => page.getByRole('button', { name: `Select ${name}:` });
const pressed = (page) => page.getByRole('button', { name: /^Select .:/, pressed: true }).count();
const group = (page) => page.getByRole('group', { name: 'Selected parts' });

/** Opens the details of all parts. */
async function open(page) {
  for (const name of NAMES) {
    const opener = page.getByRole('button', { name: `Details of ${name}` });
    if ((await opener.getAttribute('aria-expanded')) === 'false') await opener.click();
  }
}

const valuesOf = (page, label) =>
  Promise.all(NAMES.map((name) => page.getByLabel(`${label} of ${name}`, { exact: true }).inputValue()));

test('flag, priority, material and fill of all selected parts change at once, and one step undoes each', async ({ visit }) => {
  const page = await four(visit);
  await open(page);
  await handle(page, 'b').click();
  assert.equal(await pressed(page), 1);
  assert.ok(await group(page).isHidden(), 'one part is edited as ever');
  await page.getByLabel('Name of d.stl').click({ modifiers: ['Shift'] });
  await expect(page.getByRole('status').filter({ hasText: SAID(3) })).toHaveCount(1);
  await page.getByLabel('Name of c.stl').click({ modifiers: ['ControlOrMeta'] });
  assert.equal(
    await group(page)
      .textContent()
      .then((text) => text.includes(SAID(2))),
    true,
  );

  const priority = page.getByLabel('Priority of b', { exact: true });
  await priority.fill('7');
  assert.ok(await priority.evaluate((field) => field === document.activeElement), 'who types goes on typing');
  assert.deepEqual(await valuesOf(page, 'Priority'), ['0', '7', '0', '7']);
  await handle(page, 'b').focus();
  await page.keyboard.press('ControlOrMeta+z');
  await expect.poll(() => valuesOf(page, 'Priority')).toEqual(['0', '0', '0', '0']);
  assert.equal(await pressed(page), 2, 'the parts stay selected');

  await open(page);
  await page.getByLabel('Flag of d', { exact: true }).fill('9');
  assert.deepEqual(await valuesOf(page, 'Flag'), ['1', '9', '3', '9']);
  await page.getByLabel('Cells of b', { exact: true }).selectOption('conservative');
  assert.deepEqual(await valuesOf(page, 'Cells'), ['', 'conservative', '', 'conservative']);
  await page.getByLabel('Material of b', { exact: true }).evaluate((field) => {
    field.closest('details').open = true;
  });
  await page.getByLabel('Material of b', { exact: true }).fill('eps_r=2.2');
  assert.equal(await page.getByLabel('Material of d', { exact: true }).inputValue(), 'eps_r=2.2');
  assert.equal(await page.getByLabel('Material of c', { exact: true }).inputValue(), '');
  // a name is of one
  await page.getByLabel('Name of b.stl').fill('bee');
  assert.equal(await page.getByLabel('Name of d.stl').inputValue(), 'd');
});

test('rows are selected with the keys, and said; a hidden part comes back with one step', async ({ visit }) => {
  const page = await four(visit);
  await run(page);
  const cells = await legend(page);
  assert.equal(cells.length, 4);
  await handle(page, 'a').focus();
  await page.keyboard.press('ArrowDown');
  assert.equal(await pressed(page), 0, 'an arrow key alone goes to the next row');
  await page.keyboard.press('Shift+ArrowDown');
  await page.keyboard.press('Shift+ArrowDown');
  assert.equal(await pressed(page), 3);
  await page.keyboard.press('Shift+ArrowUp');
  assert.equal(await pressed(page), 2);
  await page.evaluate(AXE);
  const { violations } = await page.evaluate(() =>
    globalThis.axe.run({ runOnly: ['wcag2a', 'wcag2aa', 'wcag22aa', 'best-practice'] }),
  );
  assert.deepEqual(
    violations.map(({ id }) => id),
    [],
  );
  const shown = () => page.getByRole('checkbox', { name: /^Show flag/, checked: true }).count();
  await group(page).getByRole('button', { name: 'Hide' }).click();
  assert.equal(await shown(), 2);
  await page.keyboard.press('ControlOrMeta+z');
  await expect.poll(shown).toBe(4);
  await handle(page, 'b').focus();
  await page.keyboard.press('ControlOrMeta+a');
  await expect(page.getByRole('status').filter({ hasText: SAID(4) })).toHaveCount(1);
  await page.keyboard.press('Escape');
  assert.equal(await pressed(page), 0);
  assert.ok(await group(page).isHidden());
});

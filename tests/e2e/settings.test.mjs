// The fields: links restore them, copies spell them out, and what cannot be is said before it is tried.

import assert from 'node:assert/strict';
import { test } from 'node:test';

import { LIMIT, hasGeometries, take, useSite, withPage } from './visit.mjs';

useSite();

test('a link restores the parameters and never holds the geometry', LIMIT, () =>
  withPage('', async (page) => {
    await take(page, 'cubes', 2);
    await page.fill('#cell-size', '0.5');
    await page.click('#settings summary');
    await page.fill('#padding', '1 2 3');
    await page.selectOption('#rule', 'nonzero');
    await page.selectOption('#axis', 'x');
    await page.selectOption('#unit', 'mm');
    await page.fill('.geometry[data-file="copper.stl"] .priority', '3');
    await page.fill('.geometry[data-file="epoxy.stl"] .name', 'FR4 board');
    await page.click('.geometry[data-file="epoxy.stl"] summary');
    await page.fill('.geometry[data-file="epoxy.stl"] .rotate', '0 0 90');
    await page.click('#copy-command');
    const command = await page.inputValue('#copied-text');
    assert.equal(
      command,
      "hexcast mesh copper.stl:name=copper,flag=1,priority=3 'epoxy.stl:name=FR4 board,flag=2,rotate=0/0/90' --padding-cells=1,2,3 --cell-size=0.5 --rule=nonzero --axis=x --unit=mm -o copper.vti",
    );
    await page.click('#copy-link');
    const link = await page.inputValue('#copied-text');
    assert.ok(link.length < 600, `${link.length} characters`);
    await withPage(new URL(link).hash, async (other) => {
      await hasGeometries(other, 2);
      await other.click('#copy-command');
      assert.equal(await other.inputValue('#copied-text'), command);
    });
  }),
);

test('what cannot be meshed is said before it is tried', LIMIT, () =>
  withPage('#sample=knot', async (page) => {
    await hasGeometries(page, 1);
    await page.fill('#cells', '60000');
    await page.waitForSelector('#estimate-warning, #estimate-error');
    await page.fill('#cells', '64');
    await page.waitForFunction(() => !document.querySelector('#estimate-warning, #estimate-error'));
  }),
);

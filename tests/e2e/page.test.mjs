// The page opens in both browsers, from the root and from below a path, without a complaint.

import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import path from 'node:path';

import { test } from '@playwright/test';

import { ROOT } from '../../scripts/run.mjs';
import { serve } from '../../scripts/serve.mjs';
import { complaintsOf, openChromium, openFirefox } from './browsers.mjs';

const { version } = JSON.parse(readFileSync(path.join(ROOT, 'package.json'), 'utf8'));
const SHOWN = "document.querySelector('#version').value !== ''";
const ADAPTER =
  "navigator.gpu.requestAdapter().then((a) => a && [a.info.vendor, a.info.architecture, a.info.description].join(' ').trim())";
const BASES = ['/', '/some/where/'];

let servers;
test.beforeAll(async () => {
  servers = await Promise.all(BASES.map((base) => serve({ base })));
});
test.afterAll(() => Promise.all(servers.map((server) => server.close())));

for (const [name, open] of [
  ['Chromium', openChromium],
  ['Firefox', openFirefox],
]) {
  test(`${name} shows the version and complains about nothing`, async () => {
    const browser = await open();
    try {
      for (const { url } of servers) {
        const page = await browser.newPage();
        const complaints = complaintsOf(page, url);
        await page.goto(url);
        await page.waitForFunction(SHOWN);
        assert.equal(await page.evaluate("document.querySelector('#version').value"), version);
        assert.deepEqual(complaints, [], url);
      }
    } finally {
      await browser.close();
    }
  });

  test(`${name} has a WebGPU adapter`, async () => {
    const browser = await open();
    try {
      const page = await browser.newPage();
      await page.goto(servers[0].url);
      const adapter = await page.evaluate(ADAPTER);
      assert.notEqual(adapter, null);
      console.log(`adapter: ${adapter || 'unnamed'} (${name})`);
    } finally {
      await browser.close();
    }
  });
}

test('a complaint is heard', async () => {
  const browser = await openChromium();
  try {
    const page = await browser.newPage();
    const complaints = complaintsOf(page, servers[0].url);
    await page.goto(servers[0].url);
    await page.evaluate(
      "console.error('one'); setTimeout(() => { throw new Error('two') }); fetch('missing').then(() => { window.isDone = true })",
    );
    await page.waitForFunction('window.isDone');
    assert.ok(complaints.includes('console: one'), complaints.join('\n'));
    assert.ok(complaints.includes('uncaught: two'), complaints.join('\n'));
    assert.ok(
      complaints.some((complaint) => complaint.startsWith('status 404')),
      complaints.join('\n'),
    );
  } finally {
    await browser.close();
  }
});

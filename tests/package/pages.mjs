// The page of `app/` in the two browsers, and what must have come out.

import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import path from 'node:path';

import { ROOT } from '../../scripts/run.mjs';
import { complaintsOf, openChromium, openFirefox } from '../e2e/browsers.mjs';

const { version } = JSON.parse(readFileSync(path.join(ROOT, 'package.json'), 'utf8'));
const PATIENCE = { timeout: 120_000 };

/** How to open each browser; what is used of a page's interface is the same in both. */
export const BROWSERS = { Chromium: openChromium, Firefox: openFirefox };

/**
 * Opens the page, once for the GPU and once for the CPU, and holds the mesh to the native command's.
 *
 * @param {object} browser
 * @param {string} url of the page, without parameters
 * @param {object} native the native command's report, and `vti`, the hash of its compressed file, `cells`, those with a flag and all that the documents mesh
 * @param {string[]} [others] origins that the page may ask too; none
 * @param {string[]} [backends] both
 * @param {number} [threads] one
 */
export async function assertMeshes(browser, url, native, others = [], backends = ['gpu', 'cpu'], threads = 1) {
  for (const backend of backends) {
    const page = await browser.newPage();
    const complaints = complaintsOf(page, url);
    await page.goto(`${url}?backend=${backend}&threads=${threads}`);
    // options are the second argument of Puppeteer's and the third of Playwright's
    const outcome = await (await page.waitForFunction(() => globalThis.outcome, PATIENCE, PATIENCE)).jsonValue();
    assert.equal(outcome.failed, undefined, complaints.join('\n'));
    const hashes = { sha256: native.flags_sha256, again: native.flags_sha256, vti: native.vti };
    const expected = {
      version,
      backend,
      threads,
      dims: native.dims,
      flags: native.flags,
      ...hashes,
      code: 'job-conflict',
      cells: native.cells,
    };
    assert.deepEqual(outcome, expected);
    const isAllowed = (line) => others.some((origin) => line.startsWith(`another origin: ${origin}/`));
    assert.deepEqual(
      complaints.filter((line) => !isAllowed(line)),
      [],
    );
    for (const origin of others)
      assert.ok(
        complaints.some((line) => line.startsWith(`another origin: ${origin}/`)),
        `${origin} was asked`,
      );
    await page.close();
  }
}

/** Opens a browser, runs a check with it and ends the browser and the server. */
export async function withBrowser(open, server, check) {
  let browser;
  try {
    browser = await open();
    await check(browser);
  } finally {
    await browser?.close();
    await server.close();
  }
}

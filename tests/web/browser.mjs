// The tests of this folder in a browser: the runner that wasm-bindgen brings serves them as a page, which we open.

import { spawn } from 'node:child_process';
import { setTimeout as pause } from 'node:timers/promises';

import { CommandFailed } from '../../scripts/run.mjs';

const SECONDS = 900;
/** The last line of the page, as of any Rust test. */
const DONE = /test result: (\w+)\. /;

/**
 * Runs the tests of a wasm file in a browser.
 *
 * @param {() => Promise<object>} open starts the browser, by Playwright or Puppeteer: what is used of either is the same
 * @param {string} runner path of wasm-bindgen-test-runner
 * @param {string} wasm path of the tests
 * @returns {Promise<string>} what the page says; rejects with CommandFailed where a test failed
 */
export async function testInBrowser(open, runner, wasm) {
  const env = { ...process.env, NO_HEADLESS: '1', WASM_BINDGEN_TEST_ADDRESS: '127.0.0.1:0' };
  const child = spawn(runner, [wasm, '--nocapture'], { env, stdio: ['ignore', 'pipe', 'inherit'] });
  let browser;
  try {
    const url = await addressOf(child);
    browser = await open();
    const page = await browser.newPage();
    await page.goto(url);
    return await resultOf(page, `${open.name}, ${wasm}`);
  } finally {
    await browser?.close();
    child.kill();
  }
}

/** What the page says once it is done. Asks now and again: one long question would exceed Puppeteer's timeout. */
async function resultOf(page, command) {
  const end = Date.now() + SECONDS * 1000;
  for (;;) {
    const output = await page.$eval('body', (body) => body.textContent);
    const result = DONE.exec(output)?.[1];
    if (result === 'ok') return output;
    if (result) throw new CommandFailed(command, 'a test failed', output);
    if (Date.now() > end) throw new CommandFailed(command, `not done after ${SECONDS} seconds`, output);
    await pause(500);
  }
}

/** Where the runner says it serves the page. */
function addressOf(child) {
  return new Promise((resolve, reject) => {
    let output = '';
    child.stdout.on('data', (chunk) => {
      output += chunk;
      const url = /http:\/\/[\d.]+:\d+/.exec(output)?.[0];
      if (url) resolve(url);
    });
    child.once('error', reject);
    child.once('exit', (code) => reject(new Error(`the runner ended with code ${code}: ${output}`)));
  });
}

// The native command, run with the very words that the page copies.

import { execFileSync } from 'node:child_process';
import { mkdirSync, writeFileSync } from 'node:fs';
import path from 'node:path';
import { before } from 'node:test';

import { ROOT, run } from '../../scripts/run.mjs';

/** Builds the command before the tests of a file: a compiler's minutes are no test's. */
export function useNative() {
  before(() => run('cargo', ['build', '--bin', 'hexcast']));
}

/** Saves the files of the page's geometries, as bytes, into a folder: what a user has on disk. */
export async function writeSample(page, sample, folder) {
  mkdirSync(folder, { recursive: true });
  const files = await page.evaluate(async (sample) => {
    const { sampleFiles } = await import(new URL('page/samples.js', location.href).href);
    return Promise.all(
      sampleFiles(sample).map(async ({ source }) => [source.name, [...new Uint8Array(await source.arrayBuffer())]]),
    );
  }, sample);
  for (const [name, bytes] of files) writeFileSync(path.join(folder, name), Uint8Array.from(bytes));
}

/**
 * Runs the command that the page copies for its job, in a folder, and returns its report.
 *
 * @param {string[]} more further options, such as outputs beside the one that is copied
 */
export async function runCopied(page, folder, more) {
  await page.click('#copy-command');
  const words = wordsOf(await page.inputValue('#copied-text'));
  const program = path.join(ROOT, 'target/debug/hexcast');
  const options = { cwd: folder, encoding: 'utf8', stdio: ['ignore', 'pipe', 'ignore'] };
  return JSON.parse(execFileSync(program, [...words.slice(1), ...more, '--backend=cpu', '--quiet', '--json'], options));
}

/** The words of a line of shell, as the page quotes them: plain, or between single quotes. */
function wordsOf(line) {
  return [...line.matchAll(/'([^']*)'|(\S+)/g)].map(([, quoted, plain]) => quoted ?? plain);
}

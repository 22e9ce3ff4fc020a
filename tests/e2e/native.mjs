// The native command, run with the very words that the page copies.

import { execFileSync } from 'node:child_process';
import { mkdirSync, writeFileSync } from 'node:fs';
import path from 'node:path';

import { commandPath } from '../../scripts/native.mjs';
import { sampleTexts } from './samples.mjs';

/** The native command. */
export const PROGRAM = await commandPath();

/** Saves the files of a sample into a folder: what a user has on disk. */
export async function writeSample(sample, folder) {
  mkdirSync(folder, { recursive: true });
  for (const [name, text] of await sampleTexts(sample)) writeFileSync(path.join(folder, name), text, 'latin1');
}

/**
 * Runs the command that the page copies for its job, but on the CPU, in a folder, and returns its report.
 *
 * @param {string[]} more further options, such as outputs beside the one that is copied; they replace those of the same name
 */
export async function runCopied(page, folder, more) {
  await page.click('#copy-command');
  const optionOf = (word) => word.startsWith('--') && word.split('=')[0];
  const replaced = ['--backend', ...more.map(optionOf).filter(Boolean)];
  const words = wordsOf(await page.inputValue('#copied-text')).filter((word) => !replaced.includes(optionOf(word)));
  const options = { cwd: folder, encoding: 'utf8', stdio: ['ignore', 'pipe', 'ignore'] };
  return JSON.parse(execFileSync(PROGRAM, [...words.slice(1), ...more, '--backend=cpu', '--quiet', '--json'], options));
}

/** The words of a line of shell, as the page quotes them: plain, or between single quotes. */
function wordsOf(line) {
  return [...line.matchAll(/'([^']*)'|(\S+)/g)].map(([, quoted, plain]) => quoted ?? plain);
}

// benches/RESULTS.md: its marked parts, its tables, and what it says of the machine. Also builds what is measured.

import { execFileSync } from 'node:child_process';
import { readFileSync, writeFileSync } from 'node:fs';
import { cpus, release, totalmem } from 'node:os';
import { join } from 'node:path';

import { ROOT } from './run.mjs';

/**
 * The report of a mesh by the native command or the page, as far as it is used here.
 *
 * @typedef {object} Report
 * @property {Record<string, number>} seconds
 * @property {number[]} dims
 * @property {number} cells
 * @property {number} rays
 * @property {number} crossings
 * @property {number} runs
 * @property {string} adapter
 * @property {{ host: number, device: number }} peak_bytes
 * @property {{ facets: number }[]} geometries
 */

const RESULTS = join(ROOT, 'benches/RESULTS.md');

/**
 * Runs a program in the repository and returns what it printed to stdout.
 *
 * @param {string} program
 * @param {string[]} args
 * @param {Record<string, string>} [env]
 */
export const output = (program, args, env = {}) =>
  execFileSync(program, args, {
    cwd: ROOT,
    encoding: 'utf8',
    env: { ...process.env, ...env },
    maxBuffer: 1 << 28,
    stdio: ['ignore', 'pipe', 'inherit'],
  });

/** The lines of a text that are JSON, parsed. @param {string} text @returns {any[]} as the program wrote them */
export const jsonLines = (text) =>
  text
    .split('\n')
    .filter((line) => line.startsWith('{'))
    .map((line) => JSON.parse(line));

/** The middle one of some numbers, the upper of two. @param {number[]} numbers */
export const median = (numbers) => [...numbers].sort((a, b) => a - b)[numbers.length >> 1];

/**
 * Builds a target in the release profile and returns the path of its program: `['bench', 'table']` or `['bin', 'hexcast']`.
 *
 * @param {string[]} target
 */
export function build([kind, name]) {
  const command = kind === 'bench' ? ['bench', '--bench', name, '--no-run'] : ['build', '--release', '--bin', name];
  const messages = jsonLines(output('cargo', [...command, '--message-format=json']));
  return messages.find((message) => message.executable && message.target?.name === name && message.target.kind.includes(kind))
    .executable;
}

/** Seconds as text in ms. @param {number} seconds */
export const ms = (seconds) => (1000 * seconds).toFixed(seconds < 0.01 ? 2 : seconds < 0.1 ? 1 : 0);

/** A Markdown table; all columns but the first to the right. @param {string[]} head @param {unknown[][]} rows */
export const table = (head, rows) =>
  [head, head.map((_, column) => (column ? '---:' : '---')), ...rows].map((row) => `| ${row.join(' | ')} |`).join('\n');

/** Lines about the machine, as far as the system tells it. @param {string} adapter @param {number} load */
export function machine(adapter, load) {
  const cores = cpus();
  const memory = (totalmem() / 2 ** 30).toFixed(0);
  return [
    `* Processor: ${cores[0].model.trim()}, ${cores.length} cores; ${memory} GiB of memory; ${process.platform} ${release()}.`,
    `* GPU backend on: ${adapter}.`,
    `* Date: ${new Date().toISOString().slice(0, 10)}. Load before the run: ${load.toFixed(2)}.`,
  ];
}

/** Replaces what stands between the marks of this name in RESULTS.md. @param {string} name @param {string} text */
export function write(name, text) {
  const marks = [`<!-- ${name} -->`, `<!-- /${name} -->`];
  const [before, rest] = readFileSync(RESULTS, 'utf8').split(marks[0]);
  const after = rest.split(marks[1])[1];
  writeFileSync(RESULTS, `${before}${marks[0]}\n${text}\n${marks[1]}${after}`);
}

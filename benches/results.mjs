// The tables of RESULTS.md and of paper/RESULTS.md, what they say of the machine, and the programs that are measured.

import { execFileSync } from 'node:child_process';
import { readFileSync, writeFileSync } from 'node:fs';
import { cpus, loadavg, release, totalmem } from 'node:os';
import path from 'node:path';

import { ROOT } from '../scripts/run.mjs';

/**
 * The report of a mesh, as far as it is used here.
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

/** Processes that were ready to run before the measurement. */
const LOAD = loadavg()[0];

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

/**
 * Builds a target as it is published, in the profile dist, and returns the path of its program: `['bench', 'table']` or `['bin', 'hexcast']`.
 *
 * @param {string[]} target
 */
export function build([kind, name]) {
  const command = kind === 'bench' ? ['bench', '--bench', name, '--no-run'] : ['build', '--bin', name];
  const messages = jsonLines(output('cargo', [...command, '--profile', 'dist', '--message-format=json']));
  return messages.find((message) => message.executable && message.target?.name === name && message.target.kind.includes(kind))
    .executable;
}

/**
 * The programs of this repository that are measured, and the model: 64 spheres, in a folder that is removed in the end.
 *
 * @param {string} folder
 */
export function programs(folder) {
  const [stages, command] = [build(['bench', 'table']), build(['bin', 'hexcast'])];
  const spheres = path.join(folder, 'spheres.stl');
  output(stages, ['--spheres', spheres]);
  return { stages, command, spheres, folder };
}

/**
 * Times the stages of meshing a file; returns the objects that the program printed.
 *
 * @param {string} program
 * @param {string} file
 * @param {{ n: number, backend: string, runs: string, args?: string[], env?: Record<string, string> }} options
 */
export const timeStages = (program, file, { n, backend, runs, args = [], env }) =>
  jsonLines(output(program, ['--file', file, '--cells', String(n), '--backends', backend, '--runs', runs, ...args], env));

/** The middle one of some numbers, the upper of two. @param {number[]} numbers */
export const median = (numbers) => [...numbers].sort((a, b) => a - b)[numbers.length >> 1];

/** Seconds as text in ms. @param {number} seconds */
export const ms = (seconds) => (1000 * seconds).toFixed(seconds < 0.01 ? 2 : seconds < 0.1 ? 1 : 0);

/** The least and the largest of some numbers as text. @param {number[]} numbers @param {(number: number) => string} write */
export const span = (numbers, write) => `${write(Math.min(...numbers))} - ${write(Math.max(...numbers))}`;

/** A Markdown table; all columns but the first to the right. @param {string[]} head @param {unknown[][]} rows */
export const table = (head, rows) =>
  [head, head.map((_, column) => (column ? '---:' : '---')), ...rows].map((row) => `| ${row.join(' | ')} |`).join('\n');

/** Lines about the machine. @param {string} adapter that of the GPU, empty where none is used */
export function machine(adapter) {
  const cores = cpus();
  const memory = (totalmem() / 2 ** 30).toFixed(0);
  return [
    `* Processor: ${cores[0].model.trim()}, ${cores.length} cores; ${memory} GiB of memory; ${process.platform} ${release()}.`,
    ...(adapter ? [`* GPU backend on: ${adapter}.`] : []),
    `* Date: ${new Date().toISOString().slice(0, 10)}. Load before the run: ${LOAD.toFixed(2)}.`,
  ];
}

/**
 * Prints a part of a file of results and writes it between the marks of its name.
 *
 * @param {string} name
 * @param {string} text
 */
export function write(name, text, file = 'benches/RESULTS.md') {
  const results = path.join(ROOT, file);
  const marks = [`<!-- ${name} -->`, `<!-- /${name} -->`];
  const [before, rest] = readFileSync(results, 'utf8').split(marks[0]);
  const after = rest.split(marks[1])[1];
  writeFileSync(results, `${before}${marks[0]}\n${text}\n${marks[1]}${after}`);
  console.log(text);
}

// node scripts/counted.mjs: counts the instructions of some jobs, and compares them with benches/counted.json. A time depends on the
// machine and on what else runs there; the instructions of one thread do not, to a thousandth. So a change that makes a stage slower by
// work is seen by whoever makes it. `npm test` runs it; HEXCAST_BLESS=1 writes the record.

import { mkdtempSync, readFileSync, readdirSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { fileURLToPath } from 'node:url';

import { buildNative, commandPath } from './native.mjs';
import { writeWave } from '../tests/e2e/wave.mjs';
import { ROOT, run } from './run.mjs';

const RECORD = path.join(ROOT, 'benches/counted.json');
/** Most that a count may grow before the record must be looked at. */
const GROWTH = 0.1;
/** Most that it may fall. More: what the compiler inlines in this build depends on code that a job never runs, and makes up to 14 % of a count. */
const FALL = 0.2;
const CPU = ['--backend', 'cpu', '--threads', '1', '--quiet'];

/** Jobs by what they are: points around the axis of the model, and arguments; OUT is a folder. @type {Record<string, [number, string[]]>} */
const JOBS = {
  'start of the program': [4, ['--version']],
  'facets: 130,320 at 32^3': [362, ['mesh', 'MODEL', '--cells', '32', ...CPU]],
  'rays: 528 facets at 512^3': [24, ['mesh', 'MODEL', '--cells', '512', ...CPU]],
  'file: .vti of 96^3': [24, ['mesh', 'MODEL', '--cells', '96', ...CPU, '-o', 'OUT/a.vti']],
  'fractions: 2,024 facets at 32^3': [46, ['mesh', 'MODEL', '--cells', '32', ...CPU, '--fractions', 'OUT/a.npz']],
  'links: 2,024 facets at 32^3': [46, ['mesh', 'MODEL', '--cells', '32', ...CPU, '--links', 'OUT/b.npz']],
  'edges: info of 32,760 facets': [182, ['info', 'MODEL']],
};

/** Instructions of each job. @returns {Promise<Record<string, number>>} */
async function count() {
  // a record is of the command that all tests run: built by itself it has other features of its crates, and other counts
  const command = process.env.HEXCAST_BLESS ? await buildNative() : await commandPath();
  const folder = mkdtempSync(path.join(tmpdir(), 'hexcast-counted-'));
  const file = path.join(folder, 'sphere.stl');
  /** @type {Record<string, number>} */
  const counts = {};
  try {
    for (const [what, [n, args]] of Object.entries(JOBS)) {
      writeWave(file, n);
      const words = args.map((word) => word.replace('MODEL', file).replace('OUT', folder));
      const tool = ['--tool=cachegrind', '--cache-sim=no', `--cachegrind-out-file=${folder}/counts`];
      await run('valgrind', [...tool, command, ...words]);
      const last = readFileSync(path.join(folder, 'counts'), 'utf8').trimEnd().split('\n').at(-1);
      counts[what] = Number(/^summary: (\d+)$/.exec(last ?? '')?.[1]);
      for (const made of readdirSync(folder)) rmSync(path.join(folder, made));
    }
  } finally {
    rmSync(folder, { recursive: true });
  }
  return counts;
}

/** Compares the counts with the record. @returns {Promise<string>} the largest change */
export async function testCounted() {
  const counts = await count();
  if (process.env.HEXCAST_BLESS) writeFileSync(RECORD, `${JSON.stringify(counts, null, 2)}\n`);
  /** @type {Record<string, number>} */
  const record = JSON.parse(readFileSync(RECORD, 'utf8'));
  const rows = Object.keys({ ...record, ...counts }).map((what) => ({
    what,
    change: counts[what] / record[what] - 1,
    text: `${what}: ${counts[what]} instructions, ${record[what]} recorded`,
  }));
  // what is not a number is outside, too
  const outside = rows.filter(({ change }) => !(change <= GROWTH && change >= -FALL));
  if (outside.length > 0) {
    const hint =
      'Find the cause; where the change is meant, or Rust is another version, HEXCAST_BLESS=1 node scripts/counted.mjs writes the record';
    throw new Error([...outside.map(({ text }) => text), hint].join('\n'));
  }
  const most = Math.max(...rows.map(({ change }) => Math.abs(change)));
  return `${rows.length} counts, the largest change is ${(100 * most).toFixed(2)} %`;
}

if (process.argv[1] === fileURLToPath(import.meta.url)) console.log(await testCounted());

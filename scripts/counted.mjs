// node scripts/counted.mjs: counts the instructions of some jobs, and compares them with benches/counted.json. A time depends on the
// machine and on what else runs there; the instructions of one thread do not, to a thousandth. So a change that makes a stage slower by
// work is seen by whoever makes it. `npm test` runs it; HEXCAST_BLESS=1 writes the record.

import { mkdtempSync, readFileSync, readdirSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { fileURLToPath } from 'node:url';

import { buildNative } from './native.mjs';
import { ROOT, run } from './run.mjs';

const RECORD = path.join(ROOT, 'benches/counted.json');
/** Most that a count may grow, or fall, before the record must be looked at. */
const TOLERANCE = 0.1;
const CPU = ['--backend', 'cpu', '--threads', '1', '--quiet'];

/** Jobs by what they are: how often the facets of a sphere are divided in four, and arguments; OUT is a folder. @type {Record<string, [number, string[]]>} */
const JOBS = {
  'start of the program': [0, ['--version']],
  'facets: 131,072 at 32^3': [7, ['mesh', 'SPHERE', '--cells', '32', ...CPU]],
  'rays: 512 facets at 512^3': [3, ['mesh', 'SPHERE', '--cells', '512', ...CPU]],
  'file: .vti of 96^3': [3, ['mesh', 'SPHERE', '--cells', '96', ...CPU, '-o', 'OUT/a.vti']],
  'fractions: 2,048 facets at 32^3': [4, ['mesh', 'SPHERE', '--cells', '32', ...CPU, '--fractions', 'OUT/a.npz']],
  'links: 2,048 facets at 32^3': [4, ['mesh', 'SPHERE', '--cells', '32', ...CPU, '--links', 'OUT/b.npz']],
  'edges: info of 32,768 facets': [6, ['info', 'SPHERE']],
};

/** @typedef {number[]} Point @typedef {[Point, Point, Point]} Facet */

/** A sphere of 8 * 4^n facets. Made of sums, quotients and roots alone, so that it has the same bits everywhere. @param {number} n */
function sphere(n) {
  const onSphere = (/** @type {Point} */ point) => {
    const length = Math.sqrt(point.reduce((sum, c) => sum + c * c, 0));
    return point.map((c) => c / length);
  };
  const middle = (/** @type {Point} */ a, /** @type {Point} */ b) => onSphere(a.map((c, axis) => c + b[axis]));
  let facets = [0, 1, 2, 3, 4, 5, 6, 7].map((octant) => {
    const [x, y, z] = [0, 1, 2].map((axis) => [0, 1, 2].map((other) => (other === axis ? 1 - 2 * ((octant >> axis) & 1) : 0)));
    // seen from outside, counter-clockwise
    return /** @type {Facet} */ (x[0] * y[1] * z[2] > 0 ? [x, y, z] : [x, z, y]);
  });
  for (let k = 0; k < n; k++) {
    facets = facets.flatMap(([a, b, c]) => {
      const [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
      return /** @type {Facet[]} */ ([
        [a, ab, ca],
        [ab, b, bc],
        [ca, bc, c],
        [ab, bc, ca],
      ]);
    });
  }
  return facets;
}

/** A binary STL. @param {Facet[]} facets */
function stl(facets) {
  const bytes = Buffer.alloc(84 + 50 * facets.length);
  bytes.writeUInt32LE(facets.length, 80);
  facets.flat(2).forEach((number, at) => {
    bytes.writeFloatLE(number, 84 + 50 * Math.floor(at / 9) + 12 + 4 * (at % 9));
  });
  return bytes;
}

/** Instructions of each job. @returns {Promise<Record<string, number>>} */
async function count() {
  const command = process.env.HEXCAST_COMMAND ?? (await buildNative());
  const folder = mkdtempSync(path.join(tmpdir(), 'hexcast-counted-'));
  const file = path.join(folder, 'sphere.stl');
  /** @type {Record<string, number>} */
  const counts = {};
  try {
    for (const [what, [n, args]] of Object.entries(JOBS)) {
      writeFileSync(file, stl(sphere(n)));
      const words = args.map((word) => word.replace('SPHERE', file).replace('OUT', folder));
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
  const outside = rows.filter(({ change }) => !(Math.abs(change) <= TOLERANCE));
  if (outside.length > 0) {
    const hint =
      'Find the cause; where the change is meant, or Rust is another version, HEXCAST_BLESS=1 node scripts/counted.mjs writes the record';
    throw new Error([...outside.map(({ text }) => text), hint].join('\n'));
  }
  const most = Math.max(...rows.map(({ change }) => Math.abs(change)));
  return `${rows.length} counts, the largest change is ${(100 * most).toFixed(2)} %`;
}

if (process.argv[1] === fileURLToPath(import.meta.url)) console.log(await testCounted());

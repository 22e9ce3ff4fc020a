// Times many facets: from file to columns, and `hexcast info`, beside what the machine needs to read the file, and beside the
// figures of the last time, for bench.mjs. The models are made here and not kept.

import { closeSync, openSync, readFileSync, readSync, rmSync, statfsSync, writeFileSync } from 'node:fs';
import path from 'node:path';

import { ROOT } from '../scripts/run.mjs';
import { writeWave } from '../tests/e2e/wave.mjs';
import { median, ms, output, table } from './results.mjs';

/** Medians of the last time, in seconds, and the machine. */
const RECORD = path.join(ROOT, 'benches/facets.json');
/** A row that became slower by more is marked. */
const TOLERANCE = 0.05;
const CHUNK = 1 << 20;
/** Points around the axis of the models: 1e6, 1e7 and 2e7 facets. */
const POINTS = [1000, 3162, 4472];
/** 1e8 facets: their file, and the memory that they are meshed in, which is less than they take. */
const LARGE = { points: 10_000, bytes: 5e9, memory: '2GiB' };

/** Seconds that this machine takes to read a file on one core. @param {string} file */
function secondsToRead(file) {
  const timed = () => {
    const [start, from, chunk] = [performance.now(), openSync(file, 'r'), Buffer.alloc(CHUNK)];
    while (readSync(from, chunk) > 0);
    closeSync(from);
    return (performance.now() - start) / 1000;
  };
  // the first time brings the file into memory
  timed();
  return timed();
}

/** Seconds of a run of a program. @param {string} program @param {string[]} args */
function seconds(program, args) {
  const start = performance.now();
  output(program, args);
  return (performance.now() - start) / 1000;
}

/** Measures surfaces of many facets. @param {import('./bench.mjs').Bench} bench */
export function benchFacets({ command, folder, runs, quick }) {
  const file = path.join(folder, 'wave.stl');
  /** @type {{ what: string, seconds: number, limit: string }[]} */
  const rows = [];
  let large = '';
  const measure = (/** @type {string} */ what, /** @type {string} */ limit, /** @type {() => number} */ run) => {
    rows.push({ what, limit, seconds: median(Array.from({ length: Number(runs) + 1 }, run).slice(1)) });
  };
  const mesh = (/** @type {string[]} */ ...args) => {
    const report = JSON.parse(output(command, ['mesh', file, '--backend', 'cpu', '--json', ...args]));
    return report.seconds.total;
  };
  // so short that many runs make one
  measure('start of the program', '', () => median(Array.from({ length: 20 }, () => seconds(command, ['--version']))));
  for (const points of quick ? POINTS.slice(0, 1) : POINTS) {
    const n = writeWave(file, points).toLocaleString('en');
    const least = ms(secondsToRead(file));
    measure(`${n} facets, file to columns at 1024 cells`, least, () => mesh('--cells', '1024'));
    // with the report, which comes after the columns, and the end of the program
    measure(`${n} facets, the whole command`, least, () =>
      seconds(command, ['mesh', file, '--backend', 'cpu', '--json', '--cells', '1024']),
    );
    measure(`info of ${n} facets`, least, () => seconds(command, ['info', file]));
  }
  const { bavail, bsize } = statfsSync(folder);
  const free = bavail * bsize;
  if (!quick && free < LARGE.bytes) {
    console.log(`1e8 facets: not measured, as ${(free / 1e9).toFixed(1)} GB are free, and their file takes 5 GB`);
  } else if (!quick) {
    const n = writeWave(file, LARGE.points).toLocaleString('en');
    const least = ms(secondsToRead(file));
    /** @type {number[]} */
    const peaks = [];
    measure(`${n} facets within ${LARGE.memory}, the whole command at 1000 cells`, least, () => {
      const start = performance.now();
      const args = ['mesh', file, '--backend', 'cpu', '--json', '--cells', '1000', '--max-memory', LARGE.memory];
      peaks.push(JSON.parse(output(command, args)).peak_bytes.host);
      return (performance.now() - start) / 1000;
    });
    large = `\n\nMost memory of the process with ${n} facets: ${(Math.max(...peaks) / 2 ** 20).toFixed(0)} MiB.`;
    rmSync(file);
  }
  /** @type {Record<string, number>} */
  const before = JSON.parse(readFileSync(RECORD, 'utf8'));
  const lines = rows.map(({ what, limit, seconds }) => {
    const last = before[what];
    const change = last ? `${seconds > last ? '+' : ''}${(100 * (seconds / last - 1)).toFixed(0)} %` : '';
    const mark = seconds > last * (1 + TOLERANCE) ? ' slower' : '';
    return [what, ms(seconds), limit, last ? ms(last) : '', change + mark];
  });
  const now = Object.fromEntries(rows.map(({ what, seconds }) => [what, Number(seconds.toPrecision(4))]));
  writeFileSync(RECORD, `${JSON.stringify({ ...before, ...now }, null, 2)}\n`);
  const text = table(['model', 'ms', 'reading the file on one core, ms', 'last time, ms', 'change'], lines);
  return { adapter: '', text: `## Many facets: binary STL in the page cache\n\n${text}${large}` };
}

// Times hexcast and other programs that flag the cells of a closed surface, for bench.mjs; peers.py has the programs.

import { execFileSync } from 'node:child_process';
import { existsSync, readFileSync } from 'node:fs';
import { join } from 'node:path';

import { ROOT } from '../scripts/run.mjs';
import { jsonLines, median, output, span, table, timeStages } from './results.mjs';

const WINDOWS = process.platform === 'win32';

/** The wheel without CUDA, which exists for Linux on x86-64 only. */
const OPEN3D = process.platform === 'linux' && process.arch === 'x64' ? 'open3d-cpu' : 'open3d';

/**
 * @typedef {import('./bench.mjs').Bench} Bench
 * @typedef {{ id: string, name: string, what: string, imports: string, packages: string[] }} Peer
 *
 * A program in the race: `why` it is left out, or `last`, what it printed last.
 *
 * @typedef {Partial<Peer> & { id: string, isOurs?: boolean, seconds: number[], why?: string, last?: Printed }} Racer
 *
 * What a process printed.
 *
 * @typedef {object} Printed
 * @property {string} [error]
 * @property {string} [version]
 * @property {string} [device]
 * @property {string} [adapter]
 * @property {number[]} dims
 * @property {number} inside
 * @property {number | null} [peak_mib]
 * @property {boolean} same_grid
 * @property {number[]} seconds of its runs
 * @property {string | null} flags the file that has them
 *
 * One process of every program: cells along the longest axis, and the beginning of the names of files for flags.
 *
 * @typedef {Bench & { python: string, n: number, flags: string | null }} Task
 */

/** Peers of benches/peers.py, what they import, and the packages that bring it. */
const PEERS = [
  { id: 'vtk', name: 'VTK', what: 'polydata to image stencil', imports: 'numpy, vtk', packages: ['numpy', 'vtk'] },
  { id: 'open3d', name: 'Open3D', what: 'a ray a cell', imports: 'numpy, open3d', packages: ['numpy', OPEN3D] },
  { id: 'columns', name: 'Open3D', what: 'a ray a column', imports: 'numpy, open3d', packages: ['numpy', OPEN3D] },
  {
    id: 'trimesh',
    name: 'trimesh',
    what: 'voxelized, filled',
    imports: 'scipy.ndimage, trimesh',
    packages: ['numpy', 'scipy', 'trimesh'],
  },
  { id: 'warp', name: 'Warp', what: 'rays restarted', imports: 'numpy, warp', packages: ['numpy', 'warp-lang'] },
];

/** All finish a run of the first within a minute on two cores: trimesh, the slowest, takes 35 s to 41 s, and 6.2 GiB. */
const SIZES = [256, 512];

/** Seconds: a program that would take longer than this at the next size, by the number of cells, is left out. */
const SLOW = 20;

/** Seconds of runs after which a process begins no other. */
const ENOUGH = 20;

/** Seconds that a process may take, start of Python and first compilation included. */
const LIMIT = 180;

/** The last error that a command printed. @param {{ stderr?: Buffer, message: string }} error */
function lastError({ stderr, message }) {
  const lines = String(stderr ?? message)
    .trim()
    .split('\n')
    .filter((line) => !line.startsWith('[notice]'));
  return (lines.filter((line) => line.startsWith('ERROR: ')).pop() ?? lines[lines.length - 1])
    .replace(/^ERROR: /, '')
    .replaceAll('|', '/');
}

/** Runs a command and returns what went wrong, or null. @param {string} program @param {string[]} args */
function failure(program, args) {
  try {
    execFileSync(program, args, { stdio: ['ignore', 'ignore', 'pipe'] });
    return null;
  } catch (error) {
    return lastError(/** @type {{ stderr?: Buffer, message: string }} */ (error));
  }
}

/**
 * Makes the virtual environment of the peers, or adds what it lacks.
 *
 * @param {string[]} ids peers that are wanted
 * @returns {{python: string, missing: Record<string, string>}} its Python, and a sentence for each peer that cannot be installed
 */
export function peersPython(ids) {
  const folder = join(ROOT, '.tools/peers');
  const python = join(folder, WINDOWS ? 'Scripts/python.exe' : 'bin/python');
  if (!existsSync(python)) output(WINDOWS ? 'python' : 'python3', ['-m', 'venv', folder]);
  const version = output(python, ['-c', 'import platform; print("Python", platform.python_version())']).trim();
  /** @type {Record<string, string>} */
  const missing = {};
  for (const { id, imports, packages } of PEERS.filter((peer) => ids.includes(peer.id))) {
    if (!failure(python, ['-c', `import ${imports}`])) continue;
    console.log(`${id}: ${packages.join(', ')} into .tools/peers`);
    const reason =
      failure(python, ['-m', 'pip', 'install', '--quiet', ...packages]) ?? failure(python, ['-c', `import ${imports}`]);
    if (reason) missing[id] = `not available for ${version} on ${process.platform}, ${process.arch}: ${reason}`;
  }
  return { python, missing };
}

/** Counts the bytes in which two files differ; throws where their lengths do. @param {string} path @param {string} other */
export function countDiffering(path, other) {
  const [a, b] = [readFileSync(path), readFileSync(other)];
  if (a.length !== b.length) throw new Error(`${a.length} cells in ${path}, ${b.length} in ${other}`);
  let n_differing = 0;
  for (let cell = 0; cell < a.length; cell++) n_differing += Number(a[cell] !== b[cell]);
  return { n_cells: a.length, n_differing };
}

/** One process of a peer: what it printed, with the seconds of its runs. @param {string} id @param {Task} task @returns {Printed} */
function runPeer(id, { python, spheres, n, runs, flags }) {
  const args = ['benches/peers.py', spheres, String(n), id, '--runs', runs, '--enough', String(ENOUGH), '--limit', String(LIMIT)];
  const [printed] = jsonLines(output(python, [...args, ...(flags ? ['--flags', flags] : [])]));
  return { ...printed, seconds: printed.runs_s, flags: flags && `${flags}.${id}.u8` };
}

/**
 * One process of hexcast's bench, in the same form; in the last round also one of the command, for its memory.
 *
 * @param {string} backend
 * @param {Task} task
 * @returns {Printed}
 */
function runHexcast(backend, { stages, command, spheres, n, runs, flags }) {
  const out = flags && `${flags}.${backend}.u8`;
  const [printed] = timeStages(stages, spheres, { n, backend, runs, args: out ? ['--flags', out] : [] });
  const seconds = printed.runs.map((/** @type {Record<string, number>} */ s) => s.read + s.lines + s.snap + s.columns + s.flags);
  const result = { ...printed, seconds, flags: out, same_grid: true };
  if (!out) return result;
  const mesh = ['mesh', spheres, '--cells', String(n), '--backend', backend, '--flags-in-memory', '--json'];
  const { host } = JSON.parse(output(command, mesh)).peak_bytes;
  return { ...result, peak_mib: host && Math.round(host / 2 ** 20) };
}

const HEXCAST = ['cpu', 'gpu'].map((id) => ({ id, isOurs: true }));

/**
 * All programs at one size, in turn: seconds of every warm run, and what each printed last.
 *
 * @param {Bench & { python: string }} bench
 * @param {number} n
 * @param {Record<string, string | undefined>} skipped
 */
function race(bench, n, skipped) {
  /** @type {Racer[]} */
  const racers = [...PEERS, ...HEXCAST].map((racer) => ({ ...racer, seconds: [], why: skipped[racer.id] }));
  for (let round = 1; round <= bench.rounds; round++) {
    const task = { ...bench, n, flags: round === bench.rounds ? join(bench.folder, `peers${n}`) : null };
    for (const racer of racers.filter(({ why }) => !why)) {
      const last = (racer.isOurs ? runHexcast : runPeer)(racer.id, task);
      racer.last = last;
      if (last.error) racer.why = `failed: ${last.error.replaceAll('|', '/')}`;
      else racer.seconds.push(...last.seconds);
    }
  }
  return racers;
}

/**
 * Cells in which a program's flags differ from those of hexcast's CPU backend, or why that is no number.
 *
 * @param {Racer} racer
 * @param {Racer} ours
 */
function differing({ last }, ours) {
  if (!last?.flags || !ours.last?.flags) return 'unknown';
  if (!last.same_grid) return `another grid, ${last.dims.join(' x ')}`;
  return countDiffering(last.flags, ours.last.flags).n_differing;
}

/** @param {Racer} racer */
function nameOf({ id, name, what, isOurs, last }) {
  if (isOurs) return id === 'cpu' ? 'hexcast, CPU' : `hexcast, GPU (${last?.adapter?.split(' (')[0]})`;
  if (!last?.version) return `${name}, ${what}`;
  return `${name} ${last.version}, ${what}${last.device === 'cpu' ? '' : ` on ${last.device}`}`;
}

/** @param {number} seconds */
const digits = (seconds) => seconds.toFixed(seconds < 0.1 ? 4 : seconds < 10 ? 3 : 1);

/** @param {number} n @param {Racer[]} racers */
function raceTable(n, racers) {
  const ours = racers.find(({ id }) => id === 'cpu');
  if (!ours) throw new Error('hexcast is left out');
  const rows = racers.map((racer) => {
    if (racer.why || !racer.last) return [nameOf(racer), racer.why, '', '', '', '', '', ''];
    const middle = median(racer.seconds);
    return [
      nameOf(racer),
      digits(middle),
      span(racer.seconds, digits),
      (racer.last.dims.reduce((cells, side) => cells * side, 1) / middle / 1e6).toFixed(1),
      `${(middle / median(ours.seconds)).toFixed(1)}x`,
      racer.last.peak_mib ?? 'unknown',
      racer.last.inside,
      differing(racer, ours),
    ];
  });
  return table(
    [`${n}^3`, 'flags, s', 'from - to', '1e6 cells/s', 'time, of hexcast on the CPU', 'peak, MiB', 'inside', 'differing'],
    rows,
  );
}

/**
 * Why programs are left out at the next size: they could not be installed, failed, or would be slow.
 *
 * @param {Racer[]} racers
 * @param {number} n
 * @param {number} next
 */
function leftOut(racers, n, next) {
  const why = (/** @type {Racer} */ racer) => {
    if (racer.why) return racer.last ? `not run: failed at ${n}^3` : racer.why;
    const middle = median(racer.seconds);
    return !racer.isOurs && middle * (next / n) ** 3 > SLOW
      ? `not run: ${digits(middle)} s at ${n}^3, so more than ${SLOW} s here`
      : undefined;
  };
  return Object.fromEntries(racers.map((racer) => [racer.id, why(racer)]));
}

/** Measures all peers and both backends. @param {Bench} bench */
export function benchPeers(bench) {
  const { python, missing } = peersPython(PEERS.map(({ id }) => id));
  const sizes = bench.quick ? [128] : SIZES;
  const tables = [
    `* A process that has run for ${ENOUGH} s begins no other run; where its first run is the only one, it counts.`,
  ];
  /** @type {Record<string, string | undefined>} */
  let skipped = missing;
  let adapter = '';
  for (const [at, n] of sizes.entries()) {
    const racers = race({ ...bench, python }, n, skipped);
    tables.push(raceTable(n, racers));
    skipped = leftOut(racers, n, sizes[at + 1]);
    adapter = racers.find(({ id }) => id === 'gpu')?.last?.adapter ?? 'unknown';
  }
  return { adapter, text: tables.join('\n\n') };
}

// Times hexcast and other programs on the same files in the same run, in turn, and writes the tables of benches/RESULTS.md.
// usage: node scripts/bench.mjs [peers | page] [--quick] [--rounds R] [--runs K] [--largest N]
// Without a word: all stages beside VTK, then "peers", which is all the programs of benches/peers.py: see bench_peers.mjs.
// "page" times the page in Chromium instead, beside the command on the same driver: see bench_page.mjs. "paper" has options of
// its own: see paper.mjs.
// Needs cargo, and python3 with venv for the peers; makes .tools/peers on first use. Takes some ten minutes.

import { mkdtempSync, rmSync } from 'node:fs';
import { loadavg, tmpdir } from 'node:os';
import { join } from 'node:path';
import { parseArgs } from 'node:util';

import { benchPage } from './bench_page.mjs';
import { benchPeers, countDiffering, peersPython } from './bench_peers.mjs';
import { LIMIT_HEAD, LIMIT_LINES, limitCells } from './limits.mjs';
import { paper } from './paper.mjs';
import { build, jsonLines, machine, median, ms, output as run, table, write } from './results.mjs';
import { ROOT as root } from './run.mjs';

/**
 * @typedef {{ python: string, bench: string }} Programs
 *
 * What a process printed of its runs: seconds of each stage, as `columns_s`, and the medians from the file on.
 *
 * @typedef {Record<string, number> & { adapter: string }} Said
 * @typedef {{ n: number, seconds: Record<'vtk' | 'cpu' | 'gpu', number[]>, bits: Record<'cpu' | 'gpu', number[]>, last: Record<'vtk' | 'cpu' | 'gpu', Said>, load: number }} Race
 *
 * @typedef {object} Passes
 * @property {number} n
 * @property {[string, number][]} gpu_passes
 * @property {[string, number][]} cpu_passes
 * @property {import('./limits.mjs').Counts} counts
 * @property {Record<import('./limits.mjs').Limit, number>} machine
 * @property {{ n_pairs: number, n_crossings: number, naive_s: number, ours_s: number }} naive_gather
 */

const { values: options, positionals } = parseArgs({
  allowPositionals: true,
  options: {
    models: { type: 'string' },
    quick: { type: 'boolean', default: false },
    rounds: { type: 'string', default: '2' },
    runs: { type: 'string', default: '3' },
    largest: { type: 'string' },
  },
});
const sizes = options.quick ? [256] : [512, 1024];
const rounds = Number(options.rounds);
const ROUNDS = `* ${rounds} rounds, programs in turn; ${options.runs} runs a program and round after a first that does not count; medians.`;

/** The Python that has VTK, without which the tables beside it cannot be made. */
function vtkPython() {
  const { python, missing } = peersPython(['vtk']);
  if (missing.vtk) throw new Error(`VTK: ${missing.vtk}; "npm run bench -- peers" does without`);
  return python;
}

/**
 * Times VTK and both backends in turn; seconds from file to flags in memory of every warm run.
 *
 * @param {Programs} programs
 * @param {string} file
 * @param {number} n
 * @returns {Race}
 */
function race(programs, file, n) {
  /** @type {Race['seconds']} */
  const seconds = { vtk: [], cpu: [], gpu: [] };
  /** @type {Race['bits']} */
  const bits = { cpu: [], gpu: [] };
  const last = /** @type {Record<'vtk' | 'cpu' | 'gpu', any>} */ ({});
  for (let round = 0; round < rounds; round++) {
    const args = ['benches/peers.py', file, String(n), 'vtk', '--runs', options.runs];
    [last.vtk] = jsonLines(run(programs.python, args));
    if (last.vtk.error) throw new Error(`VTK failed: ${last.vtk.error}`);
    seconds.vtk.push(...last.vtk.runs_s);
    for (const backend of /** @type {const} */ (['cpu', 'gpu'])) {
      const args = ['--file', file, '--cells', String(n), '--backends', backend, '--runs', options.runs];
      [last[backend]] = jsonLines(run(programs.bench, args));
      const untilColumns = (/** @type {Record<string, number>} */ s) => s.read + s.lines + s.snap + s.columns;
      seconds[backend].push(...last[backend].runs.map((/** @type {Record<string, number>} */ s) => untilColumns(s) + s.flags));
      bits[backend].push(...last[backend].runs.map((/** @type {Record<string, number>} */ s) => untilColumns(s) + s.bits));
    }
  }
  return { n, seconds, bits, last, load: loadavg()[0] };
}

/**
 * Counts the cells in which VTK and hexcast differ.
 *
 * @param {Programs} programs
 * @param {string} file
 * @param {number} n
 * @param {string} scratch
 */
function differences(programs, file, n, scratch) {
  const prefix = join(scratch, 'flags');
  run(programs.python, ['benches/peers.py', file, String(n), 'vtk', '--flags', prefix]);
  run(programs.bench, ['--file', file, '--cells', String(n), '--backends', 'cpu', '--runs', '0', '--flags', `${prefix}.ours`]);
  return { n, ...countDiffering(`${prefix}.vtk.u8`, `${prefix}.ours`) };
}

/** @param {Race} race */
function raceTable({ n, seconds, bits, last }) {
  const vtk = median(seconds.vtk);
  const times = (/** @type {number} */ middle) => `${(vtk / middle).toFixed(1)}x`;
  /**
   * @param {string} name
   * @param {number[]} all
   * @param {Said} run
   * @param {number[]} [allBits]
   */
  const row = (name, all, run, allBits) => {
    const middle = median(all);
    const middleBits = allBits ? median(allBits) : NaN;
    const columns = run.to_columns_s ? ms(run.to_columns_s) : '';
    const again = run.to_flags_again_s ? ms(run.to_flags_again_s) : '';
    const vec = run.to_flags_in_vec_s ? ms(run.to_flags_in_vec_s) : '';
    const spread = `${ms(Math.min(...all))} - ${ms(Math.max(...all))}`;
    const packed = allBits ? [ms(middleBits), times(middleBits)] : ['', ''];
    return [name, columns, ms(middle), spread, again, vec, (n ** 3 / middle / 1e9).toFixed(2), times(middle), ...packed];
  };
  return table(
    [
      `${n}^3`,
      'columns, ms',
      'flags, ms',
      'from - to',
      'flags again, ms',
      'flags in Vec, ms',
      '1e9 cells/s',
      'against VTK',
      'bits, ms',
      'against VTK',
    ],
    [
      row('VTK', seconds.vtk, last.vtk),
      row('hexcast, CPU', seconds.cpu, last.cpu, bits.cpu),
      row(`hexcast, GPU (${last.gpu.adapter.split(' (')[0]})`, seconds.gpu, last.gpu, bits.gpu),
    ],
  );
}

/** @param {Race} race */
function stageTable({ n, last }) {
  const stages = ['read', 'lines', 'snap', 'columns', 'flags', 'flags_again', 'flags_in_vec', 'bits', 'bytes_once'];
  const row = (/** @type {string} */ name, /** @type {Said} */ run) => [
    name,
    ...stages.map((stage) => ms(run[`${stage}_s`])),
    (run.crossings_per_s / 1e6).toFixed(1),
  ];
  return table(
    [`${n}^3, ms`, ...stages.map((stage) => stage.replaceAll('_', ' ')), '1e6 crossings/s'],
    [row('CPU', last.cpu), row('GPU', last.gpu)],
  );
}

/** @param {string} name @param {[string, number][]} passes @param {Passes} all */
function passTable(name, passes, { counts, machine }, isWhole = (/** @type {string} */ _pass) => false) {
  const total = passes.filter(([pass]) => !isWhole(pass)).reduce((sum, [, seconds]) => sum + seconds, 0);
  const share = (/** @type {string} */ pass, /** @type {number} */ seconds) =>
    isWhole(pass) ? '' : `${((100 * seconds) / total).toFixed(1)} %`;
  const row = (/** @type {[string, number]} */ [pass, seconds]) => [
    pass,
    ms(seconds),
    share(pass, seconds),
    ...limitCells(pass, seconds, counts, machine),
  ];
  return table([name, 'ms', 'share', ...LIMIT_HEAD], passes.map(row));
}

/** @param {Passes} passes */
function gatherLine({ n, naive_gather: g }) {
  return [`${n}^3`, g.n_pairs, g.n_crossings, ms(g.naive_s), ms(g.ours_s), `${(g.naive_s / g.ours_s).toFixed(1)}x`];
}

/** All stages, beside VTK. */
function measured() {
  const load = loadavg()[0];
  const scratch = mkdtempSync(join(tmpdir(), 'hexcast-bench-'));
  try {
    const programs = { bench: build(['bench', 'table']), python: vtkPython() };
    const spheres = join(scratch, 'spheres.stl');
    run(programs.bench, ['--spheres', spheres]);
    const spot = join(root, 'tests/fixtures/spot.stl');
    const races = sizes.map((n) => race(programs, spheres, n));
    /** @type {Passes[]} */
    const passes = sizes.map(
      (n) =>
        jsonLines(
          run(programs.bench, ['--file', spheres, '--cells', String(n), '--backends', 'cpu', '--runs', '5', '--passes']),
        )[1],
    );
    const compared = Object.entries({ '64 spheres': spheres, spot }).flatMap(([name, file]) =>
      [128, 256].map((n) => ({ name, ...differences(programs, file, n, scratch) })),
    );
    const whole = (/** @type {string} */ pass) => pass.startsWith('all');
    const text = [
      ...machine(races[0].last.gpu.adapter, load),
      `${ROUNDS} Of passes, the run that was disturbed least.\n`,
      '## From file to flags in memory, 64 spheres\n',
      races.map(raceTable).join('\n\n'),
      '\n### Stage by stage\n',
      races.map(stageTable).join('\n\n'),
      '\n### Columns, pass by pass\n',
      `${LIMIT_LINES}\n`,
      passes
        .flatMap((p) => [passTable(`GPU, ${p.n}^3`, p.gpu_passes, p), passTable(`CPU, ${p.n}^3`, p.cpu_passes, p, whole)])
        .join('\n\n'),
      "\n## The paper's gather beside our intersection\n",
      table(['GPU', '(facet, bin) pairs', 'crossings', 'gather, ms', 'ours, ms', 'gather / ours'], passes.map(gatherLine)),
      "\n## Cells that differ from VTK's\n",
      table(
        ['model', 'cells', 'differing'],
        compared.map(({ name, n, n_cells, n_differing }) => [`${name}, ${n}`, n_cells, n_differing]),
      ),
    ].join('\n');
    write('measured', text);
    console.log(text);
  } finally {
    rmSync(scratch, { recursive: true });
  }
}

/** All peers, beside both backends. */
function peers() {
  const load = loadavg()[0];
  const scratch = mkdtempSync(join(tmpdir(), 'hexcast-bench-'));
  try {
    const [bench, command] = [build(['bench', 'table']), build(['bin', 'hexcast'])];
    const file = join(scratch, 'spheres.stl');
    run(bench, ['--spheres', file]);
    const { adapter, text } = benchPeers({ file, scratch, bench, command, rounds, runs: options.runs, quick: options.quick });
    write('peers', [...machine(adapter, load), ROUNDS, text].join('\n'));
    console.log(text);
  } finally {
    rmSync(scratch, { recursive: true });
  }
}

/** The page in Chromium. */
async function page() {
  const load = loadavg()[0];
  const scratch = mkdtempSync(join(tmpdir(), 'hexcast-bench-'));
  try {
    const tools = {
      scratch,
      run,
      jsonLines,
      median,
      ms,
      table,
      command: build(['bin', 'hexcast']),
      bench: build(['bench', 'table']),
    };
    const { adapter, text } = await benchPage({ ...options, rounds, sizes: options.quick ? [128] : sizes }, tools);
    write('measured page', [...machine(adapter, load), `${ROUNDS}\n`, text].join('\n'));
    console.log(text);
  } finally {
    rmSync(scratch, { recursive: true });
  }
}

const [what = 'native', ...parts] = positionals;
if (what === 'native') {
  measured();
  peers();
} else if (what === 'peers') peers();
else if (what === 'page') await page();
else if (what === 'paper') paper(parts, { ...options, runs: Number(options.runs) });
else throw new Error(`no bench is named ${what}: native, peers, page or paper`);

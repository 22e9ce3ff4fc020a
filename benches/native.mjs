// Times the native program and VTK, stage by stage, and every pass of the columns, for bench.mjs.

import path from 'node:path';

import { ROOT } from '../scripts/run.mjs';
import { LIMIT_HEAD, limitCells } from './limits.mjs';
import { countDiffering, peersPython } from './peers.mjs';
import { jsonLines, median, ms, output, span, table, timeStages } from './results.mjs';

/**
 * @typedef {import('./bench.mjs').Bench} Bench
 * @typedef {'vtk' | 'cpu' | 'gpu'} Racer
 *
 * What a process printed of its runs: seconds of each stage, as `columns_s`, and the medians from the file on.
 *
 * @typedef {Record<string, number> & { adapter: string }} Printed
 *
 * Seconds of all warm runs, to flags and to bits, and what each process printed last.
 *
 * @typedef {{ n: number, seconds: Record<Racer, number[]>, bits: Record<Racer, number[]>, last: Record<Racer, Printed> }} Race
 *
 * @typedef {object} Passes
 * @property {number} n
 * @property {[string, number][]} gpu_passes
 * @property {[string, number][]} cpu_passes
 * @property {import('./limits.mjs').Counts} counts
 * @property {Record<import('./limits.mjs').Limit, number>} machine
 * @property {{ n_pairs: number, n_crossings: number, naive_s: number, ours_s: number }} naive_gather
 */

/** Times VTK and both backends in turn, from file to flags in memory. @param {Bench} bench @param {string} python @param {number} n */
function race({ stages, spheres, rounds, runs }, python, n) {
  /** @type {Race} */
  const race = { n, seconds: { vtk: [], cpu: [], gpu: [] }, bits: { vtk: [], cpu: [], gpu: [] }, last: /** @type {any} */ ({}) };
  for (let round = 0; round < rounds; round++) {
    const [vtk] = jsonLines(output(python, ['benches/peers.py', spheres, String(n), 'vtk', '--runs', runs]));
    if (vtk.error) throw new Error(`VTK failed: ${vtk.error}`);
    race.seconds.vtk.push(...vtk.runs_s);
    race.last.vtk = vtk;
    for (const backend of /** @type {const} */ (['cpu', 'gpu'])) {
      const [printed] = timeStages(stages, spheres, { n, backend, runs });
      for (const { read, lines, snap, columns, flags, bits } of printed.runs) {
        race.seconds[backend].push(read + lines + snap + columns + flags);
        race.bits[backend].push(read + lines + snap + columns + bits);
      }
      race.last[backend] = printed;
    }
  }
  return race;
}

/** Counts the cells in which VTK and hexcast differ. @param {Bench} bench @param {string} python @param {string} file @param {number} n */
function differences({ stages, folder }, python, file, n) {
  const prefix = path.join(folder, 'flags');
  output(python, ['benches/peers.py', file, String(n), 'vtk', '--flags', prefix]);
  timeStages(stages, file, { n, backend: 'cpu', runs: '0', args: ['--flags', `${prefix}.ours`] });
  const { n_cells, n_differing } = countDiffering(`${prefix}.vtk.u8`, `${prefix}.ours`);
  return [`${path.basename(file, '.stl')}, ${n}`, n_cells, n_differing];
}

/** @param {Race} race */
function raceTable({ n, seconds, bits, last }) {
  const timesFaster = (/** @type {number} */ middle) => `${(median(seconds.vtk) / middle).toFixed(1)}x`;
  const row = (/** @type {string} */ name, /** @type {Racer} */ racer) => {
    const [all, run, middle] = [seconds[racer], last[racer], median(seconds[racer])];
    const written = ['to_columns_s', 'to_flags_again_s', 'to_flags_in_vec_s'].map((key) => (run[key] ? ms(run[key]) : ''));
    const packed = bits[racer].length > 0 ? [ms(median(bits[racer])), timesFaster(median(bits[racer]))] : ['', ''];
    const [columns, again, vec] = written;
    return [
      name,
      columns,
      ms(middle),
      span(all, ms),
      again,
      vec,
      (n ** 3 / middle / 1e9).toFixed(2),
      timesFaster(middle),
      ...packed,
    ];
  };
  const head = 'columns, ms|flags, ms|from - to|flags again, ms|flags in Vec, ms|1e9 cells/s|against VTK|bits, ms|against VTK';
  const gpu = `hexcast, GPU (${last.gpu.adapter.split(' (')[0]})`;
  return table([`${n}^3`, ...head.split('|')], [row('VTK', 'vtk'), row('hexcast, CPU', 'cpu'), row(gpu, 'gpu')]);
}

/** @param {Race} race */
function stageTable({ n, last }) {
  const stages = ['read', 'lines', 'snap', 'columns', 'flags', 'flags_again', 'flags_in_vec', 'bits', 'bytes_once'];
  const row = (/** @type {'cpu' | 'gpu'} */ backend) => [
    backend.toUpperCase(),
    ...stages.map((stage) => ms(last[backend][`${stage}_s`])),
    (last[backend].crossings_per_s / 1e6).toFixed(1),
  ];
  const head = [`${n}^3, ms`, ...stages.map((stage) => stage.replaceAll('_', ' ')), '1e6 crossings/s'];
  return table(head, [row('cpu'), row('gpu')]);
}

/** @param {string} name @param {[string, number][]} passes @param {Passes} all */
function passTable(name, passes, { counts, machine }) {
  // the whole mesh, which the passes are parts of
  const isWhole = (/** @type {string} */ pass) => pass.startsWith('all');
  const total = passes.filter(([pass]) => !isWhole(pass)).reduce((sum, [, seconds]) => sum + seconds, 0);
  const rows = passes.map(([pass, seconds]) => {
    const share = isWhole(pass) ? '' : `${((100 * seconds) / total).toFixed(1)} %`;
    return [pass, ms(seconds), share, ...limitCells(pass, seconds, counts, machine)];
  });
  return table([name, 'ms', 'share', ...LIMIT_HEAD], rows);
}

/** @param {Passes} passes */
function gatherRow({ n, naive_gather: g }) {
  return [`${n}^3`, g.n_pairs, g.n_crossings, ms(g.naive_s), ms(g.ours_s), `${(g.naive_s / g.ours_s).toFixed(1)}x`];
}

/** Measures all stages, and VTK. @param {Bench} bench */
export function benchNative(bench) {
  const { stages, spheres, sizes } = bench;
  const { python, missing } = peersPython(['vtk']);
  if (missing.vtk) throw new Error(`VTK: ${missing.vtk}; "npm run bench -- peers" does without`);
  const races = sizes.map((n) => race(bench, python, n));
  /** @type {Passes[]} */
  const passes = sizes.map((n) => timeStages(stages, spheres, { n, backend: 'cpu', runs: '5', args: ['--passes'] })[1]);
  const models = [spheres, path.join(ROOT, 'tests/fixtures/spot.stl')];
  const differing = models.flatMap((file) => [128, 256].map((n) => differences(bench, python, file, n)));
  const passTables = passes.flatMap((all) => [
    passTable(`GPU, ${all.n}^3`, all.gpu_passes, all),
    passTable(`CPU, ${all.n}^3`, all.cpu_passes, all),
  ]);
  const text = [
    '* Of the passes, the run that was disturbed least.',
    '## From file to flags in memory, 64 spheres',
    ...races.map(raceTable),
    '### Stage by stage',
    ...races.map(stageTable),
    '### Columns, pass by pass',
    ...passTables,
    "## The paper's gather beside our intersection",
    table(['GPU', '(facet, bin) pairs', 'crossings', 'gather, ms', 'ours, ms', 'gather / ours'], passes.map(gatherRow)),
    "## Cells that differ from VTK's",
    table(['model', 'cells', 'differing'], differing),
  ].join('\n\n');
  return { adapter: races[0].last.gpu.adapter, text };
}

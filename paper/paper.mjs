// Measures what the paper measured: its Table 1, its Figures 14 and 15, cost against cells at equal rays, and the traditional
// algorithm. Writes the parts of RESULTS.md, and fig14.svg and fig15.svg.
// usage: npm run paper -- [table1] [trillion] [fig14] [fig15] [depth] [serial] [--models DIR] [--quick] [--runs K]
// By default all parts. Every number is a median of processes. --quick meshes a thousandth of the cells, prints, and writes plots
// to target/.

import { mkdtempSync, rmSync, statSync, statfsSync } from 'node:fs';
import { tmpdir, totalmem } from 'node:os';
import { join } from 'node:path';
import { parseArgs } from 'node:util';

import { machine, ms, table, timeStages, write } from '../benches/results.mjs';
import { ROOT } from '../scripts/run.mjs';
import { fig14, fig15 } from './figures.mjs';
import { BACKENDS, Bench, MODELS, count, power, ratio, seconds } from './runs.mjs';

/** Flags of all cells must leave the machine room for the rest. */
const SHARE_OF_MEMORY = 0.45;
/** Files larger than this are written once, by one backend. */
const LARGE_FILE = 8e9;

/** Table 1: columns, flags in memory, flags in a file. @param {Bench} bench */
function table1(bench) {
  /** @type {unknown[][][]} */
  const [columns, flags] = [[], []];
  for (const wanted of MODELS) {
    const model = bench.model(wanted);
    if (!model) {
      columns.push([wanted.name, 'no file of this model']);
      continue;
    }
    const args = ['--cells', String(bench.cellsFor(model.file, bench.cells(wanted.n_cells)))];
    for (const backend of BACKENDS) {
      const report = bench.meshes(model.file, args, backend);
      columns.push(columnsRow(wanted, model, backend, report));
      flags.push(flagsRow(bench, wanted, model.file, args, backend, report.cells));
    }
  }
  const head =
    'model|file|backend|facets|cells|rays|crossings|columns, s|process, s|the paper, GPU, s|ratio|peak host, MiB'.split('|');
  return [
    '## Table 1 of the paper\n',
    table(head, columns),
    '\nThe same meshes on to flags. Seconds are from the file on, columns included; *file* is bit-packed, eight cells a byte.\n',
    table(
      ['model', 'backend', 'flags in memory, s', 'the paper / ours', 'flags in a file, s', 'file, GB', 'written, GB/s'],
      flags,
    ),
  ].join('\n');
}

/**
 * @param {import('./runs.mjs').Model} wanted
 * @param {{ origin: string }} model
 * @param {string} backend
 * @param {import('./runs.mjs').Report} report
 */
function columnsRow(wanted, { origin }, backend, report) {
  const n_facets = report.geometries.reduce((sum, geometry) => sum + geometry.facets, 0);
  return [
    wanted.name,
    origin,
    backend,
    count(n_facets),
    power(report.cells, 2),
    power(report.rays, 2),
    power(report.crossings, 2),
    seconds(report.seconds.total),
    seconds(report.process_s),
    wanted.paper,
    ratio(wanted.paper, report.seconds.total),
    (report.peak_bytes.host / 2 ** 20).toFixed(0),
  ];
}

/**
 * @param {Bench} bench
 * @param {import('./runs.mjs').Model} wanted
 * @param {string} file
 * @param {string[]} args
 * @param {string} backend
 * @param {number} n_cells
 */
function flagsRow(bench, wanted, file, args, backend, n_cells) {
  const row = [wanted.name, backend];
  if (n_cells < SHARE_OF_MEMORY * totalmem()) {
    const { total } = bench.meshes(file, [...args, '--flags-in-memory'], backend).seconds;
    row.push(seconds(total), ratio(wanted.paper, total));
  } else row.push('more than memory', '');
  const n_bytes = n_cells / 8;
  const { bavail, bsize } = statfsSync(bench.scratch);
  if (n_bytes > LARGE_FILE && backend !== 'cpu') return [...row, 'as on the CPU', '', ''];
  if (1.25 * n_bytes > bavail * bsize) return [...row, 'more than the disk has', '', ''];
  const out = join(bench.scratch, 'flags.raw');
  const report = bench.meshes(file, [...args, '--bits', '-o', out], backend, n_bytes > LARGE_FILE ? 1 : bench.runs);
  const written = statSync(out).size;
  rmSync(out);
  return [
    ...row,
    seconds(report.seconds.total + report.seconds.write),
    (written / 1e9).toFixed(2),
    (written / 1e9 / report.seconds.write).toFixed(2),
  ];
}

/** 1e12 cells of model 4 on the CPU backend. @param {Bench} bench */
function trillion(bench) {
  const report = bench.meshes(bench.spheres, ['--cells', String(bench.cellsFor(bench.spheres, bench.cells(1e12)))], 'cpu', 1);
  const row = ['64 spheres', report.dims.join(' x '), power(report.cells, 2), power(report.rays, 2), power(report.crossings, 2)];
  return [
    '## 10^12 cells, CPU backend\n',
    table(
      ['model', 'dims', 'cells', 'rays', 'crossings', 'columns, s', 'peak host, MiB'],
      [[...row, seconds(report.seconds.total), (report.peak_bytes.host / 2 ** 20).toFixed(0)]],
    ),
  ].join('\n');
}

/** Seconds against cells at equal rays: more cells along the rays only. @param {Bench} bench */
function depth(bench) {
  const across = bench.quick ? 100 : 1000;
  const rows = [];
  for (const backend of BACKENDS) {
    /** @type {Record<string, number> | undefined} */
    let first;
    for (const deep of [across, 10 * across, 100 * across]) {
      const report = bench.meshes(bench.spheres, ['--dims', `${across},${across},${deep}`, '--axis', 'z'], backend);
      first ??= report.seconds;
      const change = (100 * (report.seconds.total / first.total - 1)).toFixed(1);
      rows.push([
        backend,
        report.dims.join(' x '),
        power(report.cells, 0),
        report.rays,
        report.crossings,
        ms(report.seconds.columns),
        ms(report.seconds.total),
        `${change} %`,
      ]);
    }
  }
  return [
    '## Cost against cells at equal rays\n',
    '64 spheres, rays along z, more and more cells along them. Columns are made of crossings, so their number of cells should not matter.\n',
    table(['backend', 'dims', 'cells', 'rays', 'crossings', 'lattice to runs, ms', 'file to columns, ms', 'change'], rows),
  ].join('\n');
}

/** The traditional algorithm on one core, and both backends, from the file to flags in memory. @param {Bench} bench */
function serial(bench) {
  const rows = [];
  for (const n of bench.quick ? [64, 128] : [256, 512, 1024]) {
    const lines = timeStages(bench.stages, bench.spheres, {
      n,
      backend: 'cpu,gpu',
      runs: String(bench.runs),
      args: ['--serial'],
    });
    const traditional = lines.find((line) => line.serial).serial;
    const [cpu, gpu] = BACKENDS.map((backend) => lines.find((line) => line.backend === backend));
    rows.push([
      `${n}^3`,
      power(traditional.n_tests, 2),
      ms(traditional.to_flags_s),
      ...[cpu, gpu].flatMap((line) => [ms(line.to_flags_s), ratio(traditional.to_flags_s, line.to_flags_s)]),
      `${traditional.n_differing} of ${power(traditional.n_cells, 2)}`,
    ]);
  }
  return [
    '## Beside the traditional algorithm\n',
    "64 spheres, from the file to flags in memory. *Traditional* is the paper's baseline, which its speed-up is relative to",
    '(`benches/table/serial.rs`): one core, a loop over the facets of the bin for every ray, the same lattice, then a loop over all',
    "cells. The paper's speed-ups, models 1 to 4: 14.3, 15.3, 14.4, 14.6. Nothing here is extrapolated.\n",
    table(
      ['cells', 'ray and facet tests', 'traditional, ms', 'CPU, ms', 'speed-up', 'GPU, ms', 'speed-up', 'cells that differ'],
      rows,
    ),
  ].join('\n');
}

/** @type {Record<string, (bench: Bench) => string>} */
const PARTS = { table1, trillion, fig14, fig15, depth, serial };

const { values, positionals } = parseArgs({
  allowPositionals: true,
  options: {
    models: { type: 'string' },
    quick: { type: 'boolean', default: false },
    runs: { type: 'string', default: '3' },
  },
});
const unknown = positionals.find((name) => !(name in PARTS));
if (unknown) throw new Error(`no part is named ${unknown}: ${Object.keys(PARTS).join(', ')}`);
const scratch = mkdtempSync(join(tmpdir(), 'hexcast-paper-'));
process.on('exit', () => rmSync(scratch, { recursive: true }));
const bench = new Bench({ ...values, runs: Number(values.runs) }, scratch);
const { adapter } = bench.mesh(join(ROOT, 'tests/fixtures/spot.stl'), ['--cells', '16'], 'gpu');
const medians = `* Medians of ${bench.runs} processes; 10^12 cells and files over 8 GB once.\n`;
for (const name of positionals.length > 0 ? positionals : Object.keys(PARTS)) {
  const text = `${PARTS[name](bench)}\n\n${[...machine(adapter), medians].join('\n')}`;
  if (bench.quick) console.log(text);
  else write(name, text, 'paper/RESULTS.md');
}

// The paper's Table 1 and Figures 14 and 15 again, cost against cells at equal rays, and the traditional algorithm; writes the
// parts of benches/RESULTS.md between their marks and docs/fig14.svg, docs/fig15.svg.
// usage: node scripts/bench.mjs paper [table1] [trillion] [fig14] [fig15] [depth] [serial] [--models DIR] [--quick] [--runs K]
// Every number is of processes of their own; medians. --quick has a thousandth of the cells and only prints; plots go to target/.

import { mkdtempSync, rmSync, statSync, statfsSync, writeFileSync } from 'node:fs';
import { loadavg, tmpdir, totalmem } from 'node:os';
import { join } from 'node:path';

import { NATIVE_ENV } from './machine.mjs';
import { logLogPlot, slope } from './plot.mjs';
import { build, jsonLines, machine, median, ms, output, table, write } from './results.mjs';
import { ROOT } from './run.mjs';
import { readStl, subdivide, writeStl } from './subdivide.mjs';

/** Table 1 of the paper: facets, cells, seconds of its GPU and of its serial algorithm. `files`: the nearest free model that is there. */
const MODELS = [
  { name: 'model 1, Hubble', files: ['hubble_hst.stl'], n_facets: 19_000, n_cells: 9.6e9, paper: 35.37, serial: 520 },
  {
    name: 'model 2, aircraft',
    files: ['airplane.stl', 'jet_saab_viggen.stl'],
    n_facets: 134_473,
    n_cells: 2.43e11,
    paper: 1130,
    serial: 17_000,
  },
  { name: 'model 3, house', files: ['house.stl'], n_facets: 45_000, n_cells: 1.2e9, paper: 8.45, serial: 120 },
  { name: 'model 4, 64 spheres', files: [], n_facets: 94_976, n_cells: 4.1e9, paper: 61.23, serial: 890 },
];
const BACKENDS = ['cpu', 'gpu'];
/** Flags of all cells must leave the machine room for the rest. */
const SHARE_OF_MEMORY = 0.45;
/** Files larger than this are written once, by one backend. */
const LARGE_FILE = 8e9;

/** What all parts need: programs, models by name, options. */
class Bench {
  constructor({ models, quick, runs }, scratch) {
    this.folder = models ?? process.env.HEXCAST_MODELS;
    this.scratch = scratch;
    this.quick = quick;
    this.runs = runs;
    this.hexcast = build(['bin', 'hexcast']);
    this.table = build(['bench', 'table']);
    this.spheres = join(scratch, 'spheres.stl');
    output(this.table, ['--spheres', this.spheres]);
  }

  /** A number of cells, a thousandth of it where quick. */
  cells(n_cells) {
    return this.quick ? n_cells / 1000 : n_cells;
  }

  /** The report of one mesh in a process of its own. */
  mesh(file, args, backend) {
    const start = performance.now();
    const text = output(this.hexcast, ['mesh', file, ...args, '--hash', 'never', '--backend', backend, '--json'], NATIVE_ENV);
    return { ...JSON.parse(text), process_s: (performance.now() - start) / 1000 };
  }

  /** The report of several meshes, with the median of each of their seconds. */
  meshes(file, args, backend, runs = this.runs) {
    const reports = Array.from({ length: runs }, () => this.mesh(file, args, backend));
    const seconds = Object.fromEntries(
      Object.keys(reports[0].seconds).map((part) => [part, median(reports.map((r) => r.seconds[part]))]),
    );
    return { ...reports[0], seconds, process_s: median(reports.map((r) => r.process_s)) };
  }

  /** `--cells` that comes nearest to a number of cells. */
  cellsFor(file, n_cells) {
    const count = (n) => JSON.parse(output(this.hexcast, ['estimate', file, '--cells', String(n), '--json'], NATIVE_ENV)).cells;
    let n = Math.round(100 * Math.cbrt(n_cells / count(100)));
    for (let step = 0; step < 3; step++) n = Math.max(2, Math.round(n * Math.cbrt(n_cells / count(n))));
    const miss = (n) => Math.abs(count(n) - n_cells);
    return [n - 1, n, n + 1].reduce((best, next) => (miss(next) < miss(best) ? next : best));
  }

  /** A model of the paper with its number of facets, or null where it is missing: file, and what was done to it. */
  model({ files, n_facets }) {
    if (files.length === 0) return { file: this.spheres, origin: 'made by the bench' };
    const name = this.folder && files.find((candidate) => isFile(join(this.folder, candidate)));
    if (!name) return null;
    const corners = readStl(join(this.folder, name));
    const n_real = corners.length / 9;
    const file = join(this.scratch, name);
    writeStl(file, subdivide(corners, n_facets));
    return { file, origin: `${name}, ${n_real >= n_facets ? 'as it is' : `${count(n_real)} subdivided`}` };
  }
}

/** Table 1: columns, flags in memory, flags in a file. */
function table1(bench) {
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
  const head = [
    'model',
    'file',
    'backend',
    'facets',
    'cells',
    'rays',
    'crossings',
    'columns, s',
    'process, s',
    'the paper, GPU, s',
    'ratio',
    'peak host, MiB',
  ];
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

/** 1e12 cells of model 4 on the CPU backend. */
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

/** Fig. 14: seconds against cells of model 4. */
function fig14(bench) {
  const ours = { cpu: [], gpu: [] };
  const sizes = [1e9, 4.1e9, 1.2e10];
  for (const n_cells of sizes) {
    const args = ['--cells', String(bench.cellsFor(bench.spheres, bench.cells(n_cells)))];
    for (const backend of BACKENDS) {
      const report = bench.meshes(bench.spheres, args, backend);
      ours[backend].push([report.cells, report.seconds.total]);
    }
  }
  const title = 'Fig. 14: seconds to columns against cells, 94,976 facets';
  return figure(bench, 'fig14', { title, x: 'cells', ours, times: sizes.map((n) => n / 4.1e9), from: bench.cells(4.1e9) });
}

/** Fig. 15: seconds against facets of model 4 at equal cells. */
function fig15(bench) {
  const ours = { cpu: [], gpu: [] };
  const times = [1, 2, 4, 8, 16];
  const corners = readStl(bench.spheres);
  const n_cells = bench.cells(4.1e9);
  const args = ['--cells', String(bench.cellsFor(bench.spheres, n_cells))];
  for (const factor of times) {
    const file = join(bench.scratch, 'facets.stl');
    writeStl(file, subdivide(corners, (factor * corners.length) / 9));
    for (const backend of BACKENDS) {
      const report = bench.meshes(file, args, backend);
      ours[backend].push([report.geometries[0].facets, report.seconds.total]);
    }
  }
  const title = `Fig. 15: seconds to columns against facets, ${power(n_cells, 1)} cells`;
  return figure(bench, 'fig15', { title, x: 'facets', ours, times, from: MODELS[3].n_facets });
}

/** Writes a plot and returns its part of the results. The paper's lines go through its time for model 4, `from` on the x axis. */
function figure(bench, name, { title, x, ours, times, from }) {
  const slopes = BACKENDS.map((backend) => slope(ours[backend]).toFixed(2));
  const scale = bench.cells(1);
  const theirs = [
    ['GPU', MODELS[3].paper],
    ['serial', MODELS[3].serial],
  ].map(([algorithm, seconds]) => ({
    name: `the paper, ${algorithm}: ${seconds} s in its Table 1; "proportional to" ${x}: slope 1`,
    points: times.map((factor) => [factor * from, factor * scale * seconds]),
    marked: [[from, scale * seconds]],
  }));
  const series = BACKENDS.map((backend, k) => ({
    name: `hexcast, ${backend.toUpperCase()} backend: slope ${slopes[k]}`,
    points: ours[backend],
  }));
  const svg = logLogPlot({ title, x, y: 'seconds', series: [...series, ...theirs] });
  writeFileSync(join(ROOT, bench.quick ? 'target' : 'docs', `${name}.svg`), svg);
  const all = [ours.cpu, ours.gpu, ...theirs.map((one) => one.points)];
  const rows = ours.cpu.map(([at], k) => [power(at, 2), ...all.map((points) => seconds(points[k][1]))]);
  return [
    `## Fig. ${name.slice(3)} of the paper\n`,
    `![${title}](../docs/${name}.svg)\n`,
    table([x, 'CPU, s', 'GPU, s', 'the paper, GPU, s', 'the paper, serial, s'], [...rows, ['slope', ...slopes, 1, 1]]),
    '\nOf the paper each column is the one number that its text has, for model 4, scaled by what it says of the others: proportional.',
  ].join('\n');
}

/** Seconds against cells at equal rays: more cells along the rays only. */
function depth(bench) {
  const across = bench.quick ? 100 : 1000;
  const rows = [];
  for (const backend of BACKENDS) {
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

/** The traditional algorithm on one core beside both backends, from the file to flags in memory. */
function serial(bench) {
  const rows = [];
  for (const n of bench.quick ? [64, 128] : [256, 512, 1024]) {
    const args = ['--file', bench.spheres, '--cells', String(n), '--runs', String(bench.runs), '--serial'];
    const lines = jsonLines(output(bench.table, args, NATIVE_ENV));
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

const PARTS = { table1, trillion, fig14, fig15, depth, serial };

/** Runs the named parts, or all, and writes them. */
export function paper(names, options) {
  const unknown = names.find((name) => !(name in PARTS));
  if (unknown) throw new Error(`no part is named ${unknown}: ${Object.keys(PARTS).join(', ')}`);
  const scratch = mkdtempSync(join(tmpdir(), 'hexcast-paper-'));
  try {
    const load = loadavg()[0];
    const bench = new Bench(options, scratch);
    const { adapter } = bench.mesh(join(ROOT, 'tests/fixtures/spot.stl'), ['--cells', '16'], 'gpu');
    const facts = [
      ...machine(adapter, load),
      `* Medians of ${bench.runs} processes; 10^12 cells and files over 8 GB once.`,
      '',
    ].join('\n');
    for (const name of names.length ? names : Object.keys(PARTS)) {
      const text = `${PARTS[name](bench)}\n\n${facts}`;
      if (!bench.quick) write(name, text);
      console.log(text);
    }
  } finally {
    rmSync(scratch, { recursive: true });
  }
}

const isFile = (path) => statSync(path, { throwIfNoEntry: false })?.isFile() ?? false;
const power = (number, digits) => number.toExponential(digits).replace('e+', 'e');
const count = (number) => number.toLocaleString('en');
const seconds = (number) => (number < 100 ? number.toPrecision(3) : number.toFixed(0));
const ratio = (theirs, ours) => `${(theirs / ours).toFixed(theirs / ours < 100 ? 1 : 0)}x`;

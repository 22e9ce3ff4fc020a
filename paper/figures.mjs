// Figures 14 and 15 of the paper, for paper.mjs.

import { writeFileSync } from 'node:fs';
import { join } from 'node:path';

import { table } from '../benches/results.mjs';
import { ROOT } from '../scripts/run.mjs';
import { logLogPlot, slope } from './plot.mjs';
import { BACKENDS, MODELS, power, seconds } from './runs.mjs';
import { readStl, subdivide, writeStl } from './subdivide.mjs';

/** @typedef {import('./runs.mjs').Bench} Bench @typedef {Record<'cpu' | 'gpu', import('./plot.mjs').Point[]>} Ours */

/** Fig. 14: seconds against cells of model 4. @param {Bench} bench */
export function fig14(bench) {
  /** @type {Ours} */
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

/** Fig. 15: seconds against facets of model 4 at equal cells. @param {Bench} bench */
export function fig15(bench) {
  /** @type {Ours} */
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

/**
 * Writes a plot and returns its part of the results. The paper's lines go through its time for model 4, `from` on the x axis.
 *
 * @param {Bench} bench
 * @param {string} name
 * @param {{ title: string, x: string, ours: Ours, times: number[], from: number }} what
 */
function figure(bench, name, { title, x, ours, times, from }) {
  const slopes = BACKENDS.map((backend) => slope(ours[backend]).toFixed(2));
  const scale = bench.cells(1);
  /** @type {[string, number][]} */
  const algorithms = [
    ['GPU', MODELS[3].paper],
    ['serial', MODELS[3].serial],
  ];
  /** @type {import('./plot.mjs').Series[]} */
  const theirs = algorithms.map(([algorithm, seconds]) => ({
    name: `the paper, ${algorithm}: ${seconds} s in its Table 1; "proportional to" ${x}: slope 1`,
    points: times.map((factor) => [factor * from, factor * scale * seconds]),
    marked: [[from, scale * seconds]],
  }));
  const series = BACKENDS.map((backend, k) => ({
    name: `hexcast, ${backend.toUpperCase()} backend: slope ${slopes[k]}`,
    points: ours[backend],
  }));
  const svg = logLogPlot({ title, x, y: 'seconds', series: [...series, ...theirs] });
  writeFileSync(join(ROOT, bench.quick ? 'target' : 'paper', `${name}.svg`), svg);
  const all = [ours.cpu, ours.gpu, ...theirs.map((one) => one.points)];
  const rows = ours.cpu.map(([at], k) => [power(at, 2), ...all.map((points) => seconds(points[k][1]))]);
  return [
    `## Fig. ${name.slice(3)} of the paper\n`,
    `![${title}](${name}.svg)\n`,
    table([x, 'CPU, s', 'GPU, s', 'the paper, GPU, s', 'the paper, serial, s'], [...rows, ['slope', ...slopes, 1, 1]]),
    '\nOf the paper each column is the one number that its text has, for model 4, scaled by what it says of the others: proportional.',
  ].join('\n');
}

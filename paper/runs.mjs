// What paper.mjs measures with: the programs, the models, and meshes in processes of their own.

import { statSync } from 'node:fs';
import { join } from 'node:path';

import { median, output, programs } from '../benches/results.mjs';
import { readStl, subdivide, writeStl } from './subdivide.mjs';

/**
 * @typedef {import('../benches/results.mjs').Report & { process_s: number }} Report
 * @typedef {{ name: string, files: string[], n_facets: number, n_cells: number, paper: number, serial: number }} Model of the paper
 */

/**
 * Table 1 of the paper: facets, cells, seconds of its GPU and of its serial algorithm. `files`: the nearest free model that is
 * there.
 *
 * @type {Model[]}
 */
export const MODELS = [
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
/** @type {('cpu' | 'gpu')[]} */
export const BACKENDS = ['cpu', 'gpu'];
/** What all parts need: programs, models by name, options. */
export class Bench {
  /** @param {{ models?: string, quick: boolean, runs: number }} options @param {string} scratch a folder */
  constructor({ models, quick, runs }, scratch) {
    this.folder = models ?? process.env.HEXCAST_MODELS;
    this.scratch = scratch;
    this.quick = quick;
    this.runs = runs;
    const { command, stages, spheres } = programs(scratch);
    this.command = command;
    this.stages = stages;
    this.spheres = spheres;
  }

  /** A number of cells, a thousandth of it where quick. @param {number} n_cells */
  cells(n_cells) {
    return this.quick ? n_cells / 1000 : n_cells;
  }

  /**
   * The report of one mesh in a process of its own.
   *
   * @param {string} file
   * @param {string[]} args
   * @param {string} backend
   * @returns {Report}
   */
  mesh(file, args, backend) {
    const start = performance.now();
    const text = output(this.command, ['mesh', file, ...args, '--backend', backend, '--json']);
    return { ...JSON.parse(text), process_s: (performance.now() - start) / 1000 };
  }

  /**
   * The report of several meshes, with the median of each of their seconds.
   *
   * @param {string} file
   * @param {string[]} args
   * @param {string} backend
   */
  meshes(file, args, backend, runs = this.runs) {
    const reports = Array.from({ length: runs }, () => this.mesh(file, args, backend));
    const seconds = Object.fromEntries(
      Object.keys(reports[0].seconds).map((part) => [part, median(reports.map((r) => r.seconds[part]))]),
    );
    return { ...reports[0], seconds, process_s: median(reports.map((r) => r.process_s)) };
  }

  /** `--cells` that comes nearest to a number of cells. @param {string} file @param {number} n_cells */
  cellsFor(file, n_cells) {
    const count = (/** @type {number} */ n) =>
      JSON.parse(output(this.command, ['estimate', file, '--cells', String(n), '--json'])).cells;
    let n = Math.round(100 * Math.cbrt(n_cells / count(100)));
    for (let step = 0; step < 3; step++) n = Math.max(2, Math.round(n * Math.cbrt(n_cells / count(n))));
    const miss = (/** @type {number} */ n) => Math.abs(count(n) - n_cells);
    return [n - 1, n, n + 1].reduce((best, next) => (miss(next) < miss(best) ? next : best));
  }

  /** A model of the paper with its number of facets, or null where it is missing: file, and what was done to it. @param {Model} wanted */
  model({ files, n_facets }) {
    if (files.length === 0) return { file: this.spheres, origin: 'made by the bench' };
    const { folder } = this;
    const name = folder && files.find((candidate) => isFile(join(folder, candidate)));
    if (!folder || !name) return null;
    const corners = readStl(join(folder, name));
    const n_real = corners.length / 9;
    const file = join(this.scratch, name);
    writeStl(file, subdivide(corners, n_facets));
    return { file, origin: `${name}, ${n_real >= n_facets ? 'as it is' : `${count(n_real)} subdivided`}` };
  }
}

/** @param {string} path */
const isFile = (path) => statSync(path, { throwIfNoEntry: false })?.isFile() ?? false;
/** @param {number} number */
export const count = (number) => number.toLocaleString('en');
/** @param {number} number @param {number} digits */
export const power = (number, digits) => number.toExponential(digits).replace('e+', 'e');
/** @param {number} number */
export const seconds = (number) => (number < 100 ? number.toPrecision(3) : number.toFixed(0));
/** @param {number} theirs @param {number} ours */
export const ratio = (theirs, ours) => `${(theirs / ours).toFixed(theirs / ours < 100 ? 1 : 0)}x`;

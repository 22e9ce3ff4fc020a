// hexcast beside other programs that solve: openEMS, gprMax, Meep and OpenFOAM with snappyHexMesh, for bench.mjs; benches/solvers has the problems.

import path from 'node:path';

import { ensure } from '../scripts/machine.mjs';
import { ROOT, ask } from '../scripts/run.mjs';
import { ensureSolvers } from '../scripts/solvers.mjs';
import { build, jsonLines, output, table } from './results.mjs';

/**
 * What `compare.py` prints a row: how far the answer is off, and what processes took.
 *
 * @typedef {{ s: number, mib: number }} Cost
 * @typedef {{ problem: string, program: string, cells: number, off: number, mesh: Cost, run: Cost }} Row
 */

/** @type {Record<string, string>} */
const HEADINGS = {
  ball: 'A ball in metal: TM011, cells a diameter',
  guide: 'A round waveguide: TE11, cells a diameter',
  rods: 'A lattice of dielectric rods: the first mode, cells a lattice constant',
  boltzmann: 'A pipe by lattice Boltzmann: speeds, cells a diameter',
  pipe: 'A pipe in OpenFOAM: flow, cells a diameter',
};

/** @param {number} off */
const share = (off) => `${off < 0 ? '-' : '+'}${Math.abs(off).toExponential(1)}`;

/** @param {Cost} cost */
const cost = ({ s, mib }) => [s.toFixed(s < 1 ? 2 : 1), mib.toFixed(0)];

/** The tables of all problems. @param {Row[]} rows */
export function solversTables(rows) {
  const head = ['program', 'cells', 'off by', 'mesh, s', 'MiB', 'run, s', 'MiB'];
  return Object.entries(HEADINGS).map(([problem, heading]) => {
    const found = rows.filter((row) => row.problem === problem);
    const programs = [...new Set(found.map(({ program }) => program))];
    const ordered = programs.flatMap((program) => found.filter((row) => row.program === program));
    const lines = ordered.map(({ program, cells, off, mesh, run }) => [program, cells, share(off), ...cost(mesh), ...cost(run)]);
    return `### ${heading}\n\n${table(head, lines)}`;
  });
}

/** Versions of the programs, as Debian and PyPI have them. @param {string} python */
function versions(python) {
  const debian = ['openems', 'python3-meep', 'openfoam'].map(
    (name) => `${name} ${ask('dpkg-query', ['-W', '-f', `\${Version}`, name]) ?? 'not of Debian'}`,
  );
  const ofPython = ask(python, [
    '-c',
    'from importlib.metadata import version as v; print(*(n + " " + v(n) for n in ("gprMax", "numpy", "scipy")), sep=", ")',
  ]);
  return `* ${debian.join(', ')}, ${ofPython}.`;
}

/** Solves all problems by all programs. @param {{ folder: string, quick: boolean }} bench */
export async function benchSolvers({ folder, quick }) {
  await ensure('linker', 'python', 'openfoam', 'openems', 'meep');
  await ensureSolvers();
  const python = path.join(ROOT, '.tools/solvers/bin/python');
  const command = process.env.HEXCAST_COMMAND ?? build(['bin', 'hexcast']);
  const rows = jsonLines(output(python, ['benches/solvers/compare.py', command, folder, ...(quick ? ['--quick'] : [])]));
  return { adapter: '', text: [versions(python), ...solversTables(rows)].join('\n\n') };
}

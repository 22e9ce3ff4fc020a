// The C library: built, and used from C, from C on four ranks of MPI, and from Fortran.

import { mkdirSync, readFileSync, rmSync } from 'node:fs';
import path from 'node:path';

import { buildNative } from './native.mjs';
import { ROOT, run } from './run.mjs';

const FOLDER = path.join(ROOT, 'target/capi');
const SPOT = path.join(ROOT, 'tests/fixtures/spot.stl');
/** Numbers of cells that two axes do not share, so that a wrong order of axes shows. */
const DIMS = [100, 80, 60];
/** Root may start ranks, and more of them than cores, in this environment. */
const MPI_ENV = { OMPI_ALLOW_RUN_AS_ROOT: '1', OMPI_ALLOW_RUN_AS_ROOT_CONFIRM: '1', OMPI_MCA_rmaps_base_oversubscribe: '1' };

/** Compiles a program against the header and the shared library. @param {string} compiler @param {string} source below `capi/` @returns {Promise<string>} its path */
async function compiled(compiler, source) {
  const { name, ext } = path.parse(source);
  const program = path.join(FOLDER, name);
  const standard = ext === '.c' ? ['-std=c11', `-I${path.join(ROOT, 'capi/include')}`] : [`-J${FOLDER}`];
  const warnings = ['-Wall', '-Wextra', '-Werror', '-g'];
  const folder = path.dirname(await buildNative());
  const library = [`-L${folder}`, '-lhexcast_c', `-Wl,-rpath,${folder}`, '-lpthread'];
  mkdirSync(FOLDER, { recursive: true });
  await run(compiler, [...standard, ...warnings, path.join(ROOT, 'capi', source), '-o', program, ...library]);
  return program;
}

/** Runs the C test, alone and under valgrind. @returns {Promise<string>} how many checks passed */
export async function testC() {
  const program = await compiled('cc', 'tests/test.c');
  const printed = await run(program, []);
  const memory = ['--quiet', '--error-exitcode=1', '--leak-check=full', '--errors-for-leak-kinds=definite'];
  await run('valgrind', [...memory, '--show-leak-kinds=definite', program]);
  // C++ reads the header, too
  await run('c++', ['-Wall', '-Wextra', '-Werror', '-fsyntax-only', '-x', 'c++', path.join(ROOT, 'capi/include/hexcast.h')]);
  const [, n_checks] = /: (\d+) checks passed$/.exec(printed.trimEnd()) ?? [];
  if (!n_checks) throw Object.assign(new Error('the C test did not say how many checks passed'), { output: printed });
  return `${n_checks} checks`;
}

/** Runs the examples, and compares them with each other and with the undivided mesh of the command. */
export async function testExamples() {
  equal(await run(await compiled('cc', 'examples/box.c'), []), '14 x 14 x 14 cells, 1000 inside\n');
  const whole = path.join(FOLDER, 'whole.raw');
  const command = ['mesh', SPOT, '--dims', DIMS.join(','), '--backend', 'cpu', '-o', whole];
  await run(await buildNative(), command);
  const flags = readFileSync(whole);
  const n_inside = (/** @type {Buffer} */ some) => some.filter((flag) => flag !== 0).length;

  const boxes = path.join(FOLDER, 'boxes.raw');
  // ranks write to a file that is there, and leave the rest of it
  rmSync(boxes, { force: true });
  const ranks = ['-n', '4', await compiled('mpicc', 'examples/mpi.c'), SPOT, ...DIMS.map(String), boxes];
  equal(await run('mpirun', ranks, { env: MPI_ENV }), `4 ranks, ${n_inside(flags)} cells inside\n`);
  if (!readFileSync(boxes).equals(flags)) throw new Error('the boxes of the ranks are not the whole mesh');

  const window = await compiled('gfortran', 'examples/window.f90');
  const lower = flags.subarray(0, flags.length / 2);
  equal(await run(window, [SPOT, ...DIMS.map(String)]), `${n_inside(lower)} cells inside\n`);
  return `${flags.length} cells on 4 ranks`;
}

/** @param {string} found @param {string} expected */
function equal(found, expected) {
  if (found !== expected)
    throw Object.assign(new Error(`an example did not print ${JSON.stringify(expected)}`), { output: found });
}

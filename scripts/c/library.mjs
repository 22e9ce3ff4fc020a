// The C library: installed, found by pkg-config, and used from C, from C on four ranks of MPI, and from Fortran.

import { mkdirSync, readFileSync, readdirSync, renameSync, rmSync, statSync } from 'node:fs';
import path from 'node:path';

import { buildNative, commandPath } from '../native.mjs';
import { ROOT, ask, run } from '../run.mjs';

/** Where all is built and installed. */
export const FOLDER = path.join(ROOT, 'target/capi');
/** The crate. */
export const CAPI = path.join(ROOT, 'capi');
/** A closed surface. */
export const SPOT = path.join(ROOT, 'tests/fixtures/spot.stl');
/** Numbers of cells that two axes do not share, so that a wrong order of axes shows. */
const DIMS = [100, 80, 60];
/** Root may start ranks, and more of them than cores, in this environment. */
const MPI_ENV = { OMPI_ALLOW_RUN_AS_ROOT: '1', OMPI_ALLOW_RUN_AS_ROOT_CONFIRM: '1', OMPI_MCA_rmaps_base_oversubscribe: '1' };
const WARNINGS = ['-Wall', '-Wextra', '-Werror'];

/** @type {Promise<string> | null} */
let installed = null;

/** Installs the library, once in a process, and moves it, as nothing may name the place. @returns {Promise<string>} the prefix */
export function prefix() {
  installed ??= install();
  return installed;
}

/** Takes a library that is installed already, such as one of an archive. @param {string} folder its prefix @param {string} libdir */
export function usePrefix(folder, libdir) {
  process.env.PKG_CONFIG_PATH = path.join(folder, libdir, 'pkgconfig');
  installed = Promise.resolve(folder);
}

async function install() {
  const built = path.dirname(await buildNative());
  const [first, moved] = ['first', 'prefix'].map((name) => path.join(FOLDER, name));
  fresh(path.basename(first));
  rmSync(moved, { recursive: true, force: true });
  const libdir = 'lib/of-a-machine';
  await run('sh', [path.join(CAPI, 'install.sh'), '--prefix', first, '--libdir', libdir, '--built', built]);
  renameSync(first, moved);
  usePrefix(moved, libdir);
  return moved;
}

/** An empty folder of a name. @param {string} name @returns {string} its path */
export function fresh(name) {
  const folder = path.join(FOLDER, name);
  rmSync(folder, { recursive: true, force: true });
  mkdirSync(folder, { recursive: true });
  return folder;
}

/** What pkg-config says of the installed library. @param {string[]} asked @returns {string[]} */
export function pkgConfig(...asked) {
  const said = ask('pkg-config', [...asked, 'hexcast']);
  if (said === null) throw new Error(`pkg-config ${asked.join(' ')} hexcast failed`);
  return said.split(/\s+/).filter(Boolean);
}

/** Compiles a program against the installed library. @param {string} compiler @param {string} source below `capi/` @returns {Promise<string>} its path */
export async function compiled(compiler, source) {
  await prefix();
  const { name, ext } = path.parse(source);
  const program = path.join(FOLDER, name);
  const standard = ext === '.c' ? ['-std=c11'] : [`-J${FOLDER}`, ...pkgConfig('--variable=fortran_source')];
  const library = [...pkgConfig('--cflags', '--libs'), `-Wl,-rpath,${pkgConfig('--variable=libdir')}`];
  await run(compiler, [...standard, ...WARNINGS, '-g', path.join(CAPI, source), '-o', program, ...library]);
  return program;
}

/** Runs the C test, alone and under valgrind. @returns {Promise<string>} how many checks passed */
export async function testC() {
  const program = await compiled('cc', 'tests/test.c');
  const cwd = fresh('empty');
  const printed = await run(program, [], { cwd });
  if (readdirSync(cwd).length > 0) throw new Error(`what could not be written left ${readdirSync(cwd)}`);
  const memory = ['--quiet', '--error-exitcode=1', '--leak-check=full', '--errors-for-leak-kinds=definite'];
  await run('valgrind', [...memory, '--show-leak-kinds=definite', program], { cwd });
  const header = path.join(await prefix(), 'include/hexcast.h');
  for (const [compiler, language, standard] of [
    ['cc', 'c', 'c11'],
    ['c++', 'c++', 'c++17'],
  ])
    await run(compiler, [...WARNINGS, `-std=${standard}`, '-pedantic', '-fsyntax-only', '-x', language, header]);
  const [, n_checks] = /: (\d+) checks passed$/.exec(printed.trimEnd()) ?? [];
  if (!n_checks) throw Object.assign(new Error('the C test did not say how many checks passed'), { output: printed });
  return `${n_checks} checks`;
}

/** Runs the examples, and compares them with each other and with the undivided mesh of the command. */
export async function testExamples() {
  equal(await run(await compiled('cc', 'examples/box.c'), []), '14 x 14 x 14 cells, 1000 inside\n');
  const whole = path.join(FOLDER, 'whole.raw');
  const command = ['mesh', SPOT, '--dims', DIMS.join(','), '--backend', 'cpu', '-o', whole];
  await run(await commandPath(), command);
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

/** Holds what a program printed to what is expected. @param {string} found @param {string} expected */
export function equal(found, expected) {
  if (found !== expected) throw Object.assign(new Error(`what is there is not ${JSON.stringify(expected)}`), { output: found });
}

/** The files below a folder, by their names. @param {string} folder */
export function filesOf(folder) {
  const names = readdirSync(folder, { recursive: true, encoding: 'utf8' }).sort();
  return names.filter((name) => statSync(path.join(folder, name)).isFile());
}

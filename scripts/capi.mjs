// The C library: installed, found by pkg-config and CMake, and used from C, from C++, from C on four ranks of MPI, and from Fortran.

import { cpSync, mkdirSync, mkdtempSync, readFileSync, readdirSync, renameSync, rmSync, statSync, writeFileSync } from 'node:fs';
import path from 'node:path';

import { buildNative } from './native.mjs';
import { ROOT, ask, run } from './run.mjs';

const FOLDER = path.join(ROOT, 'target/capi');
const CAPI = path.join(ROOT, 'capi');
const SPOT = path.join(ROOT, 'tests/fixtures/spot.stl');
/** Numbers of cells that two axes do not share, so that a wrong order of axes shows. */
const DIMS = [100, 80, 60];
/** Root may start ranks, and more of them than cores, in this environment. */
const MPI_ENV = { OMPI_ALLOW_RUN_AS_ROOT: '1', OMPI_ALLOW_RUN_AS_ROOT_CONFIRM: '1', OMPI_MCA_rmaps_base_oversubscribe: '1' };
const WARNINGS = ['-Wall', '-Wextra', '-Werror'];

/** @type {Promise<string> | null} */
let installed = null;

/** Installs the library, once in a process, and moves it, as nothing may name the place. @returns {Promise<string>} the prefix */
function prefix() {
  installed ??= install();
  return installed;
}

async function install() {
  const built = path.dirname(await buildNative());
  const [first, moved] = ['first', 'prefix'].map((name) => path.join(FOLDER, name));
  for (const folder of [first, moved]) rmSync(folder, { recursive: true, force: true });
  mkdirSync(FOLDER, { recursive: true });
  const libdir = 'lib/of-a-machine';
  await run('sh', [path.join(CAPI, 'install.sh'), '--prefix', first, '--libdir', libdir, '--built', built]);
  renameSync(first, moved);
  process.env.PKG_CONFIG_PATH = path.join(moved, libdir, 'pkgconfig');
  return moved;
}

/** What pkg-config says of the installed library. @param {string[]} asked @returns {string[]} */
function pkgConfig(...asked) {
  const said = ask('pkg-config', [...asked, 'hexcast']);
  if (said === null) throw new Error(`pkg-config ${asked.join(' ')} hexcast failed`);
  return said.split(/\s+/).filter(Boolean);
}

/** Compiles a program against the installed library. @param {string} compiler @param {string} source below `capi/` @returns {Promise<string>} its path */
async function compiled(compiler, source) {
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
  const cwd = mkdtempSync(path.join(FOLDER, 'empty-'));
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

/** Builds programs by CMake, and by pkg-config with the static library, and runs them. */
export async function testInstall() {
  const folder = await prefix();
  const build = path.join(FOLDER, 'cmake');
  rmSync(build, { recursive: true, force: true });
  const project = path.join(CAPI, 'tests/cmake');
  const libdir = pkgConfig('--variable=libdir')[0];
  const found = `-Dhexcast_DIR=${path.join(libdir, 'cmake/hexcast')}`;
  await run('cmake', ['-S', project, '-B', build, found]);
  await run('cmake', ['--build', build]);
  const box = '14 x 14 x 14 cells, 1000 inside\n';
  for (const name of ['box_shared', 'box_static']) equal(await run(path.join(build, name), []), box);
  equal(await run(path.join(build, 'version'), []), `${pkgConfig('--modversion')[0]}\n`);
  await testRuns(path.join(build, 'runs'));
  await testRuns(await compiled('gfortran', 'examples/runs.f90'));

  const program = path.join(FOLDER, 'box_of_archive');
  // the archive in place of the shared library of the same name
  const library = pkgConfig('--static', '--libs').map((word) => (word === '-lhexcast' ? `${libdir}/libhexcast.a` : word));
  await run('cc', ['-std=c11', path.join(CAPI, 'examples/box.c'), '-o', program, ...pkgConfig('--cflags'), ...library]);
  equal(await run(program, []), box);
  const needs = async (/** @type {string} */ file) =>
    /NEEDED.*hexcast\.so\.(\d+\.\d+)\]/.exec(await run('readelf', ['-d', file]))?.[1];
  const [shared, archive] = [await needs(path.join(build, 'box_shared')), await needs(program)];
  if (shared !== pkgConfig('--modversion')[0].replace(/\.\d+$/, '') || archive)
    throw new Error(`linked with ${shared} and ${archive}`);

  // versions that fit, and that do not
  for (const [wanted, fits] of /** @type {[string, boolean][]} */ ([
    ['0.1.0', true],
    ['0', true],
    ['0.2', false],
    ['0.1.1', false],
    ['1', false],
  ])) {
    const asking = path.join(FOLDER, 'asking');
    rmSync(asking, { recursive: true, force: true });
    mkdirSync(asking);
    const text = `cmake_minimum_required(VERSION 3.16)\nproject(a LANGUAGES C)\nfind_package(hexcast ${wanted} REQUIRED)\n`;
    writeFileSync(path.join(asking, 'CMakeLists.txt'), text);
    const done = await run('cmake', ['-S', asking, '-B', path.join(asking, 'build'), found]).then(
      () => true,
      () => false,
    );
    if (done !== fits) throw new Error(`find_package(hexcast ${wanted}) ${done ? 'succeeded' : 'failed'}`);
  }
  return `${readdirSync(folder).length} folders of a prefix that was moved`;
}

/** Runs the example that counts by runs, and has the command read what it writes. @param {string} program */
async function testRuns(program) {
  const file = path.join(FOLDER, 'cube.hxc');
  equal(await run(program, [file]), '1000 cells inside, 1744 outside\n');
  const [{ cells, flags }] = JSON.parse(await run(await buildNative(), ['info', file, '--json']));
  const read = [cells, flags.length, flags[0].flag, flags[0].cells];
  if (String(read) !== '2744,1,7,1000') throw new Error(`the command reads ${read}`);
}

/** Files that C writes, and options of both: each ending of the command. @type {[string, string, string[]][]} */
const FILES = [
  ...['raw', 'npy', 'npz', 'vti', 'vtr', 'hxc', 'zarr', 'zarr.zip'].map(plain),
  ...['foam', 'inp', 'msh', 'xdmf', 'csx.xml', 'in', 'nrrd', 'vox', 'binvox'].map(plain),
  ['case/constant/polyMesh', '', []],
  ['geometry.xml', '', []],
  ['plain.vti', '{"compress": 0}', ['--compress=none']],
  ['small.hxc', '{"compress": 9}', ['--compress=9']],
  ['bits.npy', '{"bits": true}', ['--bits']],
  ['turned.raw', '{"axis_order": "xyz", "map": {"0": 3, "7": 0}}', ['--axis-order', 'xyz', '--map', '0=3,7=0']],
  ['air.msh', '{"export_flags": [0], "ascii": true}', ['--export-flags', '0', '--ascii']],
  ['walls.foam', '{"patches": "solid", "open_patches": ["cow"]}', ['--patches', 'solid', '--open-patches', 'cow']],
];

/** @param {string} ending @returns {[string, string, string[]]} */
function plain(ending) {
  return [`mesh_${ending.replace('.', '_')}/mesh.${ending}`, '', []];
}

/** Compares the files of hexcast_mesh_write with those of the command, byte for byte. */
export async function testFiles() {
  const program = await compiled('cc', 'tests/files.c');
  const command = await buildNative();
  const [ours, theirs] = ['c', 'command'].map((name) => path.join(FOLDER, 'written', name));
  rmSync(path.dirname(ours), { recursive: true, force: true });
  const material = { eps_r: 2.5, sigma: 0.5, E: 2e9, nu: 0.3, density: 1000 };
  const geometries = [{ file: SPOT, flag: 7, name: 'cow', material }];
  const background = { name: 'air', material: { eps_r: 1.0006 } };
  const job = {
    geometries,
    background,
    cell_size: 0.05,
    padding: { cells: 1 },
    unit: 'm',
    zarr: { chunks: [16, 16, 16], shards: [32, 32, 32] },
  };
  const jobFile = path.join(FOLDER, 'written.json');
  writeFileSync(jobFile, JSON.stringify(job));
  for (const folder of [ours, theirs])
    FILES.forEach(([name]) => mkdirSync(path.join(folder, path.dirname(name)), { recursive: true }));
  const report = JSON.parse(
    await run(program, [jobFile, ...FILES.flatMap(([name, options]) => [path.join(ours, name), options])]),
  );
  for (const [name, , words] of FILES)
    await run(command, ['mesh', '--job', jobFile, '--backend', 'cpu', '-o', path.join(theirs, name), ...words]);
  const [found, expected] = [ours, theirs].map(filesOf);
  if (String(found) !== String(expected)) throw new Error(`C wrote ${found.join(', ')} and the command ${expected.join(', ')}`);
  const differ = expected.filter((name) => !readFileSync(path.join(ours, name)).equals(readFileSync(path.join(theirs, name))));
  if (differ.length > 0) throw new Error(`these files differ from those of the command: ${differ.join(', ')}`);

  // what the command reads has the flags and the hash of the mesh that C has
  const [raw, again] = [path.join(ours, plain('raw')[0]), path.join(FOLDER, 'written/again.raw')];
  const words = ['--backend', 'cpu', '--json'];
  const { flags_hash } = JSON.parse(await run(command, ['mesh', '--job', jobFile, ...words]));
  if (flags_hash !== report.flags_hash) throw new Error(`the mesh of C has the hash ${report.flags_hash}, not ${flags_hash}`);
  await run(command, ['convert', path.join(ours, plain('hxc')[0]), again]);
  if (!readFileSync(raw).equals(readFileSync(again))) throw new Error('the command reads other flags than C has');
  await run(command, ['verify', path.join(ours, plain('hxc')[0]), '--job', jobFile]);

  // what is there is replaced, and a surface of the mesh is not
  await run(program, [jobFile, ...FILES.flatMap(([name, options]) => [path.join(ours, name), options])]);
  if (String(filesOf(ours)) !== String(expected)) throw new Error('files were left when others were replaced');
  const surface = path.join(FOLDER, 'written/surface.vti');
  cpSync(SPOT, surface);
  writeFileSync(jobFile, JSON.stringify({ geometries: [{ file: surface }], cells: 8 }));
  const said = await run(program, [jobFile, surface, '']).catch((failed) => failed.output);
  if (!said.includes('an input of the mesh') || !readFileSync(surface).equals(readFileSync(SPOT)))
    throw Object.assign(new Error('a surface was written over'), { output: said });
  return `${expected.length} files`;
}

/** The files below a folder, by their names. @param {string} folder */
function filesOf(folder) {
  const names = readdirSync(folder, { recursive: true, encoding: 'utf8' }).sort();
  return names.filter((name) => statSync(path.join(folder, name)).isFile());
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

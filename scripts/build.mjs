// Builds dist/: the package's modules from www/, the library as wasm with its glue, and the page with Vite. A static host serves this
// folder; package.mjs packs it without the page.

import { cpSync, mkdirSync, readFileSync, readdirSync, renameSync, rmSync, statSync, writeFileSync } from 'node:fs';
import path from 'node:path';
import { fileURLToPath } from 'node:url';
import { gzipSync } from 'node:zlib';

import { ensureNodeModules } from './machine.mjs';
import { CommandFailed, ROOT, run } from './run.mjs';
import { compileWasm, ensureBindgen } from './wasm.mjs';

export const DIST = path.join(ROOT, 'dist');
const WWW = path.join(ROOT, 'www');
/** Folders of www/ that are the package's, in dist/ as well. */
export const PACKAGE_FOLDERS = ['cad', 'client', 'core', 'platform', 'protocol', 'types'];
/** The rest of www/ is the page. */
const PACKAGE_FILES = [...readdirSync(WWW).filter((name) => /\.(js|d\.ts)$/.test(name)), ...PACKAGE_FOLDERS];
/**
 * Most kilobytes (1000 bytes) of the wasm file, as it is and after gzip -9. Of these about 95 after gzip read files that are not STL: ZIP,
 * XML, JSON and gzip for 3MF and GLB, and OBJ, OFF and PLY. About 46 are lines of cells that differ in size, links, fractions, staggered grids and
 * slabs beside windows, 16 write archives of NumPy's, 6 compare sizes of cells, 36 write files for solvers (84 as it is),
 * 24 (56) write Zarr stores, fractions of every cell, records of links, and arrays in another order, 27 (57) draw pictures and compare
 * meshes, 79 (187) write HDF5, 8 (24) are findings as data, 64 (157) check shells, add exactly, sum up holes and count memory, 11 examine edges in the cache, 5 are stages of the mesh that wait for each other, 8 (26) sort eight rays at a time, 20 (42) are scenes, 17 (55) find links
 * and fractions strip by strip, 35 (82) measure cut cells exactly, and 20 (48) edges and faces outside metal, 65 (183) cut cells for OpenFOAM and AMReX, 20 (28) add up volumes of cut cells alone; 11 (38) fewer are for reading jobs, which is compiled for size. 139 (370) are the price of speed: the crates that
 * make the cells are compiled at level 3, and take half the time of level z. Compilers differ by some kilobytes.
 */
const LIMITS = { wasm: 3242, gzip: 1367 };
/** The same of the wasm with threads, which has rayon's pool besides. */
const THREADS_LIMITS = { wasm: 3857, gzip: 1472 };
/** The functions of Rust's library that word a panic and never return. */
const PANICS = /^<?(core|alloc)\b.*\b(panicking|panic_\w+|\w+_fail(ed|_rt)?|capacity_overflow|handle_error)\b/;
/** Every browser with WebGPU has these; without them wasm-opt refuses the code. */
const FEATURES =
  '--enable-simd --enable-bulk-memory --enable-nontrapping-float-to-int --enable-sign-ext --enable-mutable-globals --enable-reference-types --enable-multivalue'.split(
    ' ',
  );

/** Builds dist/ and returns a line with the sizes of each wasm; fails where one is too large. */
export async function build() {
  await ensureNodeModules();
  const bindgen = await ensureBindgen();
  const compiled = [await compileWasm(false), await compileWasm(true)];
  rmSync(DIST, { recursive: true, force: true });
  mkdirSync(DIST, { recursive: true });
  for (const name of PACKAGE_FILES) cpSync(path.join(WWW, name), path.join(DIST, name), { recursive: true });
  copyOcct(path.join(DIST, 'cad/occt'));
  const names = ['hexcast_wasm', 'hexcast_threads'];
  for (const [index, name] of names.entries()) {
    await run(bindgen, ['--target', 'web', '--out-dir', DIST, '--out-name', name, compiled[index]]);
  }
  const [one, many] = [nameWasm(), path.join(DIST, 'hexcast_threads_bg.wasm')];
  rmSync(`${many}.d.ts`);
  for (const wasm of [one, many]) {
    await dropPanicMessages(wasm);
    const features = wasm === many ? [...FEATURES, '--enable-threads'] : FEATURES;
    // functions of one generic have like names and like code: side by side they compress better, by 5 kB
    await optimize(wasm, ...features, '-g', '-Oz', '--reorder-functions-by-name');
    await optimize(wasm, ...features, '--strip-debug', '--strip-producers');
  }
  // a process of its own: Vite sets NODE_ENV to "production" for all that follows it, and npm then installs no tools
  const vite = [path.join(ROOT, 'node_modules/vite/bin/vite.js'), 'build', '--logLevel', 'warn'];
  await run(process.execPath, vite);
  await run(process.execPath, [...vite, '--config', path.join(ROOT, 'vite.viewer.mjs')]);
  return `${checkSizes(one, LIMITS)}; ${checkSizes(many, THREADS_LIMITS)}`;
}

/**
 * Puts Open CASCADE into a folder as it was published, with its licences beside it. It is a script of CommonJS, as Node must be told.
 *
 * @param {string} folder
 */
export function copyOcct(folder) {
  const from = path.join(ROOT, 'node_modules/occt-import-js');
  const { version, repository } = JSON.parse(readFileSync(path.join(from, 'package.json'), 'utf8'));
  mkdirSync(folder, { recursive: true });
  const names = ['occt-import-js.js', 'occt-import-js.wasm', 'license.occt-import-js.txt', 'license.occt.txt'];
  for (const name of names) cpSync(path.join(from, 'dist', name), path.join(folder, name));
  writeFileSync(path.join(folder, 'package.json'), '{ "type": "commonjs" }\n');
  const source = `https://github.com/${repository.replace(/^github:/, '')}`;
  const notice = `occt-import-js ${version}, as published on npm, with Open CASCADE Technology in it.
Both are under the GNU Lesser General Public License 2.1, whose texts are beside this file. Source: ${source}
To use another build, put its files in the place of occt-import-js.js and occt-import-js.wasm.
`;
  writeFileSync(path.join(folder, 'NOTICE.txt'), notice);
}

/**
 * Makes the functions that word a panic trap at once, as they do in the end: in wasm nothing shows what they wrote. With them go the
 * arguments of their callers, 12 kB after gzip.
 *
 * @param {string} wasm
 */
async function dropPanicMessages(wasm) {
  // loaded late: a clean clone has no packages until build() has installed them
  const { default: binaryen } = await import('binaryen');
  const module = binaryen.readBinary(readFileSync(wasm));
  const functions = Array.from({ length: module.getNumFunctions() }, (_, index) =>
    binaryen.getFunctionInfo(module.getFunctionByIndex(index)),
  );
  const panics = functions.filter((fn) => fn.module === '' && fn.results === binaryen.none && PANICS.test(fn.name));
  if (panics.length === 0) throw new Error('no function of the wasm has a name of those that panic: see PANICS');
  for (const { name, params, results } of panics) {
    module.removeFunction(name);
    module.addFunction(name, params, results, [], module.unreachable());
  }
  // with names, for what follows
  binaryen.setDebugInfo(true);
  writeFileSync(wasm, module.emitBinary());
  module.dispose();
}

/** Runs wasm-opt on a file; without "-g" it leaves names out. @param {string} wasm @param {string[]} passes */
async function optimize(wasm, ...passes) {
  const program = path.join(ROOT, 'node_modules/binaryen/bin/wasm-opt');
  await run(process.execPath, [program, ...passes, wasm, '-o', wasm]);
}

/** Gives the wasm its public name and returns its path; the glue, which nobody imports by name, keeps its own. */
function nameWasm() {
  const [glue, wasm] = ['hexcast_wasm.js', 'hexcast_bg.wasm'].map((name) => path.join(DIST, name));
  renameSync(path.join(DIST, 'hexcast_wasm_bg.wasm'), wasm);
  rmSync(path.join(DIST, 'hexcast_wasm_bg.wasm.d.ts'));
  writeFileSync(glue, readFileSync(glue, 'utf8').replaceAll('hexcast_wasm_bg.wasm', 'hexcast_bg.wasm'));
  return wasm;
}

/** @param {string} file @param {typeof LIMITS} limits */
function checkSizes(file, limits) {
  const sizes = { wasm: statSync(file).size / 1000, gzip: gzipSync(readFileSync(file), { level: 9 }).length / 1000 };
  const parts = /** @type {const} */ (['wasm', 'gzip']).map((name) => `${name} ${sizes[name].toFixed(1)} kB of ${limits[name]}`);
  const line = `${path.basename(file)}: ${parts.join(', ')}`;
  if (sizes.wasm > limits.wasm || sizes.gzip > limits.gzip) {
    throw new Error(
      `the wasm file is too large: ${line}. See what grew with "npx wasm-opt --func-metrics dist/${path.basename(file)}"`,
    );
  }
  return line;
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  try {
    console.log(`dist/: ${await build()}`);
  } catch (error) {
    if (error instanceof CommandFailed) console.error(error.output);
    console.error(error instanceof Error ? error.message : error);
    process.exitCode = 1;
  }
}

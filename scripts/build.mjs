// Builds dist/: the page and the package's modules from www/, the library as wasm with its glue beside them. The same
// folder is what a static host serves and, without the page, what the npm package ships.

import { cpSync, mkdirSync, readFileSync, renameSync, rmSync, statSync, writeFileSync } from 'node:fs';
import path from 'node:path';
import { fileURLToPath } from 'node:url';
import { gzipSync } from 'node:zlib';

import { ensureNodeModules } from './machine.mjs';
import { ROOT, run } from './run.mjs';
import { copyThree } from './three.mjs';
import { compileWasm, ensureBindgen } from './wasm.mjs';

export const DIST = path.join(ROOT, 'dist');
/** Between the wasm and the package's modules, by wasm-bindgen. */
const GLUE = path.join(DIST, 'hexcast_wasm.js');
/** Most kilobytes (1000 bytes) of the wasm file, as it is and after gzip -9. */
const LIMITS = {
  /** with the standard library compiled for size */
  rebuilt: { wasm: 400, gzip: 160 },
  /** with the one that comes with the compiler */
  prebuilt: { wasm: 430, gzip: 190 },
};
/** Every browser with WebGPU has these; without them wasm-opt would refuse the code or leave it slower. */
const FEATURES = ['simd', 'bulk-memory', 'nontrapping-float-to-int', 'sign-ext', 'mutable-globals', 'reference-types', 'multivalue'];

/** Builds dist/ and returns a line with the sizes; fails where the wasm is too large. */
export async function build() {
  await ensureNodeModules();
  const bindgen = await ensureBindgen();
  const wasm = await compileWasm();
  rmSync(DIST, { recursive: true, force: true });
  mkdirSync(DIST, { recursive: true });
  cpSync(path.join(ROOT, 'www'), DIST, { recursive: true });
  copyThree(path.join(DIST, 'vendor'));
  await run(bindgen, ['--target', 'web', '--no-typescript', '--out-dir', DIST, '--out-name', 'hexcast_wasm', wasm.file]);
  nameWasm();
  shorten(await optimize(path.join(DIST, 'hexcast_bg.wasm')));
  return checkSizes(path.join(DIST, 'hexcast_bg.wasm'), wasm.isRebuilt ? LIMITS.rebuilt : LIMITS.prebuilt);
}

/** Gives the wasm its public name; the glue, which nobody imports by name, keeps its own. */
function nameWasm() {
  renameSync(path.join(DIST, 'hexcast_wasm_bg.wasm'), path.join(DIST, 'hexcast_bg.wasm'));
  writeFileSync(GLUE, readFileSync(GLUE, 'utf8').replaceAll('hexcast_wasm_bg.wasm', 'hexcast_bg.wasm'));
}

/** Optimizes the wasm; returns the names of a letter or two that its imports and exports got. */
async function optimize(file) {
  const features = FEATURES.map((feature) => `--enable-${feature}`);
  const options = [...features, '-O3', '--minify-imports-and-exports-and-modules', file, '-o', file];
  const output = await run(process.execPath, [path.join(ROOT, 'node_modules/binaryen/bin/wasm-opt'), ...options]);
  return JSON.parse(output.slice(output.indexOf('{')));
}

/** Gives the glue the names that the wasm has now; those of wasm-bindgen, with a hash each, are a fortieth of the file. */
function shorten({ imports, exports }) {
  const [given, taken] = [new Map(imports.map(([, name, short]) => [name, short])), new Map(exports)];
  const glue = readFileSync(GLUE, 'utf8')
    .replace(/^( {8})(\w+)(?=: )/gm, (line, indent, name) => (given.has(name) ? indent + given.get(name) : line))
    .replace(/"\.\/hexcast_wasm_bg\.js"(?=: import0)/, 'a')
    .replace(/\bwasm\.(\w+)/g, (use, name) => (taken.has(name) ? `wasm.${taken.get(name)}` : use));
  writeFileSync(GLUE, glue);
}

function checkSizes(file, limits) {
  const sizes = { wasm: statSync(file).size / 1000, gzip: gzipSync(readFileSync(file), { level: 9 }).length / 1000 };
  const line = Object.entries(sizes).map(([name, size]) => `${name} ${size.toFixed(1)} kB of ${limits[name]}`).join(', ');
  if (sizes.wasm > limits.wasm || sizes.gzip > limits.gzip) {
    throw new Error(`the wasm file is too large: ${line}. See what grew with "npx wasm-opt --func-metrics dist/hexcast_bg.wasm"`);
  }
  return line;
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  try {
    console.log(`dist/: ${await build()}`);
  } catch (error) {
    console.error([error.output, error.message].filter(Boolean).join('\n'));
    process.exitCode = 1;
  }
}

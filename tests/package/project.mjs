// An empty project with the packed tarball installed, and what the native command makes of the same job.

import { execFileSync, spawnSync } from 'node:child_process';
import { createHash } from 'node:crypto';
import { cpSync, mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';

import { commandPath } from '../../scripts/native.mjs';
import { pack } from '../../scripts/package.mjs';
import { ROOT } from '../../scripts/run.mjs';
import { boxBetween } from '../e2e/open_box.mjs';

/** The native command. */
export const COMMAND = await commandPath();
/** The model that all tests of the package mesh. */
export const SPOT = path.join(ROOT, 'tests/fixtures/spot.stl');
/** The job of all tests of the package, for the native command. */
const ARGUMENTS = [
  'mesh',
  `${SPOT}:name=cow,flag=7`,
  '--cells',
  '40',
  '--unit',
  'mm',
  '--backend',
  'cpu',
  '--hash',
  'sha256',
  '--json',
];

export function npm(cwd, ...args) {
  return execFileSync('npm', args, { cwd, encoding: 'utf8', stdio: ['ignore', 'pipe', 'pipe'] });
}

/**
 * Packs the package and installs it into a new project, without a registry.
 *
 * @param {string} [within] folder of the project; that of temporary files
 * @returns {{folder: string, tarball: string, files: string[], run: (name: string, code: string, ...args: string[]) => string,
 *   remove: () => void}} the project's folder, the tarball's path, the paths within it; `run` runs a script in Node
 */
export function installedProject(within = tmpdir()) {
  const folder = mkdtempSync(path.join(within, 'hexcast-package-'));
  const { tarball, files } = pack(folder);
  writeFileSync(path.join(folder, 'package.json'), '{"private": true, "type": "module"}');
  npm(folder, 'install', '--offline', '--no-audit', '--no-fund', tarball);
  const run = (name, code, ...args) => {
    writeFileSync(path.join(folder, name), code);
    return execFileSync(process.execPath, [name, ...args], { cwd: folder, encoding: 'utf8', maxBuffer: 1 << 26 });
  };
  return { folder, tarball, files, run, remove: () => rmSync(folder, { recursive: true, force: true }) };
}

/** The model of the lines of the documents, and what they use: `file`, and `use`, which counts cells with a flag and all cells. */
const BOX = boxBetween([0, 0, 0], [4, 2, 2]);
const DOCUMENT_GLOBALS = `
globalThis.file = new File([${JSON.stringify(BOX)}], 'box.stl');
globalThis.cells = [0, 0];
globalThis.use = (flags) => {
  globalThis.cells[0] += flags.reduce((n, flag) => n + (flag > 0 ? 1 : 0), 0);
  globalThis.cells[1] += flags.length;
};
`;

/** The first block of JavaScript of a document, to be run as it stands. */
function linesOf(document) {
  return /^```js\n([\s\S]*?)^```$/m.exec(readFileSync(path.join(ROOT, document), 'utf8'))[1];
}

/**
 * Puts the page of `app/` into a folder, with these import map entries if any; its model goes into `models`. Beside it are the lines of
 * the documents.
 */
export function writePage(folder, { imports, models = folder } = {}) {
  cpSync(path.join(ROOT, 'tests/package/app'), folder, { recursive: true });
  mkdirSync(models, { recursive: true });
  cpSync(SPOT, path.join(models, 'spot.stl'));
  writeFileSync(path.join(folder, 'document_globals.js'), DOCUMENT_GLOBALS);
  writeFileSync(path.join(folder, 'package_readme.js'), linesOf('www/README.md'));
  writeFileSync(path.join(folder, 'libraries.js'), linesOf('docs/libraries.md'));
  const page = path.join(folder, 'index.html');
  const map = imports ? `<script type="importmap">${JSON.stringify({ imports })}</script>` : '';
  writeFileSync(page, readFileSync(page, 'utf8').replace('<!-- import map -->', map));
}

/** Writes `foot.stl`, `arm.stl` and `tip.stl` into a folder: bodies that look different along every axis, and from either side. */
export function writeBodies(folder) {
  writeFileSync(path.join(folder, 'foot.stl'), boxBetween([0, 0, 0], [9, 4, 2]));
  writeFileSync(path.join(folder, 'arm.stl'), boxBetween([1, 0, 2], [3, 2, 6]));
  writeFileSync(path.join(folder, 'tip.stl'), boxBetween([7, 3, 2], [8, 4, 3]));
}

/** Runs the native command in a folder. @param {string} folder @param {string[]} args */
export function nativeCommand(folder, ...args) {
  return spawnSync(COMMAND, args, { cwd: folder, encoding: 'utf8', stdio: ['ignore', 'pipe', 'pipe'] });
}

/** Lines that mesh the `job` of a JSON file, whose surfaces are in a folder: they leave `mesher`, `mesh`, `folder` and the `files` of the JSON. */
export const MESH_OF_FILE = `
  import { readFileSync, writeFileSync } from 'node:fs';
  import { createMesher } from 'hexcast';
  const [given, folder] = process.argv.slice(2);
  const { job, files } = JSON.parse(readFileSync(given, 'utf8'));
  const mesher = await createMesher({ backend: 'cpu' });
  const geometries = job.geometries.map(({ file, ...rest }) => ({ ...rest, file, source: readFileSync(file.startsWith('/') ? file : folder + '/' + file) }));
  const mesh = await mesher.mesh({ ...job, geometries });
`;

/** The native command's report of the job; `-o` outputs may be added, compressed as the command does by default. */
export function nativeReport(outputs = []) {
  return JSON.parse(execFileSync(COMMAND, [...ARGUMENTS, ...outputs], { cwd: ROOT, encoding: 'utf8' }));
}

/** What a page of `app/` must come to, by the native command, which writes into a folder. */
export function nativeOutcome(folder) {
  const box = path.join(folder, 'box.stl');
  writeFileSync(box, BOX);
  const args = ['mesh', box, '--cells', '256', '--backend', 'cpu', '--json'];
  const report = JSON.parse(execFileSync(COMMAND, args, { cwd: ROOT, encoding: 'utf8' }));
  const { cells, flags } = report;
  return { ...nativeReport(), vti: nativeVti(folder), cells: [2 * flags[0].cells, 2 * cells] };
}

/** SHA-256 of the compressed `.vti` of the job by the native command, which writes it into a folder. */
function nativeVti(folder) {
  const file = path.join(folder, 'native.vti');
  nativeReport(['-o', file]);
  return createHash('sha256').update(readFileSync(file)).digest('hex');
}

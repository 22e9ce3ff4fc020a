// An empty project with the packed tarball installed, and what the native command makes of the same job.

import { execFileSync } from 'node:child_process';
import { createHash } from 'node:crypto';
import { cpSync, mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';

import { pack } from '../../scripts/package.mjs';
import { ROOT } from '../../scripts/run.mjs';

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

/** Puts the page of `app/` into a folder, with these import map entries if any; its model goes into `models`. */
export function writePage(folder, { imports, models = folder } = {}) {
  cpSync(path.join(ROOT, 'tests/package/app'), folder, { recursive: true });
  mkdirSync(models, { recursive: true });
  cpSync(SPOT, path.join(models, 'spot.stl'));
  const page = path.join(folder, 'index.html');
  const map = imports ? `<script type="importmap">${JSON.stringify({ imports })}</script>` : '';
  writeFileSync(page, readFileSync(page, 'utf8').replace('<!-- import map -->', map));
}

/** The native command's report of the job; `-o` outputs may be added, compressed at a level. */
export function nativeReport(outputs = [], compress = 'none') {
  const options = outputs.length > 0 ? [`--compress=${compress}`, ...outputs] : [];
  return JSON.parse(execFileSync('cargo', ['run', '-q', '--', ...ARGUMENTS, ...options], { cwd: ROOT, encoding: 'utf8' }));
}

/** SHA-256 of the compressed `.vti` of the job by the native command, which writes it into a folder. */
export function nativeVti(folder) {
  const file = path.join(folder, 'native.vti');
  nativeReport(['-o', file], 6);
  return createHash('sha256').update(readFileSync(file)).digest('hex');
}

// Packs the npm package: npm shows the README in the folder that is packed, and the package has one of its own. So all that it consists of
// is put into target/npm, after `npm run build`, and packed there. Publish that folder, too.

import { execFileSync } from 'node:child_process';
import { cpSync, existsSync, mkdirSync, readFileSync, readdirSync, rmSync, writeFileSync } from 'node:fs';
import path from 'node:path';
import { fileURLToPath } from 'node:url';

import { PACKAGE_FOLDERS } from './build.mjs';
import { ROOT } from './run.mjs';

/** What is packed, without what the manifest's `files` leave out. */
export const STAGE = path.join(ROOT, 'target/npm');
/** What the repository's manifest has for itself alone. */
const OWN_KEYS = ['private', 'scripts', 'devDependencies'];

/** Puts what is packed into `STAGE`. */
export function stage() {
  if (!existsSync(path.join(ROOT, 'dist/hexcast_bg.wasm'))) throw new Error('dist/ has no package yet: run "npm run build"');
  rmSync(STAGE, { recursive: true, force: true });
  mkdirSync(path.join(STAGE, 'dist'), { recursive: true });
  const copy = (/** @type {string} */ from, to = from) =>
    cpSync(path.join(ROOT, from), path.join(STAGE, to), { recursive: true });
  for (const name of ['shaders', 'CHANGELOG.md', 'LICENSE-MIT', 'LICENSE-APACHE']) copy(name);
  copy('www/README.md', 'README.md');
  for (const name of readdirSync(path.join(ROOT, 'dist')).filter(isOfPackage)) copy(`dist/${name}`);
  writeFileSync(path.join(STAGE, 'package.json'), `${JSON.stringify(manifest(), null, 2)}\n`);
}

/** Whether a file or folder of dist/ is the package's; the rest is the page. @param {string} name */
function isOfPackage(name) {
  return /\.(js|d\.ts|wasm)$/.test(name) || PACKAGE_FOLDERS.includes(name);
}

/** The manifest that is published. */
function manifest() {
  const ours = JSON.parse(readFileSync(path.join(ROOT, 'package.json'), 'utf8'));
  for (const key of OWN_KEYS) delete ours[key];
  // a proof of provenance needs it, and where it is only GitHub knows
  const { GITHUB_REPOSITORY: name } = process.env;
  return name ? { ...ours, repository: { type: 'git', url: `git+https://github.com/${name}.git` } } : ours;
}

/**
 * Packs into a folder.
 *
 * @param {string} folder
 * @param {Record<string, string>} [more] files that a release has besides: names in the package, and paths
 * @returns {{ tarball: string, files: string[] }} its path, and the paths within it
 */
export function pack(folder, more = {}) {
  stage();
  for (const [name, file] of Object.entries(more)) cpSync(file, path.join(STAGE, name));
  const args = ['pack', '--json', '--pack-destination', folder];
  const [packed] = JSON.parse(execFileSync('npm', args, { cwd: STAGE, encoding: 'utf8', stdio: ['ignore', 'pipe', 'pipe'] }));
  return {
    tarball: path.join(folder, packed.filename),
    files: packed.files.map((/** @type {{ path: string }} */ file) => file.path),
  };
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  if (process.argv[2] === '--refuse') {
    console.error('this folder is not the package: "npm run package" packs it, in target/npm');
    process.exitCode = 1;
  } else {
    console.log(pack(ROOT).tarball);
  }
}

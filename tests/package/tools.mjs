// Bundlers, runtimes and compilers of tools/package.json, installed once, beside which projects are made; recipes of the README.

import { createHash } from 'node:crypto';
import { cpSync, existsSync, mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import path from 'node:path';

import { ROOT, run } from '../../scripts/run.mjs';

/** Where they are installed; projects in here find them. */
export const TOOLS = path.join(ROOT, 'target/tools');
const LISTS = ['package.json', 'package-lock.json'].map((name) => path.join(ROOT, 'tests/package/tools', name));

/** Installs the tools unless exactly these are there. */
export async function ensureTools() {
  const hash = createHash('sha256');
  for (const list of LISTS) hash.update(readFileSync(list));
  const [wanted, stamp] = [hash.digest('hex'), path.join(TOOLS, 'installed')];
  const isThere = existsSync(path.join(TOOLS, 'node_modules/webpack/package.json'));
  if (isThere && existsSync(stamp) && readFileSync(stamp, 'utf8') === wanted) return;
  mkdirSync(TOOLS, { recursive: true });
  for (const list of LISTS) cpSync(list, path.join(TOOLS, path.basename(list)));
  // not "ci", which fails where the registry lacks a package of another system
  await run('npm', ['install', '--include=dev', '--no-audit', '--no-fund'], { cwd: TOOLS });
  writeFileSync(stamp, wanted);
}

/** The README of the package, as it is packed. */
const README = readFileSync(path.join(ROOT, 'www/README.md'), 'utf8');

/** A block of code of the README by what follows its language, such as `file=rollup.config.js`. @param {string} name */
export function recipe(name) {
  const found = [...README.matchAll(/^```\w+ (.+)\n([\s\S]*?)^```$/gm)].find((match) => match[1] === name);
  if (!found) throw new Error(`the README has no block ${name}`);
  return found[2];
}

/** Writes the recipe of a file into a folder. @param {string} folder @param {string} file */
export function writeRecipe(folder, file) {
  writeFileSync(path.join(folder, file), recipe(`file=${file}`));
}

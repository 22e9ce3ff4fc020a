// The Python package: a virtual environment with what its tests need, the wheel, and pytest.

import { createHash } from 'node:crypto';
import { existsSync, readFileSync, readdirSync, rmSync, writeFileSync } from 'node:fs';
import path from 'node:path';

import { buildNative } from './native.mjs';
import { ROOT, ask, run } from './run.mjs';

const FOLDER = path.join(ROOT, '.tools/python');
const REQUIREMENTS = path.join(ROOT, 'python/tests/requirements.txt');
const WHEELS = path.join(ROOT, 'target/wheels');

const isWindows = process.platform === 'win32';
/** The Python that makes virtual environments. */
export const PYTHON = isWindows ? 'python' : 'python3';
/** Path of a program of a virtual environment. @param {string} folder @param {string} name */
export const programOf = (folder, name) => path.join(folder, isWindows ? `Scripts/${name}.exe` : `bin/${name}`);
/** Path of a program of the environment of the package's tests. @param {string} name */
const program = (name) => programOf(FOLDER, name);

/** Makes the virtual environment of the package's tests. */
export const ensurePython = () => ensureEnvironment(FOLDER, REQUIREMENTS);

/**
 * Makes a virtual environment unless it has exactly the packages of a requirements.txt, for this Python.
 *
 * @param {string} folder
 * @param {string} requirements
 * @param {string[]} [programs] packages of which only programs are run: without what they depend on, and whatever Python they want
 * @param {string} [apart] a package for the system's Python, which has what it depends on; it goes to the folder "apart"
 */
export async function ensureEnvironment(folder, requirements, programs = [], apart = '') {
  const wanted = createHash('sha256')
    .update(readFileSync(requirements))
    .update([...programs, apart].join(' '))
    .update(ask(PYTHON, ['--version']) ?? '')
    .digest('hex');
  const stamp = path.join(folder, '.hexcast-requirements');
  if (existsSync(stamp) && readFileSync(stamp, 'utf8') === wanted) return null;
  rmSync(folder, { recursive: true, force: true });
  await run(PYTHON, ['-m', 'venv', folder]);
  const python = programOf(folder, 'python');
  const install = ['-m', 'pip', 'install', '--quiet', '--only-binary=:all:'];
  await run(python, [...install, '--requirement', requirements]);
  if (programs.length > 0) await run(python, [...install, '--no-deps', '--ignore-requires-python', ...programs]);
  if (apart) await run(python, [...install, '--no-deps', '--target', path.join(folder, 'apart'), apart]);
  writeFileSync(stamp, wanted);
  return 'installed';
}

/** Builds the wheel and installs it. */
export async function buildPython() {
  rmSync(WHEELS, { recursive: true, force: true });
  await run(program('maturin'), ['build', '--profile', 'dev', '--out', WHEELS, '--manifest-path', 'python/Cargo.toml'], {
    env: { VIRTUAL_ENV: FOLDER },
  });
  const [wheel] = readdirSync(WHEELS);
  await run(program('python'), ['-m', 'pip', 'install', '--no-deps', '--force-reinstall', path.join(WHEELS, wheel)]);
  return wheel;
}

/** Runs the tests and the examples in the documentation of the installed package; returns what it printed, the counts at its end. */
export async function runPytest() {
  const args = ['--doctest-modules', '--import-mode=importlib', '--pyargs', 'hexcast', 'tests', '-q', '-rfEP'];
  // the command that the wheel is compared with
  const env = { HEXCAST_COMMAND: await buildNative() };
  return run(program('pytest'), args, { cwd: path.join(ROOT, 'python'), env });
}

/** Holds the workflows of GitHub to their schema. */
export async function checkWorkflows() {
  const folder = path.join(ROOT, '.github/workflows');
  const files = readdirSync(folder).map((name) => path.join(folder, name));
  await run(program('check-jsonschema'), ['--builtin-schema', 'vendor.github-workflows', ...files]);
  return `${files.length} files`;
}

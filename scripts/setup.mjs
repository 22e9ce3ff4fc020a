// npm run setup: installs what the tests need from the machine, or says what to install.

import { fileURLToPath } from 'node:url';

import { ensureS3 } from './cluster.mjs';
import { ensureDeny } from './release/deny.mjs';
import { ensure, ensureNodeModules, requireRust } from './machine.mjs';
import { ensurePython } from './python.mjs';
import { Steps } from './run.mjs';
import { ensureSolvers } from './solvers.mjs';
import { ensureBindgen, threadsRust, wasmRust } from './wasm.mjs';

/** What each group of tests needs from the machine; the names are those of the list in machine.mjs. */
/** @type {Record<string, Parameters<typeof ensure>>} */
const NEEDS = {
  lint: ['linker'],
  native: ['linker', 'vulkan', 'chromium', 'valgrind'],
  wasm: ['linker', 'vulkan', 'chromium', 'firefox'],
  e2e: ['linker', 'vulkan', 'chromium', 'firefox', 'font'],
  package: ['linker', 'vulkan', 'chromium', 'firefox'],
  python: ['linker', 'vulkan', 'python', 'opengl'],
  cluster: ['linker', 'vulkan', 'python', 'mpi', 'fortran', 'cmake', 'pkgconfig', 'valgrind'],
  solvers: ['linker', 'python', 'openfoam', 'calculix', 'gmsh', 'openems', 'dolfinx', 'taufactor', 'palabos'],
};

/** The groups of tests that run on every change. */
export const GROUPS = Object.keys(NEEDS);
/** The group that "npm run test:release" adds; it needs what `lint` does. */
export const RELEASE = 'release';

/** Installs what the machine lacks for these groups. @param {Steps} steps @param {string[]} [groups] */
export async function setup(steps, groups = GROUPS) {
  await steps.step('Node packages', ensureNodeModules);
  await steps.step('Rust', async () => requireRust());
  await steps.step('linker, drivers, browsers, Python', () =>
    ensure(...new Set(groups.flatMap((group) => NEEDS[group === RELEASE ? 'lint' : group]))),
  );
  if (groups.some((group) => ['python', 'cluster'].includes(group))) await steps.step('Python packages', ensurePython);
  if (groups.includes('cluster')) await steps.step('S3 server', ensureS3);
  if (groups.includes('solvers')) await steps.step('Python packages of the solvers', ensureSolvers);
  if (groups.every((group) => ['native', 'python', 'cluster', 'solvers', RELEASE].includes(group))) return;
  await steps.step('Rust for wasm32', async () => (await wasmRust()).name);
  await steps.step('Rust for wasm32 with threads', async () => (await threadsRust()).name);
  if (groups.includes('lint')) await steps.step('cargo-deny', ensureDeny);
  await steps.step('wasm-bindgen', async () => void (await ensureBindgen()));
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  const steps = new Steps();
  await setup(steps);
  steps.finish();
}

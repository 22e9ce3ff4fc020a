// npm test: everything, from a clean clone, on a machine with Node and Rust. "npm test -- native e2e" runs groups.
//
// What is native and what is for browsers run at the same time, as neither keeps all cores busy alone. The command, which both need, is
// built first; after that only what is native calls cargo for the native target, so that no test waits for a build.
//
// "npm run test:release" adds the group `release`: what is only worth its time before a release.

import { readFileSync, readdirSync } from 'node:fs';
import path from 'node:path';

import { build } from './build.mjs';
import { testC, testExamples } from './c/library.mjs';
import { testFiles } from './c/files.mjs';
import { testInstall, testNames } from './c/install.mjs';
import { runCluster } from './cluster.mjs';
import { testCounted } from './counted.mjs';
import { checkAdvisories, checkCrates } from './release/deny.mjs';
import { swiftshaderEnv } from './machine.mjs';
import { checkOldestRust, checkOldestRustIfChanged } from './release/msrv.mjs';
import { LIBRARY, buildNative, cargoTest } from './native.mjs';
import { buildPython, checkWorkflows, runPytest } from './python.mjs';
import { ROOT, Steps, run } from './run.mjs';
import { GROUPS, RELEASE, setup } from './setup.mjs';
import { runSolvers } from './solvers.mjs';
import { bindgenTool, clippyWasm, compileWasmTests } from './wasm.mjs';

const steps = new Steps();

/** @type {Promise<void> | null} */
let built = null;

/** The command, the C library and the tests of both: one step, which all that needs them awaits. */
function nativeBuilt() {
  built ??= steps.step('build of the command, the C library and their tests', async () => {
    // for the tests, which do not call cargo
    process.env.HEXCAST_COMMAND = await buildNative();
  });
  return built;
}

async function quickLint() {
  await steps.command('Biome', 'npx', ['biome', 'check', '--error-on-warnings']);
  await steps.step('licences, versions and sources of crates', checkCrates);
  await steps.step('advisories of crates', checkAdvisories);
  await steps.step('documents', () => nodeTests('tests/documents'));
  await steps.command('rustfmt', 'cargo', ['fmt', '--all', '--check']);
}

async function nativeLint() {
  // all crates in one go: each by itself would compile others with features of its own
  const all = ['--workspace', '--all-targets', '--features', 'hexcast/s3'];
  await steps.command('clippy', 'cargo', ['clippy', ...all, '--', '-D', 'warnings']);
  await steps.step('oldest Rust', checkOldestRustIfChanged);
  await steps.command('docs', 'cargo', ['doc', '--no-deps'], { env: { RUSTDOCFLAGS: '-D warnings' } });
}

/** What is only worth its time before a release. */
async function release() {
  // as callers of the library have it: without what tests use, and without any feature
  await steps.command('clippy of the library', 'cargo', ['clippy', '--', '-D', 'warnings']);
  const bare = ['--all-targets', '--no-default-features'];
  await steps.command('clippy without features', 'cargo', ['clippy', ...bare, '--', '-D', 'warnings']);
  await steps.step('oldest Rust', checkOldestRust);
  // builds them of what would be published
  await steps.command('crates as they are published', 'cargo', ['package', ...LIBRARY, '--allow-dirty']);
}

async function native() {
  await steps.step('native tests', async () => countedTests(await cargoTest()));
  await steps.step('instructions of some jobs', testCounted);
  const env = swiftshaderEnv();
  await steps.step('kernel tests on SwiftShader', async () => {
    if (!env) throw new Error("missing: SwiftShader as a Vulkan driver, which Debian's package chromium brings");
    return countedTests(await cargoTest(['--test', 'native', 'kernels', '--', '--show-output'], { env }));
  });
}

async function python() {
  await steps.step('Python wheel', buildPython);
  await steps.step('workflows of GitHub', checkWorkflows);
  await steps.step('Python tests', async () => pytestTests(await runPytest()));
}

/** What runs on many machines, or ranks. */
async function cluster() {
  if (!wanted('python')) await steps.step('Python wheel', buildPython);
  await steps.step('cluster tests', async () => pytestTests(await runCluster()));
  await steps.step('C test', testC);
  await steps.step('C by pkg-config and CMake', testInstall);
  await steps.step('names of the C library on other systems', testNames);
  await steps.step('files of C', testFiles);
  await steps.step('C on four ranks, and Fortran', testExamples);
}

async function wasm() {
  // loaded late: they need the Node packages; by names that the compiler does not follow, as it does not check tests
  const [runTests, browsers] = ['../tests/web/browser.mjs', '../tests/e2e/browsers.mjs'];
  const [{ testInBrowser }, { openChromium, openFirefox }] = await Promise.all([import(runTests), import(browsers)]);
  for (const [name, open] of Object.entries({ Chromium: openChromium, Firefox: openFirefox })) {
    await steps.step(`wasm tests in ${name}`, async () =>
      countedTests(await testInBrowser(open, bindgenTool('wasm-bindgen-test-runner'), await compileWasmTests())),
    );
  }
}

/** Counts the tests of a cargo run: none at all, or one left out, is a failure. @param {string} output */
function countedTests(output) {
  const results = [...output.matchAll(/test result: \w+\. (\d+) passed; (\d+) failed; (\d+) ignored/g)];
  const [n_passed, , n_ignored] = [1, 2, 3].map((field) => results.reduce((sum, result) => sum + Number(result[field]), 0));
  return remark(output, n_passed, n_ignored);
}

/** Counts the tests of a run of pytest by its last line. @param {string} output */
function pytestTests(output) {
  const last = output.trimEnd().split('\n').at(-1) ?? '';
  const count = (/** @type {string} */ word) => Number(new RegExp(`(\\d+) ${word}`).exec(last)?.[1] ?? 0);
  return remark(output, count('passed'), count('skipped') + count('deselected') + count('xfailed') + count('xpassed'));
}

/** Runs the tests of the page; one that passed only when it was tried again counts as left out. */
async function playwrightTests() {
  const output = await run('npx', ['playwright', 'test']);
  const { stats } = JSON.parse(readFileSync(path.join(ROOT, 'target/e2e.json'), 'utf8'));
  return remark(output, stats.expected, stats.skipped + stats.flaky);
}

/** Runs the *.test.mjs of a folder with Node's test runner, one file after another. @param {string} folder */
async function nodeTests(folder) {
  const files = readdirSync(path.join(ROOT, folder))
    .filter((name) => name.endsWith('.test.mjs'))
    .sort();
  if (files.length === 0) throw new Error(`${folder} has no *.test.mjs`);
  const args = ['--test', '--test-concurrency=1', '--test-reporter=spec', ...files.map((name) => path.join(folder, name))];
  const output = await run(process.execPath, args);
  const count = (/** @type {string} */ field) => Number(new RegExp(`^\\S+ ${field} (\\d+)$`, 'm').exec(output)?.[1] ?? 0);
  return remark(output, count('pass'), count('skipped') + count('todo') + count('cancelled'));
}

/** @param {string} output @param {number} n_passed @param {number} n_left_out */
function remark(output, n_passed, n_left_out) {
  if (n_passed === 0 || n_left_out > 0) {
    throw Object.assign(new Error(`${n_passed} tests ran, ${n_left_out} were left out`), { output });
  }
  const adapters = new Set([...output.matchAll(/adapter: (.+)$/gm)].map((match) => match[1].trim()));
  return [`${n_passed} tests`, ...adapters].join(', ');
}

const asked = process.argv.slice(2);
const unknown = asked.filter((group) => ![...GROUPS, RELEASE].includes(group));
if (unknown.length > 0) {
  console.error(`no such tests: ${unknown.join(' ')}; there are ${[...GROUPS, RELEASE].join(', ')}`);
  process.exit(2);
}
// of the groups of every change all, unless some are named
const groups = asked.some((group) => group !== RELEASE) ? asked : [...GROUPS, ...asked];
const wanted = (/** @type {string} */ group) => groups.includes(group);
const needsCommand = ['native', 'python', 'cluster', 'solvers', 'package', 'e2e'].some(wanted);
await setup(steps, groups);

async function nativeGroups() {
  if (wanted('lint')) await quickLint();
  if (needsCommand) await nativeBuilt();
  if (wanted('lint')) await nativeLint();
  if (wanted('native')) await native();
  if (wanted('python')) await python();
  if (wanted('cluster')) await cluster();
  if (wanted('solvers')) await steps.step('solvers', async () => pytestTests(await runSolvers()));
  if (wanted(RELEASE)) await release();
}

async function browserGroups() {
  if (['lint', 'e2e', 'package'].some(wanted)) await steps.step('build', build);
  for (const project of wanted('lint') ? ['tsconfig.json', 'tsconfig.worker.json'] : []) {
    // the types of the wasm are made with it
    await steps.command(`types, ${project}`, 'npx', ['tsc', '-p', project]);
  }
  if (['package', 'e2e'].some(wanted)) await nativeBuilt();
  if (wanted('package')) await steps.step('package tests', () => nodeTests('tests/package'));
  if (wanted('wasm')) await wasm();
  if (wanted('e2e')) await steps.step('page tests', playwrightTests);
  if (wanted('lint')) await steps.step('clippy for wasm32', clippyWasm);
}

await Promise.all([nativeGroups(), browserGroups()]);
steps.finish();

// What is native: the command, the C library, and the tests of both, built once, together, before anything runs that needs them. Tests
// get the command's path and never call cargo, which would wait for the build folder while another group of tests holds it.

import { run } from './run.mjs';

/** The crates that are published, as arguments of cargo. */
export const LIBRARY = ['hexcast-job', 'hexcast-core', 'hexcast-derived', 'hexcast-files', 'hexcast-gpu', 'hexcast'].flatMap(
  (name) => ['--package', name],
);
/** With S3, which the tests of clusters need: so all tests run one command. */
const CARGO_ARGS = [...LIBRARY, '--package', 'hexcast-c', '--features', 'hexcast/s3'];

/** @type {Promise<string> | null} */
let built = null;

/** Builds all this, once in a process. @returns {Promise<string>} path of the command */
export function buildNative() {
  built ??= compile();
  return built;
}

async function compile() {
  const targets = ['--lib', '--bins', '--tests', '--examples', '--message-format', 'json-render-diagnostics'];
  const output = await run('cargo', ['build', ...CARGO_ARGS, ...targets]);
  const artifacts = output
    .split('\n')
    .filter((line) => line.startsWith('{'))
    .map((line) => JSON.parse(line));
  // and not the program of its unit tests
  return artifacts.find(({ target, profile, executable }) => target?.kind.includes('bin') && executable && !profile.test)
    .executable;
}

/** Path of the command for tests in JavaScript: that of `npm test`; for tests that are run by themselves it is built. */
export async function commandPath() {
  return process.env.HEXCAST_COMMAND ?? (await buildNative());
}

/** Runs the tests in Rust. @param {string[]} more arguments, such as a filter @param {Parameters<typeof run>[2]} [options] */
export function cargoTest(more = [], options = {}) {
  return run('cargo', ['test', ...CARGO_ARGS, ...more], options);
}

// A clean clone has no Node packages: the commands that install them load none before.

import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import path from 'node:path';
import test from 'node:test';

import { ROOT } from '../../scripts/run.mjs';

const COMMANDS = [
  'scripts/test.mjs',
  'scripts/setup.mjs',
  'scripts/build.mjs',
  'scripts/release/release.mjs',
  'benches/bench.mjs',
  'paper/paper.mjs',
];
const STATIC_IMPORT = /^(?:import|export)\b[^;]*?\bfrom '([^']+)';|^import '([^']+)';/gm;

/** The names of the modules of others that a file loads at once, through all that it imports; each as "FILE imports NAME". */
function packagesOf(file, seen = new Set()) {
  if (seen.has(file)) return [];
  seen.add(file);
  const names = [...readFileSync(path.join(ROOT, file), 'utf8').matchAll(STATIC_IMPORT)].map(([, from, bare]) => from ?? bare);
  return names.flatMap((name) => {
    if (name.startsWith('node:')) return [];
    if (!name.startsWith('.')) return [`${file} imports ${name}`];
    return packagesOf(path.join(path.dirname(file), name), seen);
  });
}

for (const command of COMMANDS) {
  test(`${command} starts without Node packages`, () => assert.deepEqual(packagesOf(command), []));
}

test('imports of packages are found, also through other files', () => {
  assert.deepEqual(packagesOf('scripts/screenshot.mjs').slice(0, 1), ['tests/e2e/browsers.mjs imports @playwright/test']);
});

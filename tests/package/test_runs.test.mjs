// npm test itself: its limits, and that no test waits for the build folder of cargo.

import assert from 'node:assert/strict';
import { readFileSync, readdirSync } from 'node:fs';
import path from 'node:path';
import test from 'node:test';

import { ROOT, run } from '../../scripts/run.mjs';

/** A program that prints a line so often, after so many milliseconds each. */
const printing = (times, milliseconds) => [
  '-e',
  `let n = 0; const timer = setInterval(() => { console.log(n); n += 1; if (n === ${times}) clearInterval(timer); }, ${milliseconds})`,
];

test('a command may take long, as long as it prints', async () => {
  assert.equal(await run(process.execPath, printing(4, 1500), { silence: 4 / 60 }), '0\n1\n2\n3\n');
});

test('a command that prints nothing is ended, with what it printed before', async () => {
  await assert.rejects(
    run(process.execPath, ['-e', 'console.log("begun"); setInterval(() => {}, 1000)'], { silence: 3 / 60 }),
    ({ message, output }) => /printed nothing for 0\.05 minutes$/.test(message) && output === 'begun\n',
  );
});

test('tests in JavaScript get the command by its path and do not call cargo', () => {
  for (const folder of ['tests/package', 'tests/e2e']) {
    const files = readdirSync(path.join(ROOT, folder)).filter((name) => name.endsWith('.mjs'));
    const calls = files.filter((name) => /['"]cargo['"],/.test(readFileSync(path.join(ROOT, folder, name), 'utf8')));
    assert.deepEqual(calls, [], folder);
  }
});

// The counter of `npm run weight`: what it takes for code, and that its rows are of this repository.

import assert from 'node:assert/strict';
import test from 'node:test';

import { byEntries, codeLines, counted, isTest } from '../../scripts/weight.mjs';

test('comments, empty lines and modules of tests are no code', () => {
  const rust = `//! What it is for.

use std::fs; // read

/// A function.
fn one() -> u32 {
    1
}

#[cfg(test)]
mod tests {
    #[test]
    fn is_one() {}
}
`;
  assert.equal(codeLines(rust, 'rs'), 4);
  assert.equal(codeLines('/** Text\n * more. */\nconst a = 1;\n\n// b\nlet c; /* d */\n', 'js'), 2);
  assert.equal(codeLines('"""What it is\nfor."""\n# a\nimport os\n\nx = "#"\n', 'py'), 2);
});

test('files of tests are told by their place', () => {
  const files = [
    'crates/job/src/input/job/tests.rs',
    'crates/files/src/export/tests/foam.rs',
    'crates/derived/src/links.rs',
    'crates/core/src/base/contests.rs',
  ];
  assert.deepEqual(files.map(isTest), [true, true, false, false]);
});

test('every row has a figure', () => {
  const rows = counted();
  for (const [what, figure] of rows) assert.match(figure, /^[1-9][0-9]*/, what);
});

test('no folder of source has more entries than the eye takes in', () => {
  const [[folder, entries]] = byEntries(['src', 'crates', 'www', 'shaders', 'scripts', 'python/package', 'capi/src']);
  assert.ok(entries <= 24, `${folder} has ${entries} entries: group them`);
});

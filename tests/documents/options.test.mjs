// What lists the options of a job outside of Rust is as `npm run options` makes it of the schema.

import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import path from 'node:path';
import test from 'node:test';

import { generated } from '../../scripts/options.mjs';
import { ROOT } from '../../scripts/run.mjs';

for (const [file, text] of Object.entries(generated())) {
  test(`${file} is made of the schema of a job`, () => {
    assert.equal(readFileSync(path.join(ROOT, file), 'utf8'), text, `run \`npm run options\`, and commit ${file}`);
  });
}

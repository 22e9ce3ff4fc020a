// The script of the README in Node, newer Nodes, Bun and Deno: the same bytes as the native command.

import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { createHash } from 'node:crypto';
import { cpSync, readFileSync, rmSync } from 'node:fs';
import path from 'node:path';
import { after, before, test } from 'node:test';

import { SPOT, installedProject, nativeReport } from './project.mjs';
import { TOOLS, ensureTools, writeRecipe } from './tools.mjs';

let project;
let expected;
before(
  async () => {
    await ensureTools();
    project = installedProject(TOOLS);
    cpSync(SPOT, path.join(project.folder, 'spot.stl'));
    writeRecipe(project.folder, 'node.js');
    const file = path.join(project.folder, 'native.vti');
    const { flags_sha256 } = nativeReport(['-o', file]);
    expected = { hash: flags_sha256, vti: hashOf(file) };
  },
  { timeout: 1_200_000 },
);
after(() => project?.remove());

function hashOf(file) {
  return createHash('sha256').update(readFileSync(file)).digest('hex');
}

const RUNTIMES = {
  'this Node': [process.execPath],
  'Node 22': [path.join(TOOLS, 'node_modules/node22/bin/node')],
  Bun: [path.join(TOOLS, 'node_modules/.bin/bun')],
  Deno: [
    path.join(TOOLS, 'node_modules/.bin/deno'),
    'run',
    '--allow-read',
    '--allow-write',
    '--allow-env',
    '--allow-ffi',
    '--allow-sys',
  ],
};

for (const [name, [program, ...args]] of Object.entries(RUNTIMES)) {
  test(`the README's script meshes in ${name}`, { timeout: 120_000 }, () => {
    const vti = path.join(project.folder, 'cow.vti');
    rmSync(vti, { force: true });
    const printed = execFileSync(program, [...args, 'node.js'], { cwd: project.folder, encoding: 'utf8' });
    assert.deepEqual({ hash: printed.trim(), vti: hashOf(vti) }, expected);
  });
}

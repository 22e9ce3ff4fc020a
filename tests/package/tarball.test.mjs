// The packed tarball, installed into an empty project, runs in Node.

import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { after, before, test } from 'node:test';

import { ROOT } from '../../scripts/run.mjs';

const { version } = JSON.parse(readFileSync(path.join(ROOT, 'package.json'), 'utf8'));
const SHOW_VERSION = `
  import { version } from 'hexcast';
  console.log(version);
`;

let project;
let packed;
before(() => {
  project = mkdtempSync(path.join(tmpdir(), 'hexcast-package-'));
  [packed] = JSON.parse(npm(ROOT, 'pack', '--json', '--pack-destination', project));
  writeFileSync(path.join(project, 'package.json'), '{"private": true, "type": "module"}');
  npm(project, 'install', '--offline', '--no-audit', '--no-fund', path.join(project, packed.filename));
});
after(() => rmSync(project, { recursive: true, force: true }));

function npm(cwd, ...args) {
  return execFileSync('npm', args, { cwd, encoding: 'utf8', stdio: ['ignore', 'pipe', 'pipe'] });
}

test('the tarball holds the wasm, the glue and the shaders, and no sources', () => {
  const files = packed.files.map((file) => file.path);
  for (const file of ['dist/hexcast.js', 'dist/hexcast_bg.wasm', 'dist/hexcast.d.ts', 'shaders/map.wgsl', 'package.json']) {
    assert.ok(files.includes(file), `${file} of ${files.join(' ')}`);
  }
  assert.deepEqual(files.filter((file) => /^(src|tests|scripts|target|www)\/|page|index\.html/.test(file)), []);
});

test('the crate and the package are the same version', () => {
  const cargo = readFileSync(path.join(ROOT, 'Cargo.toml'), 'utf8');
  assert.equal(/^version = "(.+)"$/m.exec(cargo)[1], version);
});

test('Node loads the installed package', () => {
  writeFileSync(path.join(project, 'show.js'), SHOW_VERSION);
  assert.equal(execFileSync(process.execPath, ['show.js'], { cwd: project, encoding: 'utf8' }), `${version}\n`);
});

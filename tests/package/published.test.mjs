// What is published: the same bytes each time, with the package's own README, licences and changelog; its documentation.

import assert from 'node:assert/strict';
import { execFileSync, spawnSync } from 'node:child_process';
import { mkdirSync, mkdtempSync, readFileSync, readdirSync, rmSync, utimesSync } from 'node:fs';
import { homedir, tmpdir } from 'node:os';
import path from 'node:path';
import { after, before, test } from 'node:test';

import { STAGE, pack, stage } from '../../scripts/package.mjs';
import { ROOT } from '../../scripts/run.mjs';

const read = (...names) => readFileSync(path.join(...names), 'utf8');

let folder;
before(() => (folder = mkdtempSync(path.join(tmpdir(), 'hexcast-published-'))));
after(() => rmSync(folder, { recursive: true, force: true }));

test('two packs are the same bytes, whenever the files were written', () => {
  const packed = ['one', 'two'].map((name) => {
    const to = path.join(folder, name);
    mkdirSync(to);
    return readFileSync(pack(to).tarball);
  });
  assert.ok(packed[0].length > 400_000 && packed[0].equals(packed[1]));
  // what npm publish packs by itself
  for (const name of readdirSync(path.join(STAGE, 'dist'))) utimesSync(path.join(STAGE, 'dist', name), 1e9, 1e9);
  execFileSync('npm', ['pack', '--pack-destination', folder], { cwd: STAGE, stdio: 'ignore' });
  const [again] = readdirSync(folder).filter((name) => name.endsWith('.tgz'));
  assert.ok(readFileSync(path.join(folder, again)).equals(packed[0]));
});

test('the wasm names no folder of the machine that built it', () => {
  const wasm = readFileSync(path.join(ROOT, 'dist/hexcast_bg.wasm'), 'latin1');
  assert.match(wasm, /[\w-]+\/src\/\w+\.rs/, 'places in sources are named');
  for (const folder of [homedir(), ROOT]) assert.ok(!wasm.includes(`${folder}/`), folder);
});

test('npm shows the README of the package, and no link of it or of the changelog leads nowhere', () => {
  stage();
  assert.equal(read(STAGE, 'README.md'), read(ROOT, 'www/README.md'));
  for (const name of ['CHANGELOG.md', 'LICENSE-MIT', 'LICENSE-APACHE']) assert.equal(read(STAGE, name), read(ROOT, name));
  for (const name of ['README.md', 'CHANGELOG.md']) {
    const links = [...read(STAGE, name).matchAll(/\]\(([^)]+)\)/g)].map((match) => match[1]);
    assert.deepEqual(
      links.filter((link) => !/^https:\/\//.test(link)),
      [],
      name,
    );
  }
});

test('the manifest has nothing of the repository alone, and tells where it is if it is known', () => {
  stage();
  const manifest = JSON.parse(read(STAGE, 'package.json'));
  const ours = JSON.parse(read(ROOT, 'package.json'));
  const left = Object.keys(ours).filter((key) => !(key in manifest));
  assert.deepEqual(left.sort(), ['devDependencies', 'private', 'scripts']);
  for (const key of Object.keys(manifest)) assert.deepEqual(manifest[key], ours[key], key);
  process.env.GITHUB_REPOSITORY = 'someone/hexcast';
  try {
    stage();
  } finally {
    delete process.env.GITHUB_REPOSITORY;
  }
  const { repository } = JSON.parse(read(STAGE, 'package.json'));
  assert.deepEqual(repository, { type: 'git', url: 'git+https://github.com/someone/hexcast.git' });
});

test('the repository itself is not packed', () => {
  const { status, stderr } = spawnSync('npm', ['pack', '--pack-destination', folder], { cwd: ROOT, encoding: 'utf8' });
  assert.notEqual(status, 0);
  assert.match(stderr, /"npm run package" packs it, in target\/npm/);
});

test('typedoc writes the documentation of all that is exported, without warnings', { timeout: 120_000 }, () => {
  const out = path.join(folder, 'api');
  const { status, stdout, stderr } = spawnSync(path.join(ROOT, 'node_modules/.bin/typedoc'), ['--out', out], {
    cwd: ROOT,
    encoding: 'utf8',
  });
  assert.equal(status, 0, stdout + stderr);
  assert.doesNotMatch(stdout + stderr, /warning/);
  const pages = readdirSync(out, { recursive: true });
  for (const name of ['interfaces/Mesh.html', 'interfaces/Job.html', 'classes/HexcastError.html', 'functions/createMesher.html'])
    assert.ok(pages.includes(name), `${name} of ${pages.join(' ')}`);
  assert.match(read(out, 'interfaces/Mesh.html'), /flagsTexture/);
  // the README is its first page
  assert.match(read(out, 'index.html'), /Files that must be served/);
});

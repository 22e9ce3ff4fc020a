// What a release needs of the repository: one version, a changelog, a workflow that calls scripts that are there, an image that is not root.

import assert from 'node:assert/strict';
import { existsSync, readFileSync, readdirSync } from 'node:fs';
import path from 'node:path';
import test from 'node:test';

import { parseDocument } from 'yaml';

import { LIBRARY } from '../../scripts/native.mjs';
import { imageFaults } from '../../scripts/release/image.mjs';
import { pruned } from '../../scripts/release/notices.mjs';
import { changelogFaults, notes, releaseFaults, version, versionFaults } from '../../scripts/release/versions.mjs';
import { ROOT } from '../../scripts/run.mjs';

const read = (file) => readFileSync(path.join(ROOT, file), 'utf8');
const { scripts } = JSON.parse(read('package.json'));

test('all files have the version of Cargo.toml, and another one is found in each', () => {
  assert.deepEqual(versionFaults(), []);
  const files = versionFaults('99.9.9').map((fault) => fault.split(' ')[0]);
  assert.equal(files.length, 13, files.join(' '));
  assert.deepEqual(
    releaseFaults('v99.9.9')[0],
    `the tag is v99.9.9, and the version v${version()}: run "node scripts/release/versions.mjs 99.9.9"`,
  );
});

test('the changelog says what is new', () => {
  assert.deepEqual(changelogFaults(version(), false), []);
  const text = '# C\n\n## [Unreleased]\n\n### Added\n\n- b\n\n## [1.1.0] - 2026-01-02\n\n- a\n\n## [1.0.0]\n\n### Fixed\n';
  assert.deepEqual(changelogFaults('1.1.0', true, text), []);
  assert.deepEqual(changelogFaults('1.2.0', false, text), []);
  assert.equal(changelogFaults('1.2.0', true, text).length, 1);
  assert.equal(changelogFaults('1.0.0', true, text).length, 2, 'neither day nor sentence');
  assert.equal(changelogFaults('1.2.0', false, text.replace('- b', '')).length, 1);
  assert.equal(notes('1.1.0', text), '- a\n\n');
});

/** What is wrong with a workflow: that it is no YAML, or calls what is not there. */
function workflowFaults(text) {
  const document = parseDocument(text);
  if (document.errors.length > 0) return document.errors.map((error) => error.message);
  const steps = Object.values(document.toJS().jobs).flatMap((job) => job.steps);
  const commands = steps.flatMap((step) => (step.run ? [step.run] : [])).join('\n');
  const called = [...commands.matchAll(/npm run ([\w:]+)/g)].map((match) => match[1]);
  const files = [...commands.matchAll(/[\w./-]*scripts\/[\w./-]+/g)].map((match) => match[0]);
  return [
    ...called.filter((name) => !(name in scripts)).map((name) => `no script ${name}`),
    ...files.filter((file) => !existsSync(path.join(ROOT, file))).map((file) => `no file ${file}`),
  ];
}

for (const name of readdirSync(path.join(ROOT, '.github/workflows'))) {
  test(`${name} is YAML, and calls scripts that are there`, () =>
    assert.deepEqual(workflowFaults(read(`.github/workflows/${name}`)), []));
}

test('a workflow that calls what is not there is found', () => {
  const calls = (run) => `jobs:\n  a:\n    steps:\n      - run: ${run}\n`;
  assert.deepEqual(workflowFaults(calls('npm run none && node scripts/none.mjs')), [
    'no script none',
    'no file scripts/none.mjs',
  ]);
  assert.deepEqual(workflowFaults(calls('npm run release -- --dry')), []);
  assert.equal(workflowFaults('jobs: [').length, 1);
});

test('the workflow publishes all crates in order, the package with its provenance, and names no registry of packages', () => {
  const workflow = read('.github/workflows/release.yml');
  const [, published] = /cargo publish --locked (.+)/.exec(workflow);
  assert.equal(published, LIBRARY.join(' '));
  assert.match(workflow, /npm publish "\.\/artefacts\/hexcast-\$\{GITHUB_REF_NAME#v\}\.tgz" --provenance --access public/);
  assert.doesNotMatch(workflow, /registry-url|index-url|repository-url|https?:/);
  const manifests = [
    'Cargo.toml',
    'python/pyproject.toml',
    'package.json',
    ...LIBRARY.filter((word) => /-/.test(word) && !/^--/.test(word)).map(
      (name) => `crates/${name.replace('hexcast-', '')}/Cargo.toml`,
    ),
  ];
  for (const file of manifests) assert.doesNotMatch(read(file), /registry|index-url/, file);
});

test('cargo-binstall looks for the archive where the release has it', () => {
  const text = read('Cargo.toml');
  const filled = (template, target) =>
    template
      .replaceAll('{ name }', 'hexcast')
      .replaceAll('{ version }', version())
      .replaceAll('{ target }', target)
      .replaceAll('{ binary-ext }', '')
      .replaceAll('{ bin }', 'hexcast');
  const urls = [...text.matchAll(/^pkg-url = "(.+)"$/gm)].map((match) => filled(match[1], 'TARGET'));
  const place = `{ repo }/releases/download/v${version()}/hexcast-${version()}-TARGET`;
  assert.deepEqual(urls, [`${place}.tar.gz`, `${place}.zip`]);
  assert.equal(filled(/^bin-dir = "(.+)"$/m.exec(text)[1], 'TARGET'), `hexcast-${version()}-TARGET/hexcast`);
});

test('the image is of one version, has an entry without a shell, and is not root', () => {
  const text = read('scripts/release/Dockerfile');
  assert.deepEqual(imageFaults(text), []);
  assert.deepEqual(imageFaults(text.replace('USER 65532:65532', 'USER 0')), ['it runs as 0']);
  assert.deepEqual(imageFaults(text.replace(/^USER .*\n/m, '')), ['it runs as root']);
  assert.deepEqual(imageFaults(text.replace('debian:12-slim', 'debian')), ['FROM debian names no version']);
  assert.deepEqual(imageFaults(text.replace('ENTRYPOINT ["hexcast"]', 'ENTRYPOINT hexcast')), [
    'it has no ENTRYPOINT without a shell',
  ]);
  assert.deepEqual(imageFaults(text.replace('COPY hexcast', 'ADD hexcast')), [
    'COPY does what is wanted of "ADD hexcast /usr/bin/"',
  ]);
});

test('a bill of materials has what is compiled, and no more', () => {
  const component = (name) => ({ name, version: '1.0.0', 'bom-ref': name });
  const bill = {
    metadata: { component: component('root') },
    components: ['a', 'b'].map(component),
    dependencies: [{ ref: 'root', dependsOn: ['a', 'b'] }, { ref: 'a' }, { ref: 'b', dependsOn: ['a'] }],
  };
  const { components, dependencies } = pruned(bill, ['root 1.0.0', 'a 1.0.0']);
  assert.deepEqual(components, [component('a')]);
  assert.deepEqual(dependencies, [{ ref: 'root', dependsOn: ['a'] }, { ref: 'a' }]);
  assert.throws(() => pruned(bill, ['root 1.0.0', 'c 1.0.0']), /lacks c 1\.0\.0/);
});

// The documents: short ones stay short, no link of any leads nowhere, and every page of docs/ is in the site.

import assert from 'node:assert/strict';
import { existsSync, readFileSync, readdirSync } from 'node:fs';
import path from 'node:path';
import test from 'node:test';

import { anchorsOf, linksOf, withLinks } from '../../scripts/links.mjs';
import { ROOT } from '../../scripts/run.mjs';

/** Most lines of the documents that are read first. */
const MOST_LINES = 150;
const SHORT = ['README.md', 'ARCHITECTURE.md'];
/** docs/api is made by typedoc. */
const PAGES = readdirSync(path.join(ROOT, 'docs'), { recursive: true })
  .filter((name) => name.endsWith('.md') && !name.startsWith('api'))
  .map((name) => `docs/${name.replaceAll(path.sep, '/')}`);
const OTHERS = [
  'CHANGELOG.md',
  'CONTRIBUTING.md',
  'SECURITY.md',
  'www/README.md',
  'python/README.md',
  'capi/README.md',
  'benches/RESULTS.md',
  'paper/RESULTS.md',
];
const DOCUMENTS = [...SHORT, ...OTHERS, 'tests/fixtures/README.md', ...PAGES];

const read = (file) => readFileSync(path.join(ROOT, file), 'utf8');

/** What is wrong with a link of a document, or null. */
function fault(document, link) {
  if (/^https?:/.test(link)) return null;
  const [target, anchor] = link.split('#');
  const file = target === '' ? document : path.posix.join(path.posix.dirname(document), target);
  if (file.startsWith('..') || !existsSync(path.join(ROOT, file))) return `${document}: no file ${link}`;
  if (anchor === undefined || (file.endsWith('.md') && anchorsOf(read(file)).includes(anchor))) return null;
  return `${document}: no heading ${link}`;
}

/** Folders of source, whose files documents and comments name. */
const FOLDERS = ['benches', 'capi', 'crates', 'docs', 'examples', 'paper', 'python', 'scripts', 'shaders', 'src', 'tests', 'www'];
const IS_SOURCE = /\.(rs|wgsl|mjs|js|py)$/;
const FILES = FOLDERS.flatMap((folder) =>
  readdirSync(path.join(ROOT, folder), { recursive: true, withFileTypes: true })
    .filter((entry) => entry.isFile())
    .map((entry) => path.relative(ROOT, path.join(entry.parentPath, entry.name)).replaceAll(path.sep, '/')),
);

/** Names of source files in a text, such as `map.rs` or `stages/map.rs`; of source only in its comments. */
function namedIn(text, isSource) {
  const lines = text.split('\n').filter((line) => !isSource || /^\s*(\/\/|#|\*)/.test(line));
  return lines.flatMap((line) => [...line.matchAll(/`((?:[\w.-]+\/)*[\w-]+\.(?:rs|wgsl|mjs|py))`/g)].map((match) => match[1]));
}

test('source files that documents and comments name are there', () => {
  const ends = new Set(FILES.flatMap((file) => file.split('/').map((_, index, parts) => parts.slice(index).join('/'))));
  // the changelog says what was
  const texts = [...DOCUMENTS.filter((file) => !/CHANGELOG/.test(file)), ...FILES.filter((file) => IS_SOURCE.test(file))];
  const named = texts.flatMap((file) => namedIn(read(file), IS_SOURCE.test(file)).map((name) => [file, name]));
  assert.ok(named.length > 100, `${named.length}`);
  assert.deepEqual(
    named.filter(([, name]) => !ends.has(name)),
    [],
  );
  assert.deepEqual(namedIn('see `a/b.rs` and `c.rs`\n// not `d.js`, `e.mjs`', false), ['a/b.rs', 'c.rs', 'e.mjs']);
  assert.deepEqual(namedIn('see `a.rs`\n// `b.rs`', true), ['b.rs']);
});

test('documents that are read first are short', () => {
  for (const file of SHORT) {
    const n = read(file).trimEnd().split('\n').length;
    assert.ok(n <= MOST_LINES, `${file} has ${n} lines, of ${MOST_LINES}`);
  }
});

for (const document of DOCUMENTS) {
  test(`every link of ${document} leads to a file, and to a heading of it`, () => {
    const faults = linksOf(read(document)).map((link) => fault(document, link));
    assert.deepEqual(
      faults.filter((found) => found !== null),
      [],
    );
  });
}

test('every page of docs/ is in SUMMARY.md once, and what is there is a page', () => {
  const listed = linksOf(read('docs/SUMMARY.md')).map((link) => path.posix.join('docs', link));
  const pages = PAGES.filter((page) => page !== 'docs/SUMMARY.md');
  assert.ok(pages.length > 30, pages.join(' '));
  assert.deepEqual(listed.filter((page) => page.startsWith('docs/')).sort(), pages.sort());
  assert.deepEqual(
    listed.filter((page) => !DOCUMENTS.includes(page)),
    [],
  );
});

test('the index leads to every page of docs/ but single formats of solvers', () => {
  const linked = linksOf(read('docs/index.md')).map((link) => path.posix.join('docs', link));
  const expected = PAGES.filter((page) => !/SUMMARY|index|export\/[^R]/.test(page));
  assert.deepEqual(
    expected.filter((page) => !linked.includes(page)),
    [],
  );
});

test('a link that leads nowhere is found, and code has no links', () => {
  assert.equal(fault('README.md', 'docs/index.md'), null);
  assert.equal(fault('docs/links.md', 'exactness.md#exactness'), null);
  assert.equal(fault('README.md', 'docs/none.md'), 'README.md: no file docs/none.md');
  assert.equal(fault('README.md', '../hexcast/README.md'), 'README.md: no file ../hexcast/README.md');
  assert.equal(fault('README.md', 'docs/index.md#none'), 'README.md: no heading docs/index.md#none');
  assert.equal(fault('README.md', '#none'), 'README.md: no heading #none');
  const text =
    '# A `b` & c\n\n## [D](d.md)!\n\n## A b  c\n\nSee [x](x.md#y), `[z](z.md)` and ![p](p.png).\n\n    [i](i.md)\n\n```md\n# E\n[f](f.md)\n```\n';
  assert.deepEqual(linksOf(text), ['d.md', 'x.md#y', 'p.png']);
  assert.deepEqual(anchorsOf(text), ['a-b--c', 'd', 'a-b--c-1']);
  assert.deepEqual(linksOf(withLinks(text, (link) => `to/${link}`)), ['to/d.md', 'to/x.md#y', 'to/p.png']);
});

test('the version of CITATION.cff is that of the crates, and the forms for issues ask for the machine', () => {
  const [, version] = /^\[workspace\.package\]\nversion = "(.+)"$/m.exec(read('Cargo.toml')) ?? [];
  assert.match(read('CITATION.cff'), new RegExp(`^version: ${version?.replaceAll('.', '\\.')}$`, 'm'));
  for (const form of ['fault', 'wrong_cells']) {
    assert.match(read(`.github/ISSUE_TEMPLATE/${form}.yml`), /label: What does `hexcast adapters --report` print\?/);
  }
});

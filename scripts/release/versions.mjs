// The version of all packages: Cargo.toml says it, and every other place is held to it. "node scripts/release/versions.mjs 0.2.0" writes it
// everywhere, "--notes" prints what the changelog says of it. The changelog must have something to say.

import { readFileSync, writeFileSync } from 'node:fs';
import path from 'node:path';
import { fileURLToPath } from 'node:url';

import { ROOT } from '../run.mjs';

const SOURCE = /^\[workspace\.package\]\nversion = "(.+)"$/m;
const OF_CRATE = /hexcast[\w-]* = \{ path = "[^"]+", version = "([^"]+)"/g;
const OF_LOCK = /^name = "hexcast[\w-]*"\nversion = "([^"]+)"$/gm;

/** Where else it is: a file, what finds the version in it, and how often it is there. @type {[string, RegExp, number][]} */
const PLACES = [
  ['Cargo.toml', OF_CRATE, 5],
  ['Cargo.lock', OF_LOCK, 8],
  ['python/Cargo.toml', OF_CRATE, 1],
  ['capi/Cargo.toml', OF_CRATE, 1],
  ['package.json', /^ {2}"version": "([^"]+)"/gm, 1],
  ['package-lock.json', /"name": "hexcast",\n +"version": "([^"]+)"/g, 2],
  ['www/hexcast.js', /^export const version = '([^']+)';$/gm, 1],
  ['capi/include/hexcast.h', /HEXCAST_VERSION_STRING "([^"]+)"/g, 1],
  ['capi/fortran/hexcast.f90', /hexcast_version_string = '([^']+)'/g, 1],
  ['capi/README.md', /lib\/libhexcast(?:\.so)?\.(\d+\.\d+\.\d+)/g, 2],
  ['CITATION.cff', /^version: (.+)$/gm, 1],
];
/** The numbers of it, one by one. @type {[string, RegExp][]} */
const PARTS = [
  ['capi/include/hexcast.h', /HEXCAST_VERSION_(?:MAJOR|MINOR|PATCH) (\d+)/g],
  ['capi/fortran/hexcast.f90', /hexcast_version_(?:major|minor|patch) = (\d+)/g],
];

const read = (/** @type {string} */ file) => readFileSync(path.join(ROOT, file), 'utf8');
/** What the groups of a pattern hold. @param {string} file @param {RegExp} pattern */
const found = (file, pattern) => [...read(file).matchAll(pattern)].map((match) => match[1]);

/** The version of Cargo.toml. */
export function version() {
  const [, is] = SOURCE.exec(read('Cargo.toml')) ?? [];
  if (!is) throw new Error('Cargo.toml has no version in [workspace.package]');
  return is;
}

/** Where another version is than that of Cargo.toml: a sentence each. @param {string} [wanted] @returns {string[]} */
export function versionFaults(wanted = version()) {
  const whole = PLACES.map(([file, pattern, n]) => [file, found(file, pattern).join(' '), Array(n).fill(wanted).join(' ')]);
  const parts = PARTS.map(([file, pattern]) => [file, found(file, pattern).join('.'), wanted.replace(/[-+].*$/, '')]);
  return [...whole, ...parts]
    .filter(([, is, expected]) => is !== expected)
    .map(
      ([file, is, expected]) =>
        `${file} has the version ${is || 'nowhere'}, not ${expected}: run "node scripts/release/versions.mjs ${wanted}"`,
    );
}

/**
 * What is wrong with a changelog. A release needs a section with its version and day; before one, "Unreleased" must say what changed.
 *
 * @param {string} of the version @param {boolean} isRelease @param {string} [text] @returns {string[]}
 */
export function changelogFaults(of, isRelease, text = read('CHANGELOG.md')) {
  const sections = text.split(/^## /m).slice(1);
  const says = (/** @type {string} */ section) => /^- \S/m.test(section);
  const section = sections.find((some) => some.startsWith(`[${of}]`));
  if (section) {
    const dated = /^\[[^\]]+\] - \d{4}-\d\d-\d\d\n/.test(section);
    return [
      ...(dated ? [] : [`the section of ${of} in CHANGELOG.md has no day: write "## [${of}] - YYYY-MM-DD"`]),
      ...(says(section) ? [] : [`the section of ${of} in CHANGELOG.md says nothing`]),
    ];
  }
  if (isRelease) return [`CHANGELOG.md has no section of ${of}: rename "## [Unreleased]" to "## [${of}] - YYYY-MM-DD"`];
  const unreleased = sections.find((some) => some.startsWith('[Unreleased]'));
  return unreleased && says(unreleased)
    ? []
    : [`CHANGELOG.md has neither a section of ${of} nor anything under "## [Unreleased]"`];
}

/** What the changelog says of a version. @param {string} of @returns {string} */
export function notes(of, text = read('CHANGELOG.md')) {
  const section = text.split(/^## /m).find((some) => some.startsWith(`[${of}]`));
  if (!section) throw new Error(`CHANGELOG.md has no section of ${of}`);
  return section.replace(/^.*\n+/, '');
}

/** What else a release lacks. @param {string} tag @returns {string[]} */
export function releaseFaults(tag) {
  const [is, hasPlace] = [version(), /^repository = "https:\/\/.+"$/m.test(read('Cargo.toml'))];
  return [
    ...(tag === `v${is}`
      ? []
      : [`the tag is ${tag}, and the version v${is}: run "node scripts/release/versions.mjs ${tag.replace(/^v/, '')}"`]),
    ...(hasPlace
      ? []
      : ['Cargo.toml has no repository, where cargo-binstall looks for archives: write it into [workspace.package]']),
  ];
}

/** Writes a version everywhere. @param {string} wanted */
function write(wanted) {
  const is = version();
  const numbers = wanted.replace(/[-+].*$/, '').split('.');
  const change = (/** @type {string} */ file, /** @type {(text: string) => string} */ by) =>
    writeFileSync(path.join(ROOT, file), by(read(file)));
  const inMatch = (/** @type {RegExp} */ pattern, /** @type {() => string} */ next) => (/** @type {string} */ text) =>
    text.replace(
      pattern,
      (match, old) => match.slice(0, match.lastIndexOf(old)) + next() + match.slice(match.lastIndexOf(old) + old.length),
    );
  change('Cargo.toml', (text) => text.replace(SOURCE, (match) => match.replace(is, wanted)));
  for (const [file, pattern] of PLACES)
    change(
      file,
      inMatch(pattern, () => wanted),
    );
  for (const [file, pattern] of PARTS) {
    let index = 0;
    change(
      file,
      inMatch(pattern, () => numbers[index++]),
    );
  }
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  const [wanted] = process.argv.slice(2);
  if (wanted === '--notes') {
    process.stdout.write(notes(version()));
    process.exit(0);
  }
  if (wanted && !/^\d+\.\d+\.\d+(-[\w.]+)?$/.test(wanted)) {
    console.error(`"${wanted}" is no version: write one such as 0.2.0 or 0.2.0-rc.1`);
    process.exit(2);
  }
  if (wanted) write(wanted);
  const faults = versionFaults();
  for (const fault of faults) console.error(fault);
  if (faults.length > 0) process.exit(1);
  console.log(`${version()}, in all ${PLACES.length} files`);
}

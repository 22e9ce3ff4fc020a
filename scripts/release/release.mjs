// npm run release -- --dry: makes all that a release has for this machine, opens and uses each, and lists it with size, tag and test. What is made is in
// target/artefacts, with its SHA-256. .github/workflows/release.yml does the same on each system, on every change, and publishes on a tag.

import { createHash } from 'node:crypto';
import { existsSync, mkdirSync, readFileSync, readdirSync, rmSync, statSync, writeFileSync } from 'node:fs';
import path from 'node:path';
import { parseArgs } from 'node:util';

import { CommandFailed } from '../run.mjs';
import { OUT, differing } from './build.mjs';
import { makeC } from './c.mjs';
import { makeCommand } from './command.mjs';
import { makeCrates } from './crates.mjs';
import { makeImage } from './image.mjs';
import { makeNpm } from './npm.mjs';
import { ensureReleaseTools } from './tools.mjs';
import { changelogFaults, releaseFaults, version, versionFaults } from './versions.mjs';
import { makeSdist, makeWheel } from './wheel.mjs';

/** What was made: its file in `OUT`, for what it is, how it was tested; `size` of what is no file. @typedef {{ file: string, tag: string, test: string, size?: number }} Artefact */

/** What a release has. The image is made of the command, so that comes before. @type {Record<string, () => Promise<Artefact[]>>} */
const KINDS = {
  command: makeCommand,
  wheel: makeWheel,
  sdist: makeSdist,
  c: makeC,
  npm: makeNpm,
  crates: makeCrates,
  image: makeImage,
};
const SUMS = 'SHA256SUMS';

const HELP = `npm run release -- --dry [--only KIND,...] [--tag vVERSION] [--compare FOLDER]

  --dry             makes and tests all that a release has for this machine, and publishes nothing
  --only KIND,...   of these kinds alone: ${Object.keys(KINDS).join(', ')}
  --tag vVERSION    as for a release: the tag is that of Cargo.toml, and CHANGELOG.md has its section
  --compare FOLDER  names what differs from the artefacts of another run, and fails where something does

A release is published by .github/workflows/release.yml, for a tag such as v${version()}.`;

const { values } = parseArgs({
  options: {
    dry: { type: 'boolean' },
    only: { type: 'string' },
    tag: { type: 'string' },
    compare: { type: 'string' },
    help: { type: 'boolean', short: 'h' },
  },
});
const kinds = values.only?.split(',') ?? Object.keys(KINDS);
const unknown = kinds.filter((kind) => !(kind in KINDS));
if (values.help || !values.dry || unknown.length > 0) {
  if (unknown.length > 0) console.error(`no such kind: ${unknown.join(', ')}\n`);
  else if (!values.help) console.error('nothing is published from here: add --dry to make and test what a release has\n');
  console[values.help ? 'log' : 'error'](HELP);
  process.exit(values.help ? 0 : 2);
}

/** Versions, changelog and, for a release, what it needs besides. */
async function checkTexts() {
  const { tag } = values;
  const faults = [
    ...versionFaults(),
    ...changelogFaults(version(), tag !== undefined),
    ...(tag === undefined ? [] : releaseFaults(tag)),
  ];
  if (faults.length > 0) throw new Error(faults.join('\n'));
  return `${version()} in all files, and the changelog`;
}

/** Runs one step; the first failure ends the whole, with code 1. @template T @param {string} name @param {() => Promise<T>} action @returns {Promise<T>} */
async function step(name, action) {
  const start = Date.now();
  console.log(`${name} ...`);
  try {
    const made = await action();
    console.log(`${name}: ${((Date.now() - start) / 1000).toFixed(1)} s${typeof made === 'string' ? `, ${made}` : ''}`);
    return made;
  } catch (error) {
    if (error instanceof Error && 'output' in error) console.log(error.output);
    console.log(
      `${name}: FAILED\n${error instanceof CommandFailed ? error.message : error instanceof Error ? error.stack : error}`,
    );
    process.exit(1);
  }
}

/** The SHA-256 of all artefacts, as `sha256sum --check` reads it. */
function sums() {
  const files = readdirSync(OUT)
    .filter((name) => name !== SUMS)
    .sort();
  return files
    .map(
      (name) =>
        `${createHash('sha256')
          .update(readFileSync(path.join(OUT, name)))
          .digest('hex')}  ${name}\n`,
    )
    .join('');
}

/** Compares all artefacts with those of another run. @param {string} folder @returns {Promise<string[]>} a sentence for each that differs */
async function compared(folder) {
  const names = readdirSync(OUT).filter((name) => name !== SUMS);
  const faults = [];
  for (const name of names) {
    const [one, other] = [OUT, folder].map((of) => path.join(of, name));
    if (!existsSync(other)) faults.push(`${name} is not in ${folder}`);
    else if (!readFileSync(one).equals(readFileSync(other))) {
      faults.push(`${name} differs: ${(await differing(one, other)).join(', ') || 'its compression alone'}`);
    }
  }
  return faults;
}

/** Sizes, tags and tests, as a table. @param {Artefact[]} artefacts */
function table(artefacts) {
  const rows = artefacts.map(({ file, tag, test, size = statSync(path.join(OUT, file), { throwIfNoEntry: false })?.size }) => [
    file,
    size === undefined ? '-' : `${(size / 1e6).toFixed(2)} MB`,
    tag,
    test,
  ]);
  const all = [['artefact', 'size', 'tag', 'test'], ...rows];
  const widths = [0, 1, 2].map((column) => Math.max(...all.map((row) => row[column].length)));
  return all
    .map((row) =>
      row.map((cell, column) => (column === 1 ? cell.padStart(widths[1]) : cell.padEnd(widths[column] ?? 0))).join('  '),
    )
    .join('\n');
}

await step('versions and changelog', checkTexts);
await step('tools', ensureReleaseTools);
rmSync(OUT, { recursive: true, force: true });
mkdirSync(OUT, { recursive: true });
/** @type {Artefact[]} */
const artefacts = [];
for (const kind of Object.keys(KINDS).filter((name) => kinds.includes(name))) artefacts.push(...(await step(kind, KINDS[kind])));
writeFileSync(path.join(OUT, SUMS), sums());
console.log(`\n${table(artefacts)}\n\n${artefacts.length} artefacts, their SHA-256 in ${path.join(OUT, SUMS)}`);
const { compare } = values;
if (compare !== undefined) {
  const differences = await compared(compare);
  console.log(differences.join('\n') || `the same bytes as in ${compare}`);
  if (differences.length > 0) process.exit(1);
}
process.exit(0);

// What is compiled for a release, for this machine: on Linux with zig as linker, so that glibc 2.28 suffices (RHEL 8, Debian 10), and without
// the names of folders of this machine, so that a commit gives the same bytes elsewhere.

import { spawnSync } from 'node:child_process';
import { existsSync, mkdirSync, readdirSync, rmSync } from 'node:fs';
import { homedir } from 'node:os';
import path from 'node:path';

import { PYTHON } from '../python.mjs';
import { ROOT, run } from '../run.mjs';
import { program, toolsEnv } from './tools.mjs';

/** Where artefacts are put. */
export const OUT = path.join(ROOT, 'target/artefacts');
/** Where they are put together, opened and used. */
const WORK = path.join(ROOT, 'target/release-work');
export const IS_LINUX = process.platform === 'linux';
export const IS_WINDOWS = process.platform === 'win32';
/** The oldest glibc that runs what is released. */
export const GLIBC = '2.28';
/** The profile of what is released. */
export const PROFILE = 'dist';

/** All that a short command prints. @param {string} command @param {string[]} args */
export function said(command, args) {
  const { status, stdout, stderr } = spawnSync(command, args, { cwd: ROOT, encoding: 'utf8', maxBuffer: 1 << 28 });
  if (status !== 0) throw Object.assign(new Error(`"${command} ${args.join(' ')}" failed`), { output: stderr });
  return stdout;
}

const RUSTC = said('rustc', ['-vV']);
/** How cargo names this machine. */
export const TRIPLE = /^host: (.+)$/m.exec(RUSTC)?.[1] ?? '';
/** Seconds from 1970 to this commit: the time of all files in archives. */
export const COMMITTED = said('git', ['log', '-1', '--format=%ct']).trim();

/** An empty folder of a name. @param {string} name @returns {string} its path */
export function fresh(name) {
  const folder = path.join(WORK, name);
  rmSync(folder, { recursive: true, force: true });
  mkdirSync(folder, { recursive: true });
  return folder;
}

/** The environment of what is compiled. @returns {Record<string, string>} */
export function buildEnv() {
  const registry = path.join(process.env.CARGO_HOME ?? path.join(homedir(), '.cargo'), 'registry/src');
  const folders = existsSync(registry) ? readdirSync(registry).map((name) => path.join(registry, name)) : [];
  // the standard library's own sources, where they are installed, have the name that they have where they are not
  const library = path.join(said('rustc', ['--print', 'sysroot']).trim(), 'lib/rustlib/src/rust');
  const names = [
    ...folders.map((folder) => `${folder}=`),
    `${ROOT}=`,
    `${library}=/rustc/${/^commit-hash: (.+)$/m.exec(RUSTC)?.[1]}`,
  ];
  const flags = names.map((name) => `--remap-path-prefix=${name}`);
  return { ...toolsEnv(), SOURCE_DATE_EPOCH: COMMITTED, CARGO_ENCODED_RUSTFLAGS: flags.join('\x1f') };
}

/** Compiles a package of the workspace. @param {string[]} args which, and how @returns {Promise<string[]>} paths of what can be run or linked */
export async function compile(...args) {
  const common = ['--profile', PROFILE, '--locked', '--message-format', 'json-render-diagnostics', ...args];
  const printed = IS_LINUX
    ? await run(program('cargo-zigbuild'), ['zigbuild', '--target', `${TRIPLE}.${GLIBC}`, ...common], { env: buildEnv() })
    : await run('cargo', ['build', '--target', TRIPLE, ...common], { env: buildEnv() });
  const artifacts = printed
    .split('\n')
    .filter((line) => line.startsWith('{"reason":"compiler-artifact"'))
    .map((line) => JSON.parse(line));
  const last = artifacts.filter(({ target }) => target.kind.some((/** @type {string} */ kind) => /bin|cdylib/.test(kind))).at(-1);
  if (!last) throw Object.assign(new Error(`cargo made nothing of ${args.join(' ')}`), { output: printed });
  return last.filenames;
}

/** @param {string[]} args of archive.py */
const archive = (...args) => run(PYTHON, [path.join(ROOT, 'scripts/release/archive.py'), ...args]);

/** Makes an archive of a folder, in `OUT`. @param {string} folder @returns {Promise<string>} its path */
export async function packed(folder) {
  const file = path.join(OUT, `${path.basename(folder)}${IS_WINDOWS ? '.zip' : '.tar.gz'}`);
  await archive('pack', folder, file, COMMITTED);
  return file;
}

/** Opens an archive in an empty folder. @param {string} file @returns {Promise<string>} the folder in it */
export async function opened(file) {
  const folder = fresh(`opened-${path.basename(file).replace(/\W/g, '_')}`);
  await archive('unpack', file, folder);
  const [name, ...others] = readdirSync(folder);
  if (!name || others.length > 0)
    throw new Error(`${path.basename(file)} has ${others.length + 1} entries at its root, not one folder`);
  return path.join(folder, name);
}

/** The members that differ between two archives. @param {string} one @param {string} other */
export async function differing(one, other) {
  return (await archive('differ', one, other)).trim().split('\n');
}

/** Fails where a program or library needs a newer glibc than what is released may. @param {string} file @returns {Promise<string>} what it needs */
export async function checkGlibc(file) {
  if (!IS_LINUX) return `for ${process.platform}`;
  const versions = [...(await run('readelf', ['--version-info', '--wide', file])).matchAll(/GLIBC_(\d+)\.(\d+)/g)];
  const newest = Math.max(...versions.map(([, , minor]) => Number(minor)));
  if (versions.length === 0 || newest > Number(GLIBC.split('.')[1])) {
    throw new Error(`${path.basename(file)} needs glibc 2.${newest}, and may need ${GLIBC} at most: compile it with zig`);
  }
  return `glibc 2.${newest}`;
}

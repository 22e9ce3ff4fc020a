// Rust for wasm32: which compiler, which flags, and the wasm-bindgen tools of the same version as the crate.
//
// A rustup toolchain with the target is used as it is. Where rustup cannot download the target, Debian's rustc-web does, building
// the standard library from rust-web-src. HEXCAST_WASM_RUST=rustup|debian decides instead. The wasm whose threads share memory needs a standard
// library that is built for them: a rustup toolchain must have its source, else Debian's is taken.

import { existsSync, readFileSync, readdirSync } from 'node:fs';
import { homedir } from 'node:os';
import path from 'node:path';

import { DEBIAN_RUST, ensure } from './machine.mjs';
import { ROOT, ask, run, which } from './run.mjs';

const TARGET = 'wasm32-unknown-unknown';
/** Seconds that rustup gets to download the target. */
const RUSTUP_SECONDS = 30;
/** The same for what is shipped, tested and linted, so that nothing is compiled twice. */
const BUILD_STD = '-Zbuild-std=std,panic_abort';
const CARGO_ARGS = `--target ${TARGET} --target-dir target/wasm --profile wasm --no-default-features --features web`.split(' ');

/** What the wasm with threads is compiled with besides: atomics, and memory that its maker gives it, of up to 4 GiB. */
const OF_THREADS = [
  '-Ctarget-feature=+atomics,+bulk-memory,+mutable-globals',
  ...['--shared-memory', '--import-memory', '--max-memory=4294967296'].map((option) => `-Clink-arg=${option}`),
  // wasm-bindgen gives each thread its own
  ...['__wasm_init_tls', '__tls_size', '__tls_align', '__tls_base'].map((name) => `-Clink-arg=--export=${name}`),
];

/** The flags of a compiler; where it panics, sources are named without the folders of this machine. @param {string} rustc */
function environment(rustc) {
  const registry = path.join(process.env.CARGO_HOME ?? path.join(homedir(), '.cargo'), 'registry/src');
  const folders = existsSync(registry) ? readdirSync(registry).map((name) => path.join(registry, name)) : [];
  const sysroot = ask(rustc, ['--print', 'sysroot']);
  if (sysroot) folders.push(path.join(sysroot, 'lib/rustlib/src/rust/library'));
  const flags = ['-Ctarget-feature=+simd128', ...folders.map((folder) => `--remap-path-prefix=${folder}=`)];
  return { CARGO_ENCODED_RUSTFLAGS: flags.join('\x1f') };
}

/**
 * @typedef {object} Rust a Rust that compiles to wasm32
 * @property {string} name for people
 * @property {string} cargo path
 * @property {string} cargoClippy path
 * @property {string[]} args arguments of every cargo command
 * @property {Record<string, string>} env
 */

/** @type {Promise<Rust> | null} */
let chosen = null;

/** @type {Promise<Rust> | null} */
let chosenForThreads = null;

/** The Rust that compiles the wasm with threads, in a folder of its own. @returns {Promise<Rust>} */
export function threadsRust() {
  chosenForThreads ??= (async () => {
    const plain = await wasmRust();
    const rust = plain.args.includes(BUILD_STD) || (await hasSource()) ? plain : await debianRust();
    const args = rust.args.map((argument) => (argument === 'target/wasm' ? 'target/wasm-threads' : argument));
    const flags = [rust.env.CARGO_ENCODED_RUSTFLAGS, ...OF_THREADS].join('\x1f');
    return {
      ...rust,
      args: args.includes(BUILD_STD) ? args : [...args, BUILD_STD],
      env: { ...rust.env, RUSTC_BOOTSTRAP: '1', CARGO_ENCODED_RUSTFLAGS: flags },
    };
  })();
  return chosenForThreads;
}

/** Chooses the Rust that compiles to wasm32; installs it if need be. @returns {Promise<Rust>} */
export function wasmRust() {
  chosen ??= choose();
  return chosen;
}

/** @returns {Promise<Rust>} */
async function choose() {
  const wanted = process.env.HEXCAST_WASM_RUST;
  if (wanted !== 'debian' && (hasTarget() || (await addTarget()))) {
    const name = ask('rustc', ['--version']) ?? 'rustc';
    return { name, cargo: 'cargo', cargoClippy: 'cargo-clippy', args: CARGO_ARGS, env: environment('rustc') };
  }
  if (wanted === 'rustup') throw new Error(`missing: Rust's target ${TARGET}. Run "rustup target add ${TARGET}"`);
  return debianRust();
}

/** @returns {Promise<Rust>} */
async function debianRust() {
  await ensure('wasm32');
  const { rustc, cargo, cargoClippy, linker } = DEBIAN_RUST;
  // building the standard library is behind a switch of the nightly compiler, which RUSTC_BOOTSTRAP opens
  const env = {
    ...environment(rustc),
    RUSTC_BOOTSTRAP: '1',
    RUSTC: rustc,
    CARGO: cargo,
    CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_LINKER: linker,
  };
  return {
    name: ask(rustc, ['--version']) ?? rustc,
    cargo,
    cargoClippy,
    args: [...CARGO_ARGS, BUILD_STD],
    env,
  };
}

function hasTarget() {
  const sysroot = ask('rustc', ['--print', 'sysroot']);
  return sysroot !== null && existsSync(path.join(sysroot, 'lib/rustlib', TARGET, 'lib'));
}

/** Whether the rustup toolchain has the source of its standard library, or can get it. */
async function hasSource() {
  const source = () =>
    existsSync(path.join(ask('rustc', ['--print', 'sysroot']) ?? '', 'lib/rustlib/src/rust/library/Cargo.lock'));
  if (source() || !which('rustup')) return source();
  await run('rustup', ['component', 'add', 'rust-src'], { silence: RUSTUP_SECONDS / 60 }).catch(() => {});
  return source();
}

async function addTarget() {
  if (!which('rustup')) return false;
  // without a network Debian's compiler may do
  await run('rustup', ['target', 'add', TARGET], { silence: RUSTUP_SECONDS / 60 }).catch(() => {});
  return hasTarget();
}

/** Path of a program of wasm-bindgen, of the crate's version once `ensureBindgen` has run. @param {string} name */
export function bindgenTool(name) {
  return path.join(ROOT, '.tools/bin', name);
}

/**
 * Installs wasm-bindgen unless it has the version of the crate: its two halves understand no other.
 *
 * @returns {Promise<string>} path of wasm-bindgen
 */
export async function ensureBindgen() {
  const lock = readFileSync(path.join(ROOT, 'Cargo.lock'), 'utf8');
  const version = /name = "wasm-bindgen"\r?\nversion = "([^"]+)"/.exec(lock)?.[1];
  if (!version) throw new Error('Cargo.lock has no wasm-bindgen');
  const tool = bindgenTool('wasm-bindgen');
  if (ask(tool, ['--version']) !== `wasm-bindgen ${version}`) {
    // without --locked: a mirror of the registry may not have the very newest of its dependencies yet
    const args = ['install', 'wasm-bindgen-cli', '--version', version, '--root', path.join(ROOT, '.tools'), '--force'];
    await run('cargo', args);
  }
  return tool;
}

/** Compiles the library to wasm, of one thread or of many. @param {boolean} hasThreads @returns {Promise<string>} its path */
export async function compileWasm(hasThreads) {
  const { cargo, args, env } = await (hasThreads ? threadsRust() : wasmRust());
  // a library that is an rlib too would be compiled without link-time optimisation
  await run(cargo, ['rustc', '--lib', '--crate-type', 'cdylib', ...args], { env });
  return path.join(ROOT, hasThreads ? 'target/wasm-threads' : 'target/wasm', TARGET, 'wasm/hexcast.wasm');
}

/** Runs clippy on all that is compiled to wasm; warnings are failures. */
export async function clippyWasm() {
  const { cargoClippy, args, env } = await wasmRust();
  await run(cargoClippy, ['clippy', ...args, '--lib', '--test', 'web', '--', '-D', 'warnings'], { env });
}

/** Compiles the browser tests and returns the path of their wasm file. */
export async function compileWasmTests() {
  const { cargo, args, env } = await wasmRust();
  const output = await run(cargo, ['test', '--test', 'web', ...args, '--no-run', '--message-format', 'json'], { env });
  const artifacts = output
    .split('\n')
    .filter((line) => line.startsWith('{'))
    .map((line) => JSON.parse(line));
  return artifacts.find(({ target, executable }) => target?.name === 'web' && executable).executable;
}

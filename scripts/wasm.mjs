// Rust for wasm32: which compiler, which flags, and the wasm-bindgen tools of the same version as the crate.
//
// A rustup toolchain with the target is used as it is. Where rustup cannot download the target, Debian's rustc-web does, building
// the standard library from rust-web-src. HEXCAST_WASM_RUST=rustup|debian decides instead.

import { existsSync, readFileSync, readdirSync } from 'node:fs';
import { homedir } from 'node:os';
import path from 'node:path';

import { DEBIAN_RUST, ensure } from './machine.mjs';
import { ROOT, ask, run, which } from './run.mjs';

const TARGET = 'wasm32-unknown-unknown';
/** Seconds that rustup gets to download the target. */
const RUSTUP_SECONDS = 30;
/** The same for what is shipped, tested and linted, so that nothing is compiled twice. */
const CARGO_ARGS = `--target ${TARGET} --target-dir target/wasm --profile wasm --no-default-features --features web`.split(' ');

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
    args: [...CARGO_ARGS, '-Zbuild-std=std,panic_abort'],
    env,
  };
}

function hasTarget() {
  const sysroot = ask('rustc', ['--print', 'sysroot']);
  return sysroot !== null && existsSync(path.join(sysroot, 'lib/rustlib', TARGET, 'lib'));
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

/** Compiles the library to wasm. @returns {Promise<string>} its path */
export async function compileWasm() {
  const { cargo, args, env } = await wasmRust();
  // a library that is an rlib too would be compiled without link-time optimisation
  await run(cargo, ['rustc', '--lib', '--crate-type', 'cdylib', ...args], { env });
  return path.join(ROOT, 'target/wasm', TARGET, 'wasm/hexcast.wasm');
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

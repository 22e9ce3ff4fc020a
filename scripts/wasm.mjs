// Rust for wasm32: which compiler, which flags, and the wasm-bindgen tools of the same version as the crate.
//
// A rustup toolchain with the target is used as it is. Where the target cannot be had from rustup, Debian's
// rustc-web does, building the standard library from rust-web-src. HEXCAST_WASM_RUST=rustup|debian decides instead.
//
// What is shipped is compiled by itself: with the source of the standard library at hand, that is compiled for size too, and
// a panic, whose message nobody could read anyway, is a mere trap. That takes some 70 kB off the file; sorting takes longer.

import { existsSync, readFileSync } from 'node:fs';
import path from 'node:path';

import { DEBIAN_RUST, ensure, has } from './machine.mjs';
import { ROOT, ask, run, which } from './run.mjs';

const TARGET = 'wasm32-unknown-unknown';
const RUSTFLAGS = 'CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_RUSTFLAGS';
/** Seconds that rustup gets to download the target, and the source of the standard library. */
const RUSTUP_SECONDS = 30;
/** One set of these for all tests and lints, so that nothing is compiled twice. */
const CARGO_ARGS = ['--target', TARGET, '--target-dir', 'target/wasm', '--profile', 'wasm', '--no-default-features'];
/** What is shipped and what is tested. */
const WEB = ['--features', 'web'];
/** Flags of the compiler for what is shipped; behind the same switch as building the standard library. */
const TRAP_FLAGS = ['-Zunstable-options', '-Cpanic=immediate-abort', '-Zlocation-detail=none'];
const BOOTSTRAP = { RUSTC_BOOTSTRAP: '1' };

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

async function choose() {
  const wanted = process.env.HEXCAST_WASM_RUST;
  if (wanted !== 'debian' && (hasTarget() || (await addTarget()))) return rustup();
  if (wanted === 'rustup') throw new Error(`missing: Rust's target ${TARGET}. Run "rustup target add ${TARGET}"`);
  await ensure('wasm32');
  return debian();
}

function hasTarget() {
  const sysroot = ask('rustc', ['--print', 'sysroot']);
  return sysroot !== null && existsSync(path.join(sysroot, 'lib/rustlib', TARGET, 'lib'));
}

async function addTarget() {
  if (!which('rustup')) return false;
  try {
    await run('rustup', ['target', 'add', TARGET], { minutes: RUSTUP_SECONDS / 60 });
  } catch {
    // no way to its server; Debian's compiler may do
  }
  return hasTarget();
}

/** @returns {Rust} */
function rustup() {
  return {
    name: ask('rustc', ['--version']) ?? 'rustc',
    cargo: 'cargo',
    cargoClippy: 'cargo-clippy',
    args: CARGO_ARGS,
    env: wasmEnv(),
  };
}

/** @returns {Rust} */
function debian() {
  const { rustc, cargo, cargoClippy, linker } = DEBIAN_RUST;
  // building the standard library is behind a switch of the nightly compiler, which this variable opens
  const env = { ...wasmEnv(), ...BOOTSTRAP, RUSTC: rustc, CARGO: cargo, CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_LINKER: linker };
  return {
    name: ask(rustc, ['--version']) ?? rustc,
    cargo,
    cargoClippy,
    args: [...CARGO_ARGS, '-Zbuild-std=std,panic_abort'],
    env,
  };
}

/** Chooses the Rust that compiles what is shipped; its standard library is rebuilt where its source can be had. */
async function shippingRust() {
  const rust = await wasmRust();
  const wanted = process.env.HEXCAST_WASM_RUST;
  if (wanted !== 'debian' && hasTarget() && hasSource()) return rebuilding(rustup());
  if (wanted !== 'rustup' && has('wasm32')) return rebuilding(debian());
  if (wanted !== 'debian' && hasTarget() && (await addSource())) return rebuilding(rustup());
  const isDebian =
    wanted !== 'rustup' &&
    (await ensure('wasm32').then(
      () => true,
      () => false,
    ));
  return isDebian ? rebuilding(debian()) : rust;
}

/** @param {Rust} rust @returns {Rust} */
function rebuilding(rust) {
  const flags = [rust.env[RUSTFLAGS], ...TRAP_FLAGS].join(' ');
  const args = rust.args.filter((argument) => !argument.startsWith('-Zbuild-std'));
  return {
    ...rust,
    args: [...args, '-Zbuild-std=std', '-Zbuild-std-features=optimize_for_size'],
    env: { ...rust.env, ...BOOTSTRAP, [RUSTFLAGS]: flags },
  };
}

/** Whether rustup's toolchain has the source of the standard library and knows the flags. */
function hasSource() {
  const sysroot = ask('rustc', ['--print', 'sysroot']);
  const hasFlags = ask('rustc', [...TRAP_FLAGS, '--target', TARGET, '--print', 'cfg'], BOOTSTRAP) !== null;
  return hasFlags && sysroot !== null && existsSync(path.join(sysroot, 'lib/rustlib/src/rust/library'));
}

async function addSource() {
  if (!which('rustup')) return false;
  try {
    await run('rustup', ['component', 'add', 'rust-src'], { minutes: RUSTUP_SECONDS / 60 });
  } catch {
    // no way to its server: without
  }
  return hasSource();
}

function wasmEnv() {
  return {
    [RUSTFLAGS]: '-C target-feature=+simd128',
    CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_RUNNER: bindgenTool('wasm-bindgen-test-runner'),
  };
}

/** Path of a program of wasm-bindgen, of the crate's version once `ensureBindgen` has run. @param {string} name */
export function bindgenTool(name) {
  return path.join(ROOT, '.tools/bin', name);
}

/**
 * Sees to it that wasm-bindgen has the version of the crate: its two halves understand no other.
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
    await run('cargo', args, { minutes: 30 });
  }
  return tool;
}

/** Compiles the library to wasm. @returns {Promise<string>} its path */
export async function compileWasm() {
  const rust = await shippingRust();
  // a library that is an rlib too would be compiled without link-time optimisation
  await run(rust.cargo, ['rustc', '--lib', '--crate-type', 'cdylib', ...rust.args, ...WEB], { env: rust.env });
  return path.join(ROOT, 'target/wasm', TARGET, 'wasm/hexcast.wasm');
}

/** Runs clippy on all that is compiled to wasm; warnings are failures. */
export async function clippyWasm() {
  const rust = await wasmRust();
  await run(rust.cargoClippy, ['clippy', ...rust.args, '--lib', '--test', 'web', ...WEB, '--', '-D', 'warnings'], {
    env: rust.env,
  });
}

/** Runs the browser tests in Chromium and returns what they printed. @param {string} chromedriver */
export async function testWasm(chromedriver) {
  const rust = await wasmRust();
  const env = {
    ...rust.env,
    CHROMEDRIVER: chromedriver,
    WASM_BINDGEN_TEST_WEBDRIVER_JSON: path.join(ROOT, 'tests/web/webdriver.json'),
    WASM_BINDGEN_TEST_TIMEOUT: '900',
  };
  return run(rust.cargo, ['test', '--test', 'web', ...rust.args, ...WEB, '--', '--nocapture'], { env });
}

/** Compiles the browser tests and returns the path of their wasm file. */
export async function compileWasmTests() {
  const rust = await wasmRust();
  const output = await run(rust.cargo, ['test', '--test', 'web', ...rust.args, ...WEB, '--no-run', '--message-format', 'json'], {
    env: rust.env,
  });
  const artifacts = output
    .split('\n')
    .filter((line) => line.startsWith('{'))
    .map((line) => JSON.parse(line));
  return artifacts.find(({ target, executable }) => target?.name === 'web' && executable).executable;
}

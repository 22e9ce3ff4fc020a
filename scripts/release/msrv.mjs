// The oldest Rust that Cargo.toml promises compiles all crates.

import { createHash } from 'node:crypto';
import { existsSync, readFileSync, readdirSync, writeFileSync } from 'node:fs';
import path from 'node:path';

import { ROOT, ask, run } from '../run.mjs';

/** Seconds of silence that rustup gets to download it. */
const RUSTUP_SECONDS = 30;
const MANIFESTS = [
  'Cargo.toml',
  ...readdirSync(path.join(ROOT, 'crates'))
    .sort()
    .map((name) => `crates/${name}/Cargo.toml`),
  'python/Cargo.toml',
  'capi/Cargo.toml',
];
/** For which manifests and dependencies it was last found to compile: their hash. */
const RECORD = path.join(ROOT, 'scripts/release/oldest_rust.sha256');

const read = (/** @type {string} */ file) => readFileSync(path.join(ROOT, file), 'utf8');
/** A manifest without its profiles: how well it is optimised decides not whether it compiles. @param {string} text */
const withoutProfiles = (text) => text.replace(/^(#.*\n)*\[profile\b[^\n]*\n(?:(?!\[)[^\n]*(?:\n|$))*/gm, '').trimEnd();

/**
 * Checks all crates with it, unless manifests and Cargo.lock are those for which it last compiled: our own code is held to its library by
 * clippy's `incompatible_msrv`. Where it compiles, and CI is not set, that is recorded for others.
 */
export async function checkOldestRustIfChanged() {
  const hash = createHash('sha256');
  for (const file of [...MANIFESTS, 'Cargo.lock']) hash.update(withoutProfiles(read(file)));
  const state = `${hash.digest('hex')}\n`;
  if (existsSync(RECORD) && readFileSync(RECORD, 'utf8') === state)
    return 'compiled with these manifests and this Cargo.lock before';
  const checked = await checkOldestRust();
  if (checked.startsWith('Rust') && !process.env.CI) writeFileSync(RECORD, state);
  return checked;
}

/** Checks all crates with it, where rustup has it or can download it. @returns {Promise<string>} its version, or what is not checked */
export async function checkOldestRust() {
  const version = /^rust-version = "(.+)"$/m.exec(read('Cargo.toml'))?.[1];
  if (!version) throw new Error('Cargo.toml has no rust-version');
  const isThere = () => ask('rustup', ['run', version, 'cargo', '--version']) !== null;
  if (!isThere()) {
    const args = ['toolchain', 'install', version, '--profile', 'minimal'];
    await run('rustup', args, { silence: RUSTUP_SECONDS / 60 }).catch(() => {});
  }
  if (!isThere()) return `not checked: rustup has no Rust ${version} and cannot download it`;
  const check = ['run', version, 'cargo', 'check', '--locked', '--target-dir', 'target/msrv'];
  await run('rustup', [...check, '--workspace']);
  return `Rust ${version}`;
}

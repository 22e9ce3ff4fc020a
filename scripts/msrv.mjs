// The oldest Rust that Cargo.toml promises compiles all crates.

import { readFileSync } from 'node:fs';
import path from 'node:path';

import { ROOT, ask, run } from './run.mjs';

/** Seconds that rustup gets to download it. */
const RUSTUP_SECONDS = 30;

/** Checks all crates with it, where rustup has it or can download it. @returns {Promise<string>} its version, or what is not checked */
export async function checkOldestRust() {
  const manifests = ['Cargo.toml', 'python/Cargo.toml', 'capi/Cargo.toml'];
  const versions = manifests.map((file) => /^rust-version = "(.+)"$/m.exec(readFileSync(path.join(ROOT, file), 'utf8'))?.[1]);
  const [version] = versions;
  if (!version || versions.some((other) => other !== version)) throw new Error(`rust-version differs: ${versions.join(', ')}`);
  const isThere = () => ask('rustup', ['run', version, 'cargo', '--version']) !== null;
  if (!isThere()) {
    const args = ['toolchain', 'install', version, '--profile', 'minimal'];
    await run('rustup', args, { minutes: RUSTUP_SECONDS / 60 }).catch(() => {});
  }
  if (!isThere()) return `not checked: rustup has no Rust ${version} and cannot download it`;
  const check = ['run', version, 'cargo', 'check', '--locked', '--target-dir', 'target/msrv'];
  await run('rustup', [...check, '--workspace']);
  return `Rust ${version}`;
}

// The crates, as cargo publishes them, each built of what is packed.

import { cpSync, readdirSync, rmSync } from 'node:fs';
import path from 'node:path';

import { LIBRARY } from '../native.mjs';
import { run } from '../run.mjs';
import { OUT, said } from './build.mjs';
import { version } from './versions.mjs';

/** @typedef {import('./release.mjs').Artefact} Artefact */

/** Packs the crates, which cargo compiles of their packages, in the order of their dependencies. @returns {Promise<Artefact[]>} */
export async function makeCrates() {
  const { target_directory: target } = JSON.parse(said('cargo', ['metadata', '--format-version', '1', '--no-deps']));
  const folder = path.join(target, 'package');
  rmSync(folder, { recursive: true, force: true });
  // what is not committed is packed, too, where this is not a release
  await run('cargo', ['package', '--locked', ...LIBRARY, ...(process.env.CI ? [] : ['--allow-dirty'])]);
  const names = LIBRARY.filter((word) => word !== '--package').map((name) => `${name}-${version()}.crate`);
  const made = readdirSync(folder).filter((name) => name.endsWith('.crate'));
  const missing = names.filter((name) => !made.includes(name));
  if (missing.length > 0) throw new Error(`cargo package made ${made.join(', ')}, and no ${missing.join(', ')}`);
  for (const name of names) cpSync(path.join(folder, name), path.join(OUT, name));
  return names.map((file) => ({ file, tag: 'crate', test: 'compiled of its package' }));
}

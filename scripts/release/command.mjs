// The archive of the command: the program with S3, completions of shells, pages for man, licences and bill of materials.

import { cpSync, existsSync, mkdirSync, readFileSync, readdirSync, writeFileSync } from 'node:fs';
import path from 'node:path';

import { ROOT } from '../run.mjs';
import { IS_WINDOWS, OUT, TRIPLE, checkGlibc, compile, fresh, opened, packed, said } from './build.mjs';
import { testCommand } from './cube.mjs';
import { LICENCES, OWN_LICENCES, billOfMaterials, licences } from './notices.mjs';
import { version } from './versions.mjs';

/** Shells, and the names under which they look for completions. */
const SHELLS = { bash: 'hexcast.bash', zsh: '_hexcast', fish: 'hexcast.fish', powershell: '_hexcast.ps1', elvish: 'hexcast.elv' };
const PROGRAM = IS_WINDOWS ? 'hexcast.exe' : 'hexcast';
/** The folder in the archive, by which cargo-binstall finds the program: Cargo.toml has the same. */
const NAME = `hexcast-${version()}-${TRIPLE}`;

/** @typedef {import('./release.mjs').Artefact} Artefact */

/** @type {Promise<string> | null} */
let compiled = null;

/** Compiles the command, once in a process. @returns {Promise<string>} its path */
export function command() {
  compiled ??= compile('--package', 'hexcast', '--bin', 'hexcast', '--features', 's3').then(([built]) => built);
  return compiled;
}

/** Makes and tests the archive. @returns {Promise<Artefact[]>} */
export async function makeCommand() {
  const built = await command();
  const folder = path.join(fresh('command'), NAME);
  mkdirSync(path.join(folder, 'man'), { recursive: true });
  mkdirSync(path.join(folder, 'completions'));
  cpSync(built, path.join(folder, PROGRAM));
  for (const name of ['README.md', 'CHANGELOG.md', ...OWN_LICENCES]) cpSync(path.join(ROOT, name), path.join(folder, name));
  cpSync(await licences('command'), path.join(folder, LICENCES));
  const materials = await billOfMaterials('command');
  cpSync(materials, path.join(folder, path.basename(materials)));
  for (const [shell, name] of Object.entries(SHELLS))
    writeFileSync(path.join(folder, 'completions', name), said(built, ['completions', shell]));
  writeFileSync(path.join(folder, 'man/hexcast.1'), said(built, ['man']));
  for (const name of commandsOf(built)) writeFileSync(path.join(folder, `man/hexcast-${name}.1`), said(built, ['man', name]));

  const file = await packed(folder);
  const inside = await opened(file);
  const glibc = await checkGlibc(path.join(inside, PROGRAM));
  const tested = await testCommand(path.join(inside, PROGRAM));
  const pages = testExtras(inside);
  cpSync(materials, path.join(OUT, `${NAME}.cdx.json`));
  return [
    { file: path.basename(file), tag: `${TRIPLE}, ${glibc}`, test: `unpacked; ${tested}; ${pages}` },
    { file: `${NAME}.cdx.json`, tag: 'CycloneDX 1.5', test: 'its schema, and the crates of cargo tree' },
  ];
}

/** The commands that the help lists. @param {string} program */
function commandsOf(program) {
  const [, listed = ''] = /^Commands:\n((?: {2}.*\n)+)/m.exec(said(program, ['--help'])) ?? [];
  const names = [...listed.matchAll(/^ {2}([a-z][\w-]*)/gm)].map((match) => match[1]).filter((name) => name !== 'help');
  if (names.length < 10) throw new Error(`the help of the command lists only ${names.join(', ') || 'nothing'}`);
  return names;
}

/** Checks what lies beside the program. @param {string} inside the folder of the archive @returns {string} */
function testExtras(inside) {
  for (const name of Object.values(SHELLS)) {
    const text = readFileSync(path.join(inside, 'completions', name), 'utf8');
    if (!text.includes('verify-store')) throw new Error(`completions/${name} does not know the command verify-store`);
  }
  const pages = readdirSync(path.join(inside, 'man'));
  for (const page of pages) {
    if (!readFileSync(path.join(inside, 'man', page), 'utf8').includes('.TH hexcast'))
      throw new Error(`man/${page} is no page for man`);
  }
  for (const name of [LICENCES, ...OWN_LICENCES])
    if (!existsSync(path.join(inside, name))) throw new Error(`the archive has no ${name}`);
  return `${pages.length} pages for man, ${Object.keys(SHELLS).length} completions`;
}

// The archive of the C library: what capi/install.sh installs, with licences and bill of materials. The tests of the library run on the
// archive once it is unpacked.

import { cpSync, existsSync } from 'node:fs';
import path from 'node:path';

import { testInstall } from '../c/install.mjs';
import { filesOf, testC, testExamples, usePrefix } from '../c/library.mjs';
import { ROOT, run } from '../run.mjs';
import { IS_LINUX, OUT, PROFILE, TRIPLE, buildEnv, checkGlibc, compile, fresh, opened, packed } from './build.mjs';
import { command } from './command.mjs';
import { LICENCES, OWN_LICENCES, billOfMaterials, licences } from './notices.mjs';
import { version } from './versions.mjs';

/** @typedef {import('./release.mjs').Artefact} Artefact */

const NAME = `hexcast-c-${version()}-${TRIPLE}`;

/** Makes and tests the archive. @returns {Promise<Artefact[]>} */
export async function makeC() {
  const folder = path.join(fresh('c'), NAME);
  const how = IS_LINUX ? ['--built', await builtByZig()] : ['--target', TRIPLE, '--profile', PROFILE];
  await run('sh', ['capi/install.sh', '--prefix', folder.replaceAll('\\', '/'), ...how], { env: buildEnv() });
  cpSync(path.join(ROOT, 'capi/README.md'), path.join(folder, 'README.md'));
  for (const name of OWN_LICENCES) cpSync(path.join(ROOT, name), path.join(folder, name));
  cpSync(await licences('c'), path.join(folder, LICENCES));
  const materials = await billOfMaterials('c');
  cpSync(materials, path.join(folder, path.basename(materials)));

  const file = await packed(folder);
  const inside = await opened(file);
  cpSync(materials, path.join(OUT, `${NAME}.cdx.json`));
  return [
    {
      file: path.basename(file),
      tag: `${TRIPLE}, ${await checkGlibc(path.join(inside, `lib/libhexcast.so.${version()}`))}`,
      test: await testArchive(inside),
    },
    { file: `${NAME}.cdx.json`, tag: 'CycloneDX 1.5', test: 'its schema, and the crates of cargo tree' },
  ];
}

/** Compiles both libraries. @returns {Promise<string>} their folder */
async function builtByZig() {
  const [library] = await compile('--package', 'hexcast-c', '--lib');
  return path.dirname(library);
}

/** On Linux the tests of the library build programs in C, C++ and Fortran with the archive, and run them; elsewhere its files are looked for. @param {string} inside @returns {Promise<string>} */
async function testArchive(inside) {
  const wanted = [
    'include/hexcast.h',
    'share/hexcast/hexcast.f90',
    'lib/pkgconfig/hexcast.pc',
    'lib/cmake/hexcast/hexcast-config.cmake',
    LICENCES,
    ...OWN_LICENCES,
  ];
  const missing = wanted.filter((name) => !existsSync(path.join(inside, name)));
  if (missing.length > 0) throw new Error(`the archive of the C library has no ${missing.join(', ')}`);
  if (!IS_LINUX) return `unpacked, ${filesOf(inside).length} files; no program was built with it`;
  // what the meshes of the programs are compared with
  process.env.HEXCAST_COMMAND ??= await command();
  usePrefix(inside, 'lib');
  const n_checks = await testC();
  await testInstall();
  const cells = await testExamples();
  return `unpacked; C ${n_checks}, under valgrind; pkg-config, CMake and Fortran; ${cells}`;
}

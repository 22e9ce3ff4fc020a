// The npm package: the tarball with the licences of what its wasm is made of, and its bill of materials beside it.

import { cpSync, existsSync, writeFileSync } from 'node:fs';
import path from 'node:path';

import { build } from '../build.mjs';
import { pack } from '../package.mjs';
import { ROOT, run } from '../run.mjs';
import { OUT, fresh } from './build.mjs';
import { testNode } from './cube.mjs';
import { LICENCES, billOfMaterials, licences } from './notices.mjs';
import { version } from './versions.mjs';

/** @typedef {import('./release.mjs').Artefact} Artefact */

/** Makes and tests the tarball, of `dist/` as it is if it is there. @returns {Promise<Artefact[]>} */
export async function makeNpm() {
  if (!existsSync(path.join(ROOT, 'dist/hexcast_bg.wasm'))) await build();
  const { tarball, files } = pack(OUT, { [LICENCES]: await licences('npm') });
  if (!files.includes(LICENCES)) throw new Error(`the package has no ${LICENCES}`);
  const project = fresh('project');
  writeFileSync(path.join(project, 'package.json'), '{"private": true, "type": "module"}');
  await run('npm', ['install', '--offline', '--no-audit', '--no-fund', tarball], { cwd: project });
  const tested = await testNode(project);
  const materials = `hexcast-npm-${version()}.cdx.json`;
  cpSync(await billOfMaterials('npm'), path.join(OUT, materials));
  return [
    { file: path.basename(tarball), tag: 'npm', test: `installed in an empty project; ${tested}` },
    { file: materials, tag: 'CycloneDX 1.5', test: 'its schema, and the crates of cargo tree' },
  ];
}

// The Python package: the wheel, for glibc 2.28 on Linux, and the source distribution, of which the same wheel is built again.

import { cpSync, existsSync, readdirSync, rmSync } from 'node:fs';
import path from 'node:path';

import { PYTHON, programOf } from '../python.mjs';
import { ROOT, run } from '../run.mjs';
import { GLIBC, IS_LINUX, OUT, PROFILE, TRIPLE, buildEnv, differing, fresh, opened } from './build.mjs';
import { testPython } from './cube.mjs';
import { LICENCES, billOfMaterials, licences } from './notices.mjs';
import { program } from './tools.mjs';

/** @typedef {import('./release.mjs').Artefact} Artefact */

const [, GLIBC_MINOR] = GLIBC.split('.');
const COMPATIBLE = IS_LINUX ? ['--zig', '--compatibility', `manylinux_2_${GLIBC_MINOR}`] : [];
/** Beside the licences of hexcast, where maturin looks for what goes into the wheel. */
const PLACE = path.join(ROOT, 'python', LICENCES);

/** In a folder of its own: maturin hands other flags to the compiler than cargo-zigbuild, and each would compile again what the other had. */
const env = () => ({
  ...buildEnv(),
  CARGO_TARGET_DIR: path.join(process.env.CARGO_TARGET_DIR ?? path.join(ROOT, 'target'), 'of-wheels'),
});

/** Makes and tests the wheel. @returns {Promise<Artefact[]>} */
export async function makeWheel() {
  const materials = await billOfMaterials('wheel');
  const name = await wheelOf(path.join(ROOT, 'python'), OUT, await licences('wheel'), materials);
  const file = path.join(OUT, name);
  const tag = await tagOf(file);
  const python = await environment('wheel-installed', file);
  const tested = await testPython(python);
  const has = await run(python, [
    '-c',
    `import importlib.metadata as m; print(*[f.name for f in m.files("hexcast")], sep="\\n")`,
  ]);
  const bills = has.split(/\r?\n/).filter((file) => /(cdx|cyclonedx)\.json$/.test(file));
  if (bills.length !== 1) throw new Error(`the wheel has ${bills.length} bills of materials: ${bills.join(', ')}`);
  for (const wanted of [LICENCES, 'LICENSE-MIT', 'LICENSE-APACHE', path.basename(materials)]) {
    if (!has.split(/\r?\n/).includes(wanted)) throw Object.assign(new Error(`the wheel has no ${wanted}`), { output: has });
  }
  return [{ file: name, tag, test: `installed in an empty environment; ${tested}` }];
}

/** Makes the source distribution, and tests the wheel that is built of it. @returns {Promise<Artefact[]>} */
export async function makeSdist() {
  const to = fresh('sdist');
  await run(program('maturin'), ['sdist', '--manifest-path', 'python/Cargo.toml', '--out', to], { env: buildEnv() });
  const [name] = readdirSync(to);
  cpSync(path.join(to, name), path.join(OUT, name));
  const source = await opened(path.join(OUT, name));
  const built = fresh('wheel-of-sdist');
  const wheel = await wheelOf(source, built);
  const tested = await testPython(await environment('sdist-installed', path.join(built, wheel)));
  return [{ file: name, tag: 'source', test: `a wheel built of it; ${tested}; ${await likeWheel(path.join(built, wheel))}` }];
}

/** What differs between the wheel and that of the source distribution, which was built in another folder and has no licences of others. @param {string} built */
async function likeWheel(built) {
  const first = path.join(OUT, path.basename(built));
  if (!existsSync(first)) return 'not compared with the wheel, which was not made';
  const members = (await differing(first, built)).filter((name) => !/\.dist-info\//.test(name) && name !== '');
  return members.length > 0 ? `differs from the wheel in ${members.join(', ')}` : 'the same bytes as in the wheel';
}

/** Builds a wheel of a folder with a pyproject.toml; that of the source distribution lacks the C library, of which its Cargo.lock still knows. @param {string} folder @param {string} out @param {string} [text] of licences @param {string} [materials] @returns {Promise<string>} its name */
async function wheelOf(folder, out, text, materials) {
  const before = new Set(readdirSync(out));
  const args = ['build', '--profile', PROFILE, '--target', TRIPLE, ...COMPATIBLE, '--out', out];
  try {
    if (text) cpSync(text, PLACE);
    await run(program('maturin'), [...args, ...(materials ? ['--locked', '--sbom-include', materials] : [])], {
      cwd: folder,
      env: env(),
    });
  } finally {
    rmSync(PLACE, { force: true });
  }
  const [name] = readdirSync(out).filter((file) => file.endsWith('.whl') && !before.has(file));
  if (!name) throw new Error('maturin made no wheel');
  return name;
}

/** The platforms of a wheel: on Linux what auditwheel finds that it needs, which must be what its name says or older. @param {string} file */
async function tagOf(file) {
  const named = /-([^-]+)\.whl$/.exec(file)?.[1] ?? '';
  if (!IS_LINUX) return named;
  const says = await run(program('auditwheel'), ['show', file]);
  const found = /consistent with\s+the following platform tag:\s*"manylinux_2_(\d+)_/.exec(says.replaceAll('\n', ' '));
  if (!found || Number(found[1]) > Number(GLIBC_MINOR) || !named.includes(`manylinux_2_${GLIBC_MINOR}_`)) {
    throw Object.assign(new Error(`${path.basename(file)} is not for glibc ${GLIBC}, by auditwheel`), { output: says });
  }
  return `${named}, auditwheel: manylinux_2_${found[1]}`;
}

/** A virtual environment with a wheel and NumPy alone. @param {string} name @param {string} wheel @returns {Promise<string>} its Python */
async function environment(name, wheel) {
  const folder = fresh(name);
  await run(PYTHON, ['-m', 'venv', folder]);
  const python = programOf(folder, 'python');
  await run(python, ['-m', 'pip', 'install', '--quiet', '--only-binary=:all:', wheel]);
  return python;
}

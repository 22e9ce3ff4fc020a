// What goes with what is compiled: the licences of all crates in it (cargo-about), and its bill of materials (CycloneDX, by cargo-cyclonedx).
// Both are of this machine's target and of the features that are compiled; `cargo tree` says which crates these are: neither may lack one, and the bill has no others.

import { cpSync, readFileSync, readdirSync, rmSync, writeFileSync } from 'node:fs';
import path from 'node:path';

import { ROOT, run } from '../run.mjs';
import { COMMITTED, TRIPLE, buildEnv, fresh, said } from './build.mjs';
import { cargoTool, program } from './tools.mjs';

/** What is compiled: its manifest, and what cargo is told besides. @typedef {{ manifest: string, features?: string[], target?: string }} Product */
/** @type {Record<string, Product>} */
export const PRODUCTS = {
  command: { manifest: 'Cargo.toml', features: ['--features', 's3'] },
  wheel: { manifest: 'python/Cargo.toml' },
  c: { manifest: 'capi/Cargo.toml' },
  npm: { manifest: 'Cargo.toml', features: ['--no-default-features', '--features', 'web'], target: 'wasm32-unknown-unknown' },
};
/** Name of the file of licences in every artefact. */
export const LICENCES = 'LICENSE-THIRD-PARTY.txt';
/** The licences of hexcast itself. */
export const OWN_LICENCES = ['LICENSE-MIT', 'LICENSE-APACHE'];
const SPEC = '1.5';
/** The name under which cargo-cyclonedx puts a file beside each manifest of the workspace. */
const SCRATCH = 'release-bill-of-materials';

/** Crates of a product, as "name version". @param {Product} product @returns {string[]} */
function crates({ manifest, features = [], target = TRIPLE }) {
  const args = ['tree', '--locked', '--manifest-path', manifest, '--edges', 'normal', '--target', target, '--prefix', 'none'];
  const listed = said('cargo', [...args, '--format', '{p}', ...features])
    .split('\n')
    .filter(Boolean);
  return [...new Set(listed.map((line) => line.replace(/^(\S+) v(\S+).*$/, '$1 $2')))].sort();
}

/** Fails where a list lacks a crate that is compiled. @param {string} what @param {string[]} listed @param {string[]} expected */
function lacksNone(what, listed, expected) {
  const missing = expected.filter((name) => !listed.includes(name));
  if (missing.length > 0) throw new Error(`${what} lacks ${missing.join(', ')}`);
}

/** Collects the licences of a product. @param {keyof typeof PRODUCTS} name @returns {Promise<string>} path of the text */
export async function licences(name) {
  const product = PRODUCTS[name];
  const [config, template] = ['about.toml', 'licences.hbs'].map((file) => path.join(ROOT, 'scripts/release', file));
  const file = path.join(fresh(`licences-${name}`), LICENCES);
  const args = ['generate', '--config', config, '--offline', '--locked', '--fail', '--manifest-path', product.manifest];
  await run(cargoTool('cargo-about'), [
    'about',
    ...args,
    '--target',
    product.target ?? TRIPLE,
    ...(product.features ?? []),
    template,
    '-o',
    file,
  ]);
  const text = readFileSync(file, 'utf8');
  const listed = [...text.matchAll(/^ {4}(\S+ \d+\.\d+\.\d+\S*)$/gm)].map((match) => match[1]);
  // it may have some that only other features of the workspace need
  lacksNone(`the text of licences of ${name}`, listed, crates(product));
  return file;
}

/** Writes the bill of materials of a product. @param {keyof typeof PRODUCTS} name @returns {Promise<string>} path of the file */
export async function billOfMaterials(name) {
  const product = PRODUCTS[name];
  const file = path.join(fresh(`materials-${name}`), `hexcast-${name}.cdx.json`);
  const folders = ['.', 'capi', 'python', ...readdirSync(path.join(ROOT, 'crates')).map((crate) => `crates/${crate}`)];
  const args = ['--manifest-path', product.manifest, '--format', 'json', '--spec-version', SPEC, '--no-build-deps'];
  const of = [...args, '--target', product.target ?? TRIPLE, ...(product.features ?? []), '--override-filename', SCRATCH];
  try {
    await run(cargoTool('cargo-cyclonedx'), ['cyclonedx', ...of], { env: { SOURCE_DATE_EPOCH: COMMITTED } });
    cpSync(path.join(ROOT, path.dirname(product.manifest), `${SCRATCH}.json`), file);
  } finally {
    for (const folder of folders) rmSync(path.join(ROOT, folder, `${SCRATCH}.json`), { force: true });
  }
  const wanted = crates(product);
  writeFileSync(
    file,
    `${JSON.stringify(pruned(JSON.parse(readFileSync(file, 'utf8')), wanted), null, 2)}\n`.replaceAll(
      `file://${ROOT}`,
      'file://.',
    ),
  );
  await run(program('python'), ['-c', VALIDATE, file], { env: buildEnv() });
  return file;
}

/**
 * A bill without what only other crates of the workspace need: cargo-cyclonedx asks for the features of all of them at once.
 *
 * @param {any} bill @param {string[]} wanted "name version" of what is compiled
 */
export function pruned(bill, wanted) {
  const nameOf = (/** @type {{ name: string, version: string }} */ { name, version }) => `${name} ${version}`;
  const root = bill.metadata.component;
  const components = bill.components.filter((/** @type {any} */ component) => wanted.includes(nameOf(component)));
  lacksNone('the bill of materials', [root, ...components].map(nameOf), wanted);
  const refs = new Set([root, ...components].map((component) => component['bom-ref']));
  const dependencies = bill.dependencies
    .filter((/** @type {any} */ { ref }) => refs.has(ref))
    .map((/** @type {any} */ of) =>
      of.dependsOn ? { ...of, dependsOn: of.dependsOn.filter((/** @type {string} */ ref) => refs.has(ref)) } : of,
    );
  return { ...bill, components, dependencies };
}

/** Holds a file to the schema of CycloneDX. */
const VALIDATE = `
import sys
from cyclonedx.schema import SchemaVersion
from cyclonedx.validation.json import JsonStrictValidator

fault = JsonStrictValidator(SchemaVersion.V1_5).validate_str(open(sys.argv[1], encoding="utf-8").read())
sys.exit(f"{sys.argv[1]} is not of CycloneDX ${SPEC}: {fault}" if fault else 0)
`;

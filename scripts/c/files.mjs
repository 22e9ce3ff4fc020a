// The files that the C library writes: those of the command, byte for byte.

import { spawnSync } from 'node:child_process';
import { cpSync, mkdirSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import path from 'node:path';

import { FOLDER, SPOT, compiled, filesOf, fresh } from './library.mjs';
import { buildNative } from '../native.mjs';
import { ROOT, run } from '../run.mjs';

/** A whole name, and what needs cut cells. */
const OTHERS = ['geometry.xml', 'eb'];
/** Files that C writes, and options of both: each ending of the command. @type {[string, string, string[]][]} */
const FILES = [
  ...[...endingsOf('cells'), 'zarr.zip', ...endingsOf('export').filter((ending) => !OTHERS.includes(ending))].map(plain),
  ['case/constant/polyMesh', '', []],
  ['geometry.xml', '', []],
  ['plain.vti', '{"compress": 0}', ['--compress=none']],
  ['small.hxc', '{"compress": 9}', ['--compress=9']],
  ['bits.npy', '{"bits": true}', ['--bits']],
  ['turned.raw', '{"axis_order": "xyz", "map": {"0": 3, "7": 0}}', ['--axis-order', 'xyz', '--map', '0=3,7=0']],
  ['air.msh', '{"export_flags": [0], "ascii": true}', ['--export-flags', '0', '--ascii']],
  ['walls.foam', '{"patches": "solid", "open_patches": ["cow"]}', ['--patches', 'solid', '--open-patches', 'cow']],
];

/** Endings of the formats of a kind. @param {string} kind @returns {string[]} */
function endingsOf(kind) {
  const formats = JSON.parse(readFileSync(path.join(ROOT, 'docs/formats.json'), 'utf8'));
  return Object.keys(formats).filter((name) => formats[name].kind === kind);
}

/** @param {string} ending @returns {[string, string, string[]]} */
function plain(ending) {
  return [`mesh_${ending.replace('.', '_')}/mesh.${ending}`, '', []];
}

/** Compares the files of hexcast_mesh_write with those of the command, byte for byte. */
export async function testFiles() {
  const program = await compiled('cc', 'tests/files.c');
  const command = await buildNative();
  const [ours, theirs] = ['c', 'command'].map((name) => path.join(FOLDER, 'written', name));
  fresh('written');
  const material = { eps_r: 2.5, sigma: 0.5, E: 2e9, nu: 0.3, density: 1000 };
  const geometries = [{ file: SPOT, flag: 7, name: 'cow', material }];
  const background = { name: 'air', material: { eps_r: 1.0006 } };
  const job = {
    geometries,
    background,
    cell_size: 0.05,
    padding: { cells: 1 },
    unit: 'm',
    zarr: { chunks: [16, 16, 16], shards: [32, 32, 32] },
  };
  const jobFile = path.join(FOLDER, 'written.json');
  writeFileSync(jobFile, JSON.stringify(job));
  for (const folder of [ours, theirs])
    FILES.forEach(([name]) => mkdirSync(path.join(folder, path.dirname(name)), { recursive: true }));
  const report = JSON.parse(
    await run(program, [jobFile, ...FILES.flatMap(([name, options]) => [path.join(ours, name), options])]),
  );
  for (const [name, , words] of FILES)
    await run(command, ['mesh', '--job', jobFile, '--backend', 'cpu', '-o', path.join(theirs, name), ...words]);
  const [found, expected] = [ours, theirs].map(filesOf);
  if (String(found) !== String(expected)) throw new Error(`C wrote ${found.join(', ')} and the command ${expected.join(', ')}`);
  const differ = expected.filter((name) => !readFileSync(path.join(ours, name)).equals(readFileSync(path.join(theirs, name))));
  if (differ.length > 0) throw new Error(`these files differ from those of the command: ${differ.join(', ')}`);

  // what the command reads has the flags and the hash of the mesh that C has
  const [raw, again] = [path.join(ours, plain('raw')[0]), path.join(FOLDER, 'written/again.raw')];
  const words = ['--backend', 'cpu', '--json'];
  const { flags_hash } = JSON.parse(await run(command, ['mesh', '--job', jobFile, ...words]));
  if (flags_hash !== report.flags_hash) throw new Error(`the mesh of C has the hash ${report.flags_hash}, not ${flags_hash}`);
  await run(command, ['convert', path.join(ours, plain('hxc')[0]), again]);
  if (!readFileSync(raw).equals(readFileSync(again))) throw new Error('the command reads other flags than C has');
  await run(command, ['verify', path.join(ours, plain('hxc')[0]), '--job', jobFile]);

  // a window is a mesh of its own
  const window = path.join(FOLDER, 'window.json');
  writeFileSync(window, JSON.stringify({ ...job, window: [2, 3, 4, 20, 25, 18] }));
  for (const name of ['window.vti', 'window.nrrd', 'window.hxc']) {
    await run(program, [window, path.join(ours, name), '']);
    await run(command, ['mesh', '--job', window, '--backend', 'cpu', '-o', path.join(theirs, name)]);
    if (!readFileSync(path.join(ours, name)).equals(readFileSync(path.join(theirs, name)))) throw new Error(`${name} differs`);
    rmSync(path.join(ours, name));
  }

  // cut cells, and what such files lack
  const cut = path.join(FOLDER, 'cut.json');
  writeFileSync(cut, JSON.stringify({ ...job, cut_cells: { fluid: 0, boundary: true } }));
  const names = ['cut/cut.foam', 'cut/cut.eb'];
  for (const folder of [ours, theirs]) mkdirSync(path.join(folder, 'cut'));
  const { status, stderr } = spawnSync(program, [cut, ...names.flatMap((name) => [path.join(ours, name), ''])], {
    encoding: 'utf8',
  });
  if (status !== 0 || !/cut\.foam lacks \["/.test(stderr) || !/cut\.eb lacks \["/.test(stderr))
    throw Object.assign(new Error('C does not say what cut cells lack'), { output: stderr });
  const outputs = names.flatMap((name) => ['-o', path.join(theirs, name)]);
  await run(command, ['mesh', '--job', cut, '--backend', 'cpu', ...outputs]);
  for (const name of filesOf(path.join(theirs, 'cut')))
    if (!readFileSync(path.join(ours, 'cut', name)).equals(readFileSync(path.join(theirs, 'cut', name))))
      throw new Error(`${name} differs`);
  for (const folder of [ours, theirs]) rmSync(path.join(folder, 'cut'), { recursive: true });

  // what is there is replaced, and a surface of the mesh is not
  await run(program, [jobFile, ...FILES.flatMap(([name, options]) => [path.join(ours, name), options])]);
  if (String(filesOf(ours)) !== String(expected)) throw new Error('files were left when others were replaced');
  const surface = path.join(FOLDER, 'written/surface.vti');
  cpSync(SPOT, surface);
  writeFileSync(jobFile, JSON.stringify({ geometries: [{ file: surface }], cells: 8 }));
  const said = await run(program, [jobFile, surface, '']).catch((failed) => failed.output);
  if (!said.includes('an input of the mesh') || !readFileSync(surface).equals(readFileSync(SPOT)))
    throw Object.assign(new Error('a surface was written over'), { output: said });
  return `${expected.length} files`;
}

// The test that every artefact passes: a cube of 10 x 10 x 10 cells has 1000 cells inside.

import { writeFileSync } from 'node:fs';
import path from 'node:path';

import { run } from '../run.mjs';
import { fresh } from './build.mjs';
import { version } from './versions.mjs';

/** The corners of the facets; bit 0 of a corner's number is its end along x, bit 1 along y, bit 2 along z. */
const FACETS = '021 123 465 576 014 154 263 367 042 246 135 375'.split(' ');
const N_CELLS = 10;
const N_INSIDE = N_CELLS ** 3;

/** Writes the cube as ASCII STL into an empty folder. @param {string} name of the folder @returns {string} path of the file */
export function cubeFile(name) {
  const corner = (/** @type {string} */ digit) => `vertex ${[0, 1, 2].map((axis) => (Number(digit) >> axis) & 1).join(' ')}`;
  const facets = FACETS.map(
    (facet) => `facet normal 0 0 0\nouter loop\n${[...facet].map(corner).join('\n')}\nendloop\nendfacet\n`,
  );
  const file = path.join(fresh(name), 'cube.stl');
  writeFileSync(file, `solid cube\n${facets.join('')}endsolid cube\n`);
  return file;
}

/** What a program prints of the cube: version and cells inside. @param {string} printed @returns {string} */
export function heldToCube(printed) {
  const expected = `${version()} ${N_INSIDE}`;
  const last = printed.trimEnd().split('\n').at(-1) ?? '';
  if (last !== expected)
    throw Object.assign(new Error(`a cube has ${last || 'nothing'}, not ${expected}: version, cells inside`), {
      output: printed,
    });
  return `a cube has ${N_INSIDE} cells`;
}

/** Has the command mesh the cube and verify the mesh. @param {string} program @returns {Promise<string>} */
export async function testCommand(program) {
  const file = cubeFile('cube-of-command');
  const mesh = path.join(path.dirname(file), 'cube.hxc');
  const size = ['--cells', `${N_CELLS}`, '--padding-cells', '2'];
  const report = JSON.parse(await run(program, ['mesh', file, ...size, '--backend', 'cpu', '-o', mesh, '--json']));
  await run(program, ['verify', mesh, file, ...size]);
  return heldToCube(`${report.version} ${report.flags.find((/** @type {{ flag: number }} */ { flag }) => flag === 1)?.cells}`);
}

/** The cube by the Python package. @param {string} python @returns {Promise<string>} */
export async function testPython(python) {
  const file = cubeFile('cube-of-python');
  const code = `
import sys, hexcast
mesh = hexcast.mesh(sys.argv[1], cells=${N_CELLS}, padding={"cells": 2}, backend="cpu")
mesh.save("cube.vti")
print(hexcast.__version__, int((mesh.flags == 1).sum()))
`;
  return heldToCube(await run(python, ['-c', code, file], { cwd: path.dirname(file) }));
}

/** The cube by the npm package. @param {string} project folder that has it installed @returns {Promise<string>} */
export async function testNode(project) {
  const file = cubeFile('cube-of-node');
  const code = `
    import { readFileSync } from 'node:fs';
    import { createMesher, version } from 'hexcast';
    const mesher = await createMesher({ backend: 'cpu' });
    const mesh = await mesher.mesh({ geometries: [{ source: readFileSync(process.argv[2]), flag: 1 }], cells: ${N_CELLS}, padding: { cells: 2 } });
    let inside = 0;
    for await (const { flags } of mesh.slabs()) for (const flag of flags) inside += Number(flag === 1);
    console.log(version, inside);
    mesher.dispose();
`;
  writeFileSync(path.join(project, 'cube.mjs'), code);
  return heldToCube(await run(process.execPath, ['cube.mjs', file], { cwd: project }));
}

// What the command refuses before it meshes: nobody waits for a mesh that no output can have.

import assert from 'node:assert/strict';
import { mkdtempSync, readdirSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { after, before, test } from 'node:test';

import { boxBetween } from '../e2e/open_box.mjs';
import { nativeCommand } from './project.mjs';

let folder;
before(() => {
  folder = mkdtempSync(path.join(tmpdir(), 'hexcast-refusals-'));
  writeFileSync(path.join(folder, 'foot.stl'), boxBetween([0, 0, 0], [9, 4, 2]));
  writeFileSync(path.join(folder, 'tip.stl'), boxBetween([7, 3, 2], [8, 4, 3]));
});
after(() => rmSync(folder, { recursive: true, force: true }));

const command = (...args) => nativeCommand(folder, ...args);

test('the command refuses before the mesh what it knows by then', () => {
  // a mesh that is refused when it comes to its memory
  const job = ['mesh', 'foot.stl:flag=3', 'tip.stl', '--max-memory=1MB', '--backend=cpu', '--unit=mm'];
  const graded = ['--graded=0.01', '--min-size=0.005', '--padding-length=0.7'];
  const cubes = ['--cells=3000', '--padding-cells=1'];
  const asked = [
    [graded, ['-o', 'mesh.vtr'], /^error\[memory\]: the mesh takes about/],
    [cubes, ['-o', 'mesh.msh', '--export-flags=0,2'], /^error\[memory\]: the mesh takes about/],
    [graded, ['-o', 'mesh.vti'], /^error\[lines-graded\]: mesh\.vti: cells differ in size, and \.vti holds/],
    [graded, ['--fractions', 'mesh.vti'], /^error\[lines-graded\]: mesh\.vti: cells differ in size, and \.vti holds/],
    [graded, ['--doubt', 'mesh.vti'], /^error\[lines-graded\]: mesh\.vti: cells differ in size, and \.vti holds/],
    [graded, ['-o', 'mesh.nrrd'], /^error\[lines-graded\]: mesh\.nrrd: cells differ in size, and \.nrrd holds/],
    [graded, ['-o', 'mesh.vox'], /^error\[lines-graded\]: mesh\.vox: cells differ/],
    [graded, ['-o', 'mesh.binvox'], /^error\[lines-graded\]: mesh\.binvox: cells differ/],
    [graded, ['-o', 'mesh.in'], /^error\[lines-graded\]: mesh\.in: cells differ/],
    [graded, ['-o', 'geometry.xml'], /^error\[lines-graded\]: geometry\.xml: cells differ/],
    [cubes, ['-o', 'geometry.xml'], /^error\[export-too-large\]: geometry\.xml: \d+ cells: OpenMC numbers up to 2147483647/],
    [cubes, ['-o', 'mesh.msh', '--export-flags=3,9'], /no geometry has it; flags of the job: 0, 2, 3\nhint/],
    [cubes, ['-o', 'mesh.msh', '--export-flags=4', '--close-gaps=2'], /^error\[memory\]/],
    [cubes, ['-o', 'mesh.msh', '--export-flags=4', '--close-gaps=2', '--gap-flag=7'], /flags of the job: 0, 2, 3, 7\n/],
    [cubes, ['-o', 'mesh.vox', '--export-flags=0'], /^error\[job-conflict\]: mesh\.vox: flag 0 is to be exported, and colour 0/],
    [cubes, ['-o', 'mesh.zarr', '--zarr-chunks=2,2,2', '--zarr-shards=3,2,2'], /^error\[job-value\]: zarr: shards of 3 cells/],
    [cubes, ['-o', 'mesh.zarr.zip', '--zarr-chunks=2,2,2', '--zarr-shards=3,2,2'], /^error\[job-value\]: zarr: shards of 3/],
  ];
  for (const [cells, outputs, pattern] of asked) {
    const { status, stderr } = command(...job, ...cells, ...outputs);
    assert.ok(status > 0 && status < 8, `${outputs}: ${status}`);
    assert.match(stderr, pattern);
  }
  assert.deepEqual(readdirSync(folder).sort(), ['foot.stl', 'tip.stl']);
});

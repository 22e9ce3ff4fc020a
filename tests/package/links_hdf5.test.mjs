// Links and distances as HDF5: the arrays of the native command's file, as the reference library reads them.

import assert from 'node:assert/strict';
import { mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { after, before, test } from 'node:test';

import { hdf5Reader } from './hdf5.mjs';
import { installedProject, nativeCommand, writeBodies } from './project.mjs';

let project;
let folder;
let readHdf5;
before(async () => {
  readHdf5 = await hdf5Reader();
  project = installedProject();
  folder = mkdtempSync(path.join(tmpdir(), 'hexcast-links-'));
  writeBodies(folder);
});
after(() => {
  project.remove();
  rmSync(folder, { recursive: true, force: true });
});

const CODE = `
  import { readFileSync, writeFileSync } from 'node:fs';
  import { createMesher } from 'hexcast';
  const [folder] = process.argv.slice(2);
  const job = JSON.parse(readFileSync(folder + '/job.json', 'utf8'));
  for (const geometry of job.geometries) {
    geometry.source = readFileSync(folder + '/' + geometry.file);
    delete geometry.file;
  }
  const mesher = await createMesher({ backend: 'cpu' });
  const mesh = await mesher.mesh(job);
  for (const compress of [0, 6]) {
    for (const of of ['links', 'distance']) {
      const blob = await mesh.blob(of + '.h5', { compress });
      writeFileSync(folder + '/' + of + '-' + compress + '.h5', Buffer.from(await blob.arrayBuffer()));
    }
  }
  console.log(JSON.stringify({ links: mesh.report.links.links, size: mesh.size('links.h5') }));
  mesher.dispose();
`;

for (const fluid of [[0], [200]]) {
  test(`links of the fluid ${fluid}, and distances, are those of the native command`, () => {
    const geometries = ['foot', 'arm', 'tip'].map((name) => ({ file: `${name}.stl` }));
    const job = { geometries, cell_size: 0.5, padding: { cells: 1 }, links: { stencil: 'D3Q19', fluid }, distance: {} };
    writeFileSync(path.join(folder, 'job.json'), JSON.stringify(job));
    const { links, size } = JSON.parse(project.run('links.js', CODE, folder));
    assert.equal(links > 100, fluid[0] === 0);
    assert.equal(size, null);
    for (const compress of [0, 6]) {
      const words = ['mesh', '--job', 'job.json', '--backend=cpu', '-q', `--compress=${compress || 'none'}`];
      const files = ['links', 'distance'].map((of) => `native-${of}-${compress}.h5`);
      const { status, stderr } = nativeCommand(folder, ...words, '--links', files[0], '--distance', files[1]);
      assert.equal(status, 0, stderr);
      const read = (/** @type {string} */ name) => readHdf5(path.join(folder, `${name}-${compress}.h5`));
      assert.equal(read('native-links').datasets.q.shape[0], links);
      assert.equal(read('native-distance').datasets.distance.shape.length, 3);
      for (const of of ['links', 'distance']) assert.deepEqual(read(of), read(`native-${of}`));
    }
  });
}

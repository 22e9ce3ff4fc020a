// The package in Node leaves no trace: no global is added, and a GPU of the caller's is used where it is.

import assert from 'node:assert/strict';
import { symlinkSync } from 'node:fs';
import path from 'node:path';
import { after, before, test } from 'node:test';

import { swiftshaderEnv } from '../../scripts/machine.mjs';
import { ROOT } from '../../scripts/run.mjs';
import { SPOT, installedProject } from './project.mjs';

const SCENE = path.join(ROOT, 'tests/fixtures/scene');

let project;
before(() => {
  project = installedProject();
  symlinkSync(path.join(ROOT, 'node_modules/webgpu'), path.join(project.folder, 'node_modules/webgpu'));
});
after(() => project.remove());

const TRACE = `
  import { readFileSync } from 'node:fs';
  const keys = () => [...Object.getOwnPropertyNames(globalThis), ...Object.getOwnPropertyNames(globalThis.navigator ?? {})].sort().join();
  const geometries = [{ source: readFileSync(process.argv[2]) }];
  // what is loaded lazily is no global of the package's
  performance.now(); new Blob([]); AbortController; MessageChannel; fetch; WebAssembly;
  const { createMesher } = await import('hexcast');
  const before = keys();
  const meshOn = async (options) => {
    const mesher = await createMesher(options);
    const mesh = await mesher.mesh({ geometries, cells: 30 });
    const facts = [mesher.backend, await mesh.sha256()];
    mesher.dispose();
    return facts;
  };
  const found = [await meshOn({ backend: 'cpu' }), await meshOn({ backend: 'gpu' })];
  const isClean = keys() === before;
  const { create } = await import('webgpu');
  const gpu = create([]);
  if (!globalThis.navigator) globalThis.navigator = {};
  Object.defineProperty(globalThis.navigator, 'gpu', { value: gpu, configurable: true });
  found.push(await meshOn({ backend: 'gpu' }));
  const isMine = globalThis.navigator.gpu === gpu;
  const device = await (await gpu.requestAdapter()).requestDevice();
  found.push(await meshOn({ device }));
  console.log(JSON.stringify({ found, isClean, isMine }));
  process.exit(0);
`;

test("no global is added in Node, and navigator.gpu and devices of the caller's are used", () => {
  const driver = swiftshaderEnv();
  assert.ok(driver, 'Chromium brings SwiftShader, which this test needs');
  Object.assign(process.env, driver);
  const { found, isClean, isMine } = JSON.parse(project.run('trace.js', TRACE, SPOT));
  assert.ok(isClean, 'globalThis has the keys that it had');
  assert.ok(isMine);
  assert.deepEqual(
    found.map(([backend]) => backend),
    ['cpu', 'gpu', 'gpu', 'gpu'],
  );
  for (const [, hash] of found) assert.equal(hash, found[0][1]);
});

const FREE = `
  import { readFileSync } from 'node:fs';
  import { createMesher } from 'hexcast';
  const stl = readFileSync(process.argv[2]);
  const module = await WebAssembly.compile(readFileSync(new URL('./node_modules/hexcast/dist/hexcast_bg.wasm', import.meta.url)));
  const sizes = [];
  const instances = [];
  const { instantiate } = WebAssembly;
  WebAssembly.instantiate = async (...args) => {
    const made = await instantiate(...args);
    const { exports } = made.instance ?? made;
    if ('webmesh_flag' in exports) instances.push(exports.memory);
    return made;
  };
  for (let at = 0; at < 120; at += 1) {
    const mesher = await createMesher({ backend: 'cpu', wasm: module });
    const surface = await mesher.read(stl);
    const mesh = await mesher.mesh({ geometries: [{ source: surface }], cells: 60 });
    await mesh.blob('hxc');
    await mesher.estimate({ geometries: [{ source: stl }] });
    mesher.dispose();
    if (at === 2 || at === 119) sizes.push(instances[0].buffer.byteLength);
  }
  console.log(JSON.stringify({ sizes, n_instances: instances.length }));
`;

test('what a mesher made is freed with it: 120 of them take no more memory than three', () => {
  const { sizes, n_instances } = JSON.parse(project.run('free.js', FREE, SPOT));
  assert.equal(n_instances, 1);
  assert.equal(sizes[1], sizes[0]);
});

const FORMATS = `
  import { readFileSync } from 'node:fs';
  import { gzipSync } from 'node:zlib';
  import { createMesher } from 'hexcast';
  const mesher = await createMesher({ backend: 'cpu' });
  const found = [];
  const obj = (stl) => {
    const lines = [];
    for (let at = 84; at < stl.length; at += 50) {
      for (const corner of [12, 24, 36]) {
        lines.push('v ' + [0, 4, 8].map((axis) => stl.readFloatLE(at + corner + axis)).join(' '));
      }
      lines.push('f -3 -2 -1');
    }
    return Buffer.from(lines.join('\\n'));
  };
  const read = (ending) => readFileSync(process.argv[2] + '.' + ending);
  for (const source of [read('stl'), read('glb'), read('3mf'), gzipSync(read('3mf')), obj(read('stl'))]) {
    const surface = await mesher.read(source);
    const { format, unit, facets, solids } = surface.info;
    const mesh = await mesher.mesh({ geometries: [{ source: surface }], domain: [-7, -3, -2, 6, 2, 5], cells: 90 });
    found.push({ format, unit, facets, solids, of_mesh: mesh.report.unit, hash: mesh.report.flags_hash });
  }
  const wrong = await mesher.read(read('glb').subarray(0, 900)).catch(({ code, message }) => ({ code, message }));
  mesher.dispose();
  console.log(JSON.stringify({ found, wrong }));
`;

test('GLB, 3MF, OBJ and what gzip packed give the cells of the same model as STL', () => {
  const { found, wrong } = JSON.parse(project.run('formats.js', FORMATS, SCENE));
  assert.deepEqual(
    found.map(({ format, unit, of_mesh }) => [format, unit, of_mesh]),
    [
      ['STL, binary', null, null],
      ['GLB', 'm', 'm'],
      ['3MF', 'mm', 'mm'],
      ['3MF', 'mm', 'mm'],
      ['OBJ', null, null],
    ],
  );
  assert.deepEqual(found[1].solids, ['ball', 'rod', 'mirrored']);
  assert.ok(found.every(({ facets }) => facets === 136));
  assert.equal(new Set(found.map(({ hash }) => hash)).size, 1);
  assert.equal(wrong.code, 'file-syntax');
  assert.match(wrong.message, /GLB: a chunk of \d+ bytes begins at byte \d+, and the file has 900/);
});

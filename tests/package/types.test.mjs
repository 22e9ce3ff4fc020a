// The manifest, the types and the values: what publint, are-the-types-wrong and the TypeScript compiler say of the tarball.

import assert from 'node:assert/strict';
import { execFileSync, spawnSync } from 'node:child_process';
import { readFileSync, symlinkSync, writeFileSync } from 'node:fs';
import path from 'node:path';
import { after, before, test } from 'node:test';

import { ROOT } from '../../scripts/run.mjs';
import { SPOT, installedProject } from './project.mjs';
import { TOOLS, ensureTools } from './tools.mjs';

let project;
before(() => (project = installedProject()));
after(() => project.remove());

/** Runs a program of a development package; fails with all that it says. */
function assertPasses(program, ...args) {
  const { status, stdout, stderr } = spawnSync(path.join(ROOT, 'node_modules/.bin', program), args, {
    cwd: project.folder,
    encoding: 'utf8',
  });
  assert.equal(status, 0, `${program} ${args.join(' ')}\n${stdout}${stderr}`);
  return stdout;
}

test('the manifest exports the package, its worker, Node, CAD, the viewer, the wasm and the shaders, types first', () => {
  const { exports: entries } = JSON.parse(readFileSync(path.join(ROOT, 'package.json'), 'utf8'));
  const files = ['./hexcast_bg.wasm', './hexcast_threads_bg.wasm', './shaders/*', './package.json'];
  assert.deepEqual(Object.keys(entries), ['.', './worker', './node', './cad', './cad/worker', './viewer', ...files]);
  for (const name of ['.', './worker', './node', './cad', './cad/worker', './viewer'])
    assert.equal(Object.keys(entries[name])[0], 'types', name);
  const resolved = [
    'hexcast',
    'hexcast/worker',
    'hexcast/node',
    'hexcast/cad',
    'hexcast/cad/worker',
    'hexcast/viewer',
    'hexcast/hexcast_bg.wasm',
    'hexcast/shaders/map.wgsl',
  ];
  writeFileSync(
    path.join(project.folder, 'resolve.js'),
    `for (const name of ${JSON.stringify(resolved)}) console.log(import.meta.resolve(name));`,
  );
  const found = execFileSync(process.execPath, ['resolve.js'], { cwd: project.folder, encoding: 'utf8' }).trim().split('\n');
  assert.deepEqual(
    found.map((url) => url.split('/node_modules/hexcast/')[1]),
    [
      ...['dist/node.js', 'dist/worker.js', 'dist/node.js', 'dist/cad_node.js', 'dist/cad/cad_worker.js', 'dist/viewer.js'],
      ...['dist/hexcast_bg.wasm', 'shaders/map.wgsl'],
    ],
  );
});

test('publint has nothing to say', () => {
  assert.match(assertPasses('publint', '--strict', project.tarball), /All good!/);
});

test('are-the-types-wrong has nothing to say', () => {
  // a wasm is a file to fetch, not a module to import
  const files = ['./hexcast_bg.wasm', './hexcast_threads_bg.wasm'];
  assertPasses('attw', project.tarball, '--profile', 'esm-only', '--exclude-entrypoints', ...files);
});

const VALUES = `
  import { readFileSync } from 'node:fs';
  import * as hexcast from 'hexcast';
  const mesher = await hexcast.createMesher({ backend: 'cpu' });
  const surface = await mesher.read(readFileSync(process.argv[2]), { file: 'spot.stl' });
  const job = { geometries: [{ source: surface }], cells: 20 };
  const first = await mesher.estimate(job);
  const mesh = await mesher.mesh(job);
  const again = await mesher.open(await mesh.blob('hxc'));
  console.log(JSON.stringify({
    Report: [mesh.report, again.report],
    SurfaceInfo: [surface.info],
    Estimate: [first, await mesher.estimate(job)],
    Lines: [mesh.lines],
    exported: Object.keys(hexcast).sort(),
  }));
`;

/** Uses that must compile, and uses that must not. */
const USES = `
  import { HexcastError, createMesher, type Mesh } from 'hexcast';
  import * as hexcast from 'hexcast';
  import 'hexcast/worker';
  // @ts-expect-error the worker exports nothing
  import { createMesher as none } from 'hexcast/worker';
  using mesher = await createMesher({ backend: 'auto', worker: new URL('x.js', 'https://example.org'), wasm: new Uint8Array(8) });
  const mesh: Mesh = await mesher.mesh({ geometries: [{ source: new Blob([]), flag: 1 }], cells: 256 });
  for await (const { flags, start } of mesh.slabs()) flags[start[0]]?.toFixed();
  // @ts-expect-error a mesh that was read back has no volume of facets
  mesh.report.flags[0]!.mesh_volume.toFixed();
  // @ts-expect-error there is no such option
  await mesher.mesh({ geometries: [], cels: 3 });
  const large = await mesher.read(new Blob([]), { check: false });
  // @ts-expect-error its edges were not looked at
  large.info.open_edges.toFixed();
  (await large.check()).info.open_edges.toFixed();
  await mesher.mesh({ geometries: [{ source: large }], cells: 8 }, { maxDeviceBytes: 2 ** 30 });
  export const code = (error: unknown) => (error instanceof HexcastError ? error.code satisfies string : null);
  export type Exported = keyof typeof hexcast;
`;

test('the types are those of the values, read back or not, and compile strictly without those of others', () => {
  writeFileSync(path.join(project.folder, 'values.js'), VALUES);
  const printed = execFileSync(process.execPath, ['values.js', SPOT], { cwd: project.folder, encoding: 'utf8' });
  const { exported, ...values } = JSON.parse(printed);
  const [meshed, reopened] = values.Report;
  assert.equal(typeof meshed.flags[0].mesh_volume, 'number');
  assert.equal(reopened.flags[0].mesh_volume, null);
  const declared = Object.entries(values).flatMap(([type, list]) =>
    list.map((value, index) => `export const a${type}${index}: hexcast.${type} = ${JSON.stringify(value)};`),
  );
  const all = `export const names: Record<Exported, true> = ${JSON.stringify(Object.fromEntries(exported.map((name) => [name, true])))};`;
  writeFileSync(path.join(project.folder, 'uses.ts'), [USES, ...declared, all].join('\n'));
  const strict = ['--noEmit', '--strict', '--noUncheckedIndexedAccess', '--target', 'es2022', '--lib', 'es2022,dom'];
  for (const resolution of [
    ['--module', 'nodenext'],
    ['--module', 'esnext', '--moduleResolution', 'bundler'],
  ]) {
    assertPasses('tsc', ...strict, ...resolution, 'uses.ts');
  }
});

/** Uses that compile with the types of no platform. */
const PLAIN = `
  import { createMesher, HexcastError, type Mesh } from 'hexcast';
  const mesher = await createMesher({ backend: 'auto' });
  const job = { geometries: [{ source: new Float64Array(9), scale: [1, 1, 1] }], dims: [4, 4, 4] } as const;
  const mesh: Mesh = await mesher.mesh(job);
  export const flag: number = await mesh.flag(0, 0, 0);
  export const shared = await mesh.box([0, 0, 0], mesh.dims, { into: new Uint8Array(new SharedArrayBuffer(64)) });
  export const code = (error: unknown) => (error instanceof HexcastError ? (error.details.key ?? error.code) : null);
`;
/** Uses of browsers: what takes arrays over an ArrayBuffer takes ours. */
const DOM = `
  import { createMesher } from 'hexcast';
  const mesher = await createMesher({ worker: () => new Worker('worker.js', { type: 'module' }) });
  const mesh = await mesher.mesh({ geometries: [{ source: { positions: [0, 0, 0], index: new Uint16Array(3) } }] });
  for await (const { flags } of mesh.slabs()) new Blob([flags]);
  const { offsets, starts } = await mesh.columns.all();
  new Blob([offsets, starts]);
  mesh.stream('raw').pipeThrough(new CompressionStream('gzip'));
  declare const queue: { writeBuffer(buffer: object, at: number, data: BufferSource): void };
  queue.writeBuffer({}, 0, (await mesh.box([0, 0, 0], [1, 1, 1])).flags);
`;
/** Devices, buffers and textures are those of the types of WebGPU. */
const WEBGPU = `
  import { createMesher } from 'hexcast';
  declare const device: GPUDevice;
  const mesh = await (await createMesher({ device })).mesh({ geometries: [] });
  const buffer: GPUBuffer = await mesh.flagsBuffer(device, { box: { start: [0, 0, 0], end: mesh.dims }, bits: 1 });
  const texture: GPUTexture = await mesh.flagsTexture(device, { format: 'r8uint' });
  device.createCommandEncoder().copyBufferToBuffer(buffer, 0, buffer, 64, 64);
  texture.createView({ dimension: '3d' });
  // @ts-expect-error flags have 1 or 8 bits
  await mesh.flagsBuffer(device, { bits: 32 });
`;
const NODE = `
  import { Readable } from 'node:stream';
  import { createMesher } from 'hexcast';
  const mesh = await (await createMesher()).mesh({ geometries: [] });
  Readable.fromWeb(mesh.stream('raw'));
`;

test('the types compile from TypeScript 5.4 on, with the types of browsers, of Node, and of neither', {
  timeout: 1_200_000,
}, async () => {
  await ensureTools();
  const compilers = ['ts54', 'ts7'].map((name) => path.join(TOOLS, 'node_modules', name));
  const folder = project.folder;
  symlinkSync(path.join(ROOT, 'node_modules/@webgpu'), path.join(folder, 'node_modules/@webgpu'));
  for (const [name, code] of Object.entries({ plain: PLAIN, dom: DOM, webgpu: WEBGPU, node: NODE }))
    writeFileSync(path.join(folder, `${name}.ts`), code);
  const platforms = [
    { files: ['plain.ts'], lib: ['es2022'], types: [] },
    { files: ['plain.ts', 'dom.ts'], lib: ['es2022', 'dom', 'dom.iterable'], types: [] },
    { files: ['plain.ts', 'webgpu.ts'], lib: ['es2022', 'dom'], types: ['@webgpu/types'], skipLibCheck: true },
    { files: ['plain.ts', 'node.ts'], lib: ['es2022'], types: ['node'], typeRoots: [path.join(TOOLS, 'node_modules/@types')] },
  ];
  const resolutions = [{ module: 'nodenext' }, { module: 'esnext', moduleResolution: 'bundler' }];
  for (const { files, ...platform } of platforms) {
    for (const resolution of resolutions) {
      const compilerOptions = { noEmit: true, strict: true, target: 'es2022', skipLibCheck: false, ...platform, ...resolution };
      writeFileSync(path.join(folder, 'tsconfig.json'), JSON.stringify({ compilerOptions, files }));
      for (const compiler of compilers) {
        const { status, stdout } = spawnSync(process.execPath, [path.join(compiler, 'bin/tsc'), '-p', '.'], {
          cwd: folder,
          encoding: 'utf8',
        });
        assert.equal(status, 0, `${compiler} ${JSON.stringify(compilerOptions)}\n${stdout}`);
      }
    }
  }
});

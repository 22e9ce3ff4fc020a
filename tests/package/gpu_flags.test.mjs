// Flags on a device of the caller's own, in buffers and textures: those of box(), and errors where there can be none. In Node, and in both
// browsers with the mesher in a worker and without one.

import assert from 'node:assert/strict';
import { cpSync, symlinkSync, writeFileSync } from 'node:fs';
import path from 'node:path';
import { after, before, test } from 'node:test';

import { swiftshaderEnv } from '../../scripts/machine.mjs';
import { ROOT } from '../../scripts/run.mjs';
import { serve } from '../../scripts/serve.mjs';
import { BROWSERS, withBrowser } from './pages.mjs';
import { SPOT, installedProject } from './project.mjs';
import { recipe } from './tools.mjs';

const LONG = { timeout: 300_000 };

let project;
before(() => {
  project = installedProject();
  symlinkSync(path.join(ROOT, 'node_modules/webgpu'), path.join(project.folder, 'node_modules/webgpu'));
  cpSync(SPOT, path.join(project.folder, 'spot.stl'));
  writeFileSync(path.join(project.folder, 'index.html'), '<!doctype html><title>Flags</title><link rel="icon" href="data:,">');
});
after(() => project.remove());

/** Runs where the package is: boxes of meshes along every axis, in every form, against box(); returns what differs. */
async function compare(createMesher, device, stl, options, isLarge) {
  const [MAP_READ, COPY_DST] = [1, 8];
  const read = async (size, copy) => {
    const staging = device.createBuffer({ size, usage: MAP_READ | COPY_DST });
    const encoder = device.createCommandEncoder();
    copy(encoder, staging);
    device.queue.submit([encoder.finish()]);
    await staging.mapAsync(1);
    const bytes = new Uint8Array(staging.getMappedRange()).slice();
    staging.destroy();
    return bytes;
  };
  const bytesOf = async (buffer) => {
    const bytes = await read(buffer.size, (encoder, staging) => encoder.copyBufferToBuffer(buffer, 0, staging, 0, buffer.size));
    buffer.destroy();
    return bytes;
  };
  const texelsOf = async (texture, [nx, ny, nz]) => {
    const bytesPerRow = 256 * Math.ceil(nx / 256);
    const copy = (encoder, buffer) =>
      encoder.copyTextureToBuffer({ texture }, { buffer, bytesPerRow, rowsPerImage: ny }, [nx, ny, nz]);
    const rows = await read(bytesPerRow * ny * nz, copy);
    texture.destroy();
    const flags = new Uint8Array(nx * ny * nz);
    for (let row = 0; row < ny * nz; row += 1) flags.set(rows.subarray(row * bytesPerRow, row * bytesPerRow + nx), row * nx);
    return flags;
  };
  const bitsOf = (flags, [nx, ny, nz]) => {
    const row = Math.ceil(nx / 8);
    const bits = new Uint8Array(row * ny * nz);
    for (let at = 0; at < flags.length; at += 1) {
      const x = at % nx;
      if (flags[at] > 0) bits[row * ((at - x) / nx) + (x >> 3)] |= 1 << (x & 7);
    }
    return bits;
  };
  const padded = (bytes) => {
    const whole = new Uint8Array(4 * Math.ceil(bytes.length / 4));
    whole.set(bytes);
    return whole;
  };
  const same = (one, other) => one.length === other.length && one.every((byte, at) => byte === other[at]);
  let state = 7;
  const random = (n) => {
    state = (state * 48271) % 2147483647;
    return state % n;
  };
  const mesher = await createMesher(options);
  const geometries = [
    { source: stl, flag: 7 },
    { source: stl, flag: 200, translate: [0.4, 0.3, 0.1], priority: 1 },
  ];
  const found = { wrong: [], n_boxes: 0, flags: new Set() };
  const check = async (mesh, axis, box) => {
    const { flags } = await mesh.box(box.start, box.end);
    const sizes = box.end.map((end, at) => end - box.start[at]);
    const forms = {
      bytes: [await bytesOf(await mesh.flagsBuffer(device, { box })), padded(flags)],
      bits: [await bytesOf(await mesh.flagsBuffer(device, { box, bits: 1 })), padded(bitsOf(flags, sizes))],
      texture: [await texelsOf(await mesh.flagsTexture(device, { box, format: 'r8uint' }), sizes), flags],
    };
    for (const [form, [ours, expected]] of Object.entries(forms))
      if (!same(ours, expected)) found.wrong.push({ form, axis, box });
    found.n_boxes += 1;
    for (const flag of flags) found.flags.add(flag);
  };
  for (const axis of ['x', 'y', 'z']) {
    const mesh = await mesher.mesh({ geometries, dims: [37, 51, 43], axis });
    await check(mesh, axis, { start: [0, 0, 0], end: mesh.dims });
    for (let n = 0; n < (isLarge ? 5 : 2); n += 1) {
      const start = mesh.dims.map((dim) => random(dim));
      await check(mesh, axis, { start, end: start.map((first, at) => first + 1 + random(mesh.dims[at] - first)) });
    }
  }
  if (isLarge) {
    // two pieces that share a word
    const large = await mesher.mesh({ geometries, dims: [259, 255, 259], axis: 'z' });
    await check(large, 'z', { start: [0, 0, 0], end: large.dims });
    const whole = await large.flagsBuffer(device);
    found.size = whole.size;
    whole.destroy();
    // rows of a texture are copied with 256 bytes each: 23 MB here, in two pieces
    const thin = await mesher.mesh({ geometries, dims: [2, 300, 300] });
    const { flags } = await thin.box([0, 0, 0], thin.dims);
    if (!same(await texelsOf(await thin.flagsTexture(device), thin.dims), flags)) found.wrong.push('thin');
  }
  mesher.dispose();
  return { ...found, flags: [...found.flags].sort((one, other) => one - other) };
}

function assertSame({ wrong, n_boxes, flags }, expected = 9) {
  assert.deepEqual(wrong, []);
  assert.deepEqual([n_boxes, flags], [expected, [0, 7, 200]]);
}

test("in Node a buffer and a texture of the caller's device have the flags of box()", LONG, () => {
  const driver = swiftshaderEnv();
  assert.ok(driver, 'Chromium brings SwiftShader, which this test needs');
  Object.assign(process.env, driver);
  const code = `
    import { readFileSync } from 'node:fs';
    import { create } from 'webgpu';
    import { createMesher } from 'hexcast';
    const before = Object.getOwnPropertyNames(globalThis).length;
    const gpu = create([]);
    const device = await (await gpu.requestAdapter()).requestDevice();
    const found = await (${compare})(createMesher, device, readFileSync('spot.stl'), { backend: 'cpu' }, true);
    const n_added = Object.getOwnPropertyNames(globalThis).length - before;
    // the package webgpu ends with its instance, which is used until here
    console.log(JSON.stringify({ ...found, n_added, isThere: gpu !== null }));
    process.exit(0);
  `;
  const { n_added, isThere, ...found } = JSON.parse(project.run('flags.mjs', code));
  assertSame(found, 19);
  assert.equal(found.size, 259 * 255 * 259 + 1, 'whole words');
  assert.ok(isThere);
  assert.equal(n_added, 0, 'no global is added');
});

/** In the page: compares with the mesher in a worker, without one, and on the same device; then asks for what cannot be. */
async function inPage([compareText, readme, n_meshers]) {
  const { HexcastError, createMesher } = await import(new URL('node_modules/hexcast/dist/hexcast.js', location.href).href);
  const compareHere = new Function(`return ${compareText}`)();
  const stl = await (await fetch('spot.stl')).blob();
  const open = async () => (await navigator.gpu.requestAdapter()).requestDevice();
  const device = await open();
  const uncaptured = [];
  device.onuncapturederror = (event) => uncaptured.push(event.error.message);
  const compared = [];
  for (const options of [{ backend: 'cpu' }, { backend: 'cpu', worker: false }, { device }].slice(0, n_meshers))
    compared.push(await compareHere(createMesher, device, stl, options));
  const mesher = await createMesher({ backend: 'cpu' });
  const geometries = [{ source: stl }];
  const mesh = await mesher.mesh({ geometries, dims: [9, 8, 7] });
  const large = await mesher.mesh({ geometries, dims: [700, 700, 600], axis: 'z' });
  const long = await mesher.mesh({ geometries, dims: [2049, 4, 4] });
  const AsyncFunction = (async () => {}).constructor;
  const made = await new AsyncFunction('mesh', 'device', `${readme}; return { flags, bits, texture }`)(mesh, device);
  const sizes = [made.flags.size, made.bits.size, made.texture.format, made.texture.depthOrArrayLayers];
  const lost = await open();
  lost.destroy();
  await lost.lost;
  const aborted = AbortSignal.abort('enough');
  const box = { start: [1, 2, 3], end: [1, 4, 5] };
  const told = async (call) => {
    try {
      await call();
      return 'no error';
    } catch (error) {
      return error instanceof HexcastError ? [error.code, error.details.key, error.message] : String(error);
    }
  };
  const calls = [
    () => mesh.flagsBuffer(device, { box: { start: [0, 0, 0], end: [10, 8, 7] } }),
    () => mesh.flagsBuffer(device, { box }),
    () => mesh.flagsTexture(device, { box: { start: [0, 0, -1], end: [9, 8, 7] } }),
    () => mesh.flagsBuffer(device, { box: 5 }),
    () => mesh.flagsBuffer(device, { bits: 4 }),
    () => mesh.flagsBuffer(device, { bit: 1 }),
    () => mesh.flagsTexture(device, { format: 'rgba8uint' }),
    () => mesh.flagsBuffer({}),
    () => mesh.flagsTexture(null),
    () => mesh.flagsBuffer(lost),
    () => mesh.flagsTexture(lost),
    () => large.flagsBuffer(device),
    () => long.flagsTexture(device),
    () => mesh.flagsBuffer(device, { signal: aborted }),
  ];
  const errors = [];
  for (const call of calls) errors.push(await told(call));
  mesh.dispose();
  errors.push(await told(() => mesh.flagsBuffer(device)));
  mesher.dispose();
  return { compared, errors, sizes, uncaptured };
}

for (const [name, open] of Object.entries(BROWSERS)) {
  // Firefox looks ten times a second whether the device has answered
  const n_meshers = name === 'Firefox' ? 1 : 3;
  test(`in ${name} too, wherever the mesh is; what cannot be is refused with the numbers`, LONG, async () => {
    const server = await serve({ root: project.folder });
    await withBrowser(open, server, async (browser) => {
      const page = await browser.newPage();
      await page.goto(server.url);
      const { compared, errors, sizes, uncaptured } = await page.evaluate(inPage, [String(compare), recipe('gpu'), n_meshers]);
      assert.equal(compared.length, n_meshers);
      for (const found of compared) assertSame(found);
      assert.deepEqual(errors, [
        ['job-value', 'box.end[0]', 'box.end[0] is 10; allowed: whole numbers from 1 to 9'],
        ['job-value', 'box.end[0]', 'box.end[0] is 1; allowed: whole numbers from 2 to 9'],
        ['job-value', 'box.start[2]', 'box.start[2] is -1; allowed: whole numbers from 0 to 6'],
        ['job-value', 'box', 'box is 5; allowed: an object with start and end'],
        ['job-value', 'bits', 'bits is 4; allowed: 1, 8'],
        ['job-value', 'bit', 'bit is no option of this call; allowed: box, bits, signal'],
        ['job-value', 'format', 'format is "rgba8uint"; allowed: "r8uint"'],
        ['job-value', 'device', 'device is an object (Object); allowed: a GPUDevice'],
        ['job-value', 'device', 'device is null; allowed: a GPUDevice'],
        ['device-lost', 'device', errors[9][2]],
        ['device-lost', 'device', errors[10][2]],
        [
          'memory',
          'box',
          'the flags of 700 x 700 x 600 cells take 294000000 bytes; a buffer of this device has at most 268435456',
        ],
        ['memory', 'box', 'a texture of 2049 x 4 x 4 cells; those of this device have at most 2048 along an axis'],
        'enough',
        ['disposed', undefined, 'the mesh was disposed of'],
      ]);
      assert.match(errors[9][2], /^the device was lost \(destroyed\)/);
      // as the README has them: 9 x 8 x 7 cells, two bytes of bits a row
      assert.deepEqual(sizes, [504, 112, 'r8uint', 7]);
      assert.deepEqual(uncaptured, []);
    });
  });
}

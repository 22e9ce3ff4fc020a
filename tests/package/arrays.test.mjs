// Arrays in and out: sources in arrays of every kind, flags into the caller's arrays, all runs at once, streams of bytes.

import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';

import { SPOT, installedProject } from './project.mjs';

let project;
before(() => (project = installedProject()));
after(() => project.remove());

/** Runs code in the project that has a mesher, the model's bytes and a mesh of it, along an axis. */
function inNode(code, axis = 'auto') {
  const script = `
    import { readFileSync } from 'node:fs';
    import vm from 'node:vm';
    import { createMesher } from 'hexcast';
    const stl = readFileSync(process.argv[2]);
    const print = (value) => console.log(JSON.stringify(value));
    const mesher = await createMesher({ backend: 'cpu' });
    const hashOf = async (source) => (await mesher.mesh({ geometries: [{ source }], dims: [21, 30, 25] })).sha256();
    const mesh = await mesher.mesh({ geometries: [{ source: stl }], dims: [21, 30, 25], axis: '${axis}' });
    const raw = new Uint8Array(await (await mesh.blob('raw')).arrayBuffer());
    ${code}
    mesher.dispose();
  `;
  return JSON.parse(project.run('arrays.js', script, SPOT));
}

test('a file in any buffer, and facets in any array, are the same surface', () => {
  const { expected, files, facets, rounded } = inNode(`
    const buffer = new ArrayBuffer(stl.length + 7);
    new Uint8Array(buffer, 3).set(stl);
    const shared = new SharedArrayBuffer(stl.length);
    new Uint8Array(shared).set(stl);
    const foreign = vm.runInNewContext('new Uint8Array(bytes)', { bytes: [...stl] });
    const files = {
      buffer: buffer.slice(3, 3 + stl.length), view: new DataView(buffer, 3, stl.length), clamped: new Uint8ClampedArray(buffer, 3, stl.length),
      shared, sharedView: new Uint8Array(shared), foreign, foreignBuffer: foreign.buffer, blob: new Blob([stl]), file: new File([stl], 'a.stl'),
    };
    const corners = await (await mesher.read(stl)).corners();
    const positions = [...corners];
    const places = new Map();
    const vertices = [];
    const index = [];
    for (let at = 0; at < positions.length; at += 3) {
      const vertex = positions.slice(at, at + 3);
      const key = vertex.join();
      if (!places.has(key)) places.set(key, vertices.push(vertex) - 1);
      index.push(places.get(key));
    }
    const facets = {
      f32: corners, f64: Float64Array.from(corners), shared: new Float32Array(new SharedArrayBuffer(4 * corners.length)),
      foreign: vm.runInNewContext('new Float32Array(numbers)', { numbers: positions }), list: { positions },
      u16: { positions: vertices.flat(), index: Uint16Array.from(index) }, u32: { positions: Float64Array.from(vertices.flat()), index: Uint32Array.from(index) },
      listed: { positions: Float32Array.from(vertices.flat()), index }, none: { positions: corners, index: null },
    };
    facets.shared.set(corners);
    const hashes = async (sources) => Object.fromEntries(await Promise.all(Object.entries(sources).map(async ([name, source]) => [name, await hashOf(source)])));
    const whole = { positions: new Int8Array([0, 0, 0, 9, 0, 0, 0, 9, 0, 0, 0, 9]), index: new Uint8Array([0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3]) };
    const { info } = await mesher.read(whole);
    print({ expected: await hashOf(stl), files: await hashes(files), facets: await hashes(facets), rounded: [info.volume, info.closed_oriented] });
  `);
  assert.equal(Object.keys(files).length, 9);
  for (const [name, hash] of Object.entries(files)) assert.equal(hash, expected, name);
  assert.equal(Object.keys(facets).length, 9);
  for (const [name, hash] of Object.entries(facets)) assert.equal(hash, expected, name);
  assert.deepEqual(rounded, [121.5, true]);
});

for (const axis of ['x', 'y', 'z']) {
  test(`all runs along ${axis} at once are those of the rays, and expand to the flags`, () => {
    const found = inNode(
      `
      const { offsets, starts, flags } = await mesh.columns.all();
      const across = [0, 1, 2].filter((axis) => axis !== mesh.columns.axis);
      const [n_i, n_j] = across.map((axis) => mesh.dims[axis]);
      const expanded = new Uint8Array(raw.length);
      const strides = [1, mesh.dims[0], mesh.dims[0] * mesh.dims[1]];
      let differing = 0;
      for (let ray = 0; ray < n_i * n_j; ray += 1) {
        const [i, j] = [ray % n_i, Math.floor(ray / n_i)];
        const one = await mesh.columns.ray(i, j);
        const mine = { starts: starts.slice(offsets[ray], offsets[ray + 1]), flags: flags.slice(offsets[ray], offsets[ray + 1]) };
        if (mine.starts.join() !== one.starts.join() || mine.flags.join() !== one.flags.join()) differing += 1;
        for (let run = offsets[ray]; run < offsets[ray + 1]; run += 1) {
          const end = run + 1 < offsets[ray + 1] ? starts[run + 1] : mesh.dims[mesh.columns.axis];
          for (let k = starts[run]; k < end; k += 1) expanded[i * strides[across[0]] + j * strides[across[1]] + k * strides[mesh.columns.axis]] = flags[run];
        }
      }
      const kinds = [offsets, starts, flags].map((array) => array.constructor.name);
      const stop = new AbortController();
      const aborted = mesh.columns.all({ onProgress: () => stop.abort('enough'), signal: stop.signal }).catch((reason) => reason);
      print({ differing, kinds, isSame: Buffer.compare(expanded, raw) === 0, n: [offsets.length, mesh.report.rays, starts.length, mesh.columns.runs], aborted: await aborted });
    `,
      axis,
    );
    assert.deepEqual([found.differing, found.isSame, found.aborted], [0, true, 'enough']);
    assert.deepEqual(found.kinds, ['Uint32Array', 'Uint32Array', 'Uint8Array']);
    const [n_offsets, n_rays, n_starts, n_runs] = found.n;
    assert.deepEqual([n_offsets, n_starts], [n_rays + 1, n_runs]);
  });
}

test("boxes and slabs go into the caller's array, also a shared one, and large boxes are the file", () => {
  const found = inNode(`
    const into = new Uint8Array(new SharedArrayBuffer(raw.length + 5));
    into.fill(9);
    const all = await mesh.box([0, 0, 0], mesh.dims, { into });
    const isMine = all.flags.buffer === into.buffer && all.flags.length === raw.length && into.at(-1) === 9;
    const isWhole = Buffer.compare(Buffer.from(all.flags), raw) === 0;
    const part = (await mesh.box([3, 4, 5], [4, 9, 7])).flags;
    const cells = [];
    for (let z = 5; z < 7; z += 1) for (let y = 4; y < 9; y += 1) cells.push(raw[3 + 21 * (y + 30 * z)]);
    const slabs = [];
    const place = new Uint8Array(1000);
    let n_slabs = 0;
    for await (const { flags } of mesh.slabs({ into: place })) {
      if (flags.buffer === place.buffer) n_slabs += 1;
      slabs.push(...flags);
    }
    const empty = (await mesh.box([1, 1, 1], [1, 5, 5])).flags.length;
    // more than one piece: 300^3 bytes
    const large = await mesher.mesh({ geometries: [{ source: stl }], dims: [300, 300, 300] });
    const bytes = new Uint8Array(await (await large.blob('raw')).arrayBuffer());
    const isLarge = Buffer.compare((await large.box([0, 0, 0], [300, 300, 300])).flags, bytes) === 0;
    print({ isMine, isWhole, part: [...part], cells, n_slabs, isSlabs: Buffer.compare(Uint8Array.from(slabs), raw) === 0, empty, isLarge });
  `);
  assert.ok(found.isMine && found.isWhole && found.isSlabs && found.isLarge, JSON.stringify(found));
  assert.deepEqual(found.part, found.cells);
  assert.ok(found.n_slabs > 15, `${found.n_slabs} slabs`);
  assert.equal(found.empty, 0);
});

test("streams fill the reader's own buffers, and go through what takes streams of bytes", () => {
  const found = inNode(`
    const { Readable } = await import('node:stream');
    const reader = mesh.stream('raw').getReader({ mode: 'byob' });
    const pieces = [];
    let view = new Uint8Array(4096);
    for (;;) {
      const { done, value } = await reader.read(view);
      if (done) break;
      pieces.push(value.slice());
      view = new Uint8Array(value.buffer);
    }
    const isRaw = Buffer.compare(Buffer.concat(pieces), raw) === 0;
    const chunks = [];
    for await (const chunk of Readable.fromWeb(mesh.stream('raw'))) chunks.push(chunk);
    const isReadable = Buffer.compare(Buffer.concat(chunks), raw) === 0;
    const there = mesh.stream('raw').pipeThrough(new CompressionStream('gzip')).pipeThrough(new DecompressionStream('gzip'));
    const isPiped = Buffer.compare(Buffer.from(await new Response(there).arrayBuffer()), raw) === 0;
    print({ isRaw, isReadable, isPiped, largest: Math.max(...pieces.map((piece) => piece.length)) });
  `);
  assert.deepEqual(found, { isRaw: true, isReadable: true, isPiped: true, largest: 4096 });
});

test('a surface can be meshed before its edges are looked at, and drawn with fewer facets', () => {
  const found = inNode(`
    const whole = await mesher.read(stl, { file: 'spot.stl' });
    const surface = await mesher.read(stl, { file: 'spot.stl', check: false });
    const before = Object.keys(surface.info);
    const sha256 = await hashOf(surface);
    const told = [];
    const same = (await surface.check({ onProgress: ({ stage, done, total }) => told.push([stage, done / total]) })) === surface;
    const n = async (maxFacets) => (await surface.preview(maxFacets)).length / 9;
    const all = await surface.preview(5856);
    const corners = await surface.corners();
    const reasons = await Promise.all([0, 1.5, NaN, '7', 2 ** 32].map((max) => surface.preview(max).catch((error) => error.details.key)));
    const wrong = await mesher.read(stl, { check: 1 }).catch((error) => error.details.key);
    const stop = new AbortController();
    stop.abort('enough');
    const aborted = await mesher.read(stl, { check: false }).then((other) => other.check({ signal: stop.signal })).catch((reason) => reason);
    const isWhole = all.length === corners.length && all.every((number, at) => number === corners[at]);
    print({ before, info: surface.info, expected: whole.info, sha256, expectedHash: await mesh.sha256(), told, same, isWhole, some: await n(1000), few: await n(20), reasons, wrong, aborted });
  `);
  assert.ok(found.before.includes('bounding_box') && !found.before.includes('closed_parity'));
  assert.deepEqual(found.info, found.expected);
  assert.equal(found.sha256, found.expectedHash);
  assert.deepEqual(found.told.at(-1), ['check', 1]);
  assert.ok(found.same && found.isWhole);
  assert.ok(found.some > 200 && found.some <= 1000, `${found.some}`);
  assert.ok(found.few > 0 && found.few <= 20, `${found.few}`);
  assert.deepEqual(new Set(found.reasons), new Set(['maxFacets']));
  assert.deepEqual([found.wrong, found.aborted], ['check', 'enough']);
});

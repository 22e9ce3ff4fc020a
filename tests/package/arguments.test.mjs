// What callers pass wrongly is refused by its key, and what went wrong is told in JavaScript's words: nothing is guessed.

import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';

import { SPOT, installedProject } from './project.mjs';

let project;
before(() => (project = installedProject()));
after(() => project.remove());

/** Runs code in the project; it has a mesher, the bytes of the model, `told` for what a call ends with, and answers with `print`. */
function inNode(code) {
  const script = `
    import { readFileSync } from 'node:fs';
    import { HexcastError, createMesher } from 'hexcast';
    const stl = readFileSync(process.argv[2]);
    const print = (value) => console.log(JSON.stringify(value));
    const facts = (error) => error instanceof HexcastError
      ? { code: error.code, message: error.message, hint: error.hint, details: error.details, cause: error.cause && String(error.cause) }
      : { other: String(error) };
    const told = async (call) => { try { await call(); return 'no error'; } catch (error) { return facts(error); } };
    const mesher = await createMesher({ backend: 'cpu' });
    ${code}
    mesher.dispose();
  `;
  return JSON.parse(project.run('arguments.js', script, SPOT));
}

/** The keys of a job that are numbers, each with a job that has one number in that place. */
const NUMBERS = `{
  cells: (n) => ({ cells: n }), 'dims[1]': (n) => ({ dims: [4, n, 4] }), cell_size: (n) => ({ cell_size: n }),
  'cell_size[2]': (n) => ({ cell_size: [1, 1, n] }), max_cell_size: (n) => ({ max_cell_size: n }),
  tolerance: (n) => ({ max_cell_size: 0.1, tolerance: n }), max_cells: (n) => ({ max_cells: n }),
  'domain[3]': (n) => ({ domain: [0, 0, 0, n, 1, 1] }), 'padding.cells': (n) => ({ padding: { cells: n } }),
  'padding.length[0]': (n) => ({ padding: { length: [n, 0, 0] } }), close_gaps: (n) => ({ close_gaps: n }),
  gap_flag: (n) => ({ close_gaps: 2, gap_flag: n }), thin_cells: (n) => ({ certify: true, thin_cells: n }),
  max_memory: (n) => ({ max_memory: n }), 'window[3]': (n) => ({ window: [0, 0, 0, n, 1, 1] }),
  'part.index': (n) => ({ part: { index: n, of: [2, 1, 1] } }), 'part.of[0]': (n) => ({ part: { index: 1, of: [n, 1, 1] } }),
  'geometries[0].flag': (n) => ({ g: { flag: n } }), 'geometries[0].priority': (n) => ({ g: { priority: n } }),
  'geometries[0].scale': (n) => ({ g: { scale: n } }), 'geometries[0].scale[1]': (n) => ({ g: { scale: [1, n, 1] } }),
  'geometries[0].rotate[0]': (n) => ({ g: { rotate: [n, 0, 0] } }), 'geometries[0].about[1]': (n) => ({ g: { rotate: [0, 0, 90], about: [0, n, 0] } }), 'geometries[0].translate[2]': (n) => ({ g: { translate: [0, 0, n] } }),
}`;

test('every number of a job that is none, or infinite, is refused by its key; so are BigInts and functions', () => {
  const found = inNode(`
    const found = {};
    for (const [key, job] of Object.entries(${NUMBERS})) {
      found[key] = [];
      for (const value of [NaN, Infinity, -Infinity, 5n, () => 5, Symbol('5')]) {
        const { g, ...others } = job(value);
        found[key].push(await told(() => mesher.estimate({ geometries: [{ source: stl, ...g }], ...others })));
      }
    }
    print(found);
  `);
  assert.equal(Object.keys(found).length, 24);
  for (const [key, problems] of Object.entries(found)) {
    assert.equal(problems.length, 6);
    for (const [at, { code, message, details }] of problems.entries()) {
      assert.equal(code, 'job-value', `${key}: ${message}`);
      assert.equal(details.key, key);
      const value = ['NaN', 'Infinity', '-Infinity', 'the BigInt 5', 'a function', 'Symbol(5)'][at];
      assert.ok(message.startsWith(`${key} is ${value}; allowed: `), message);
    }
  }
});

test('keys without a value are left out, and lists of numbers may be typed arrays', () => {
  const found = inNode(`
    const geometries = [{ source: stl, flag: undefined }];
    const { dims, report } = await mesher.mesh({ geometries, dims: new Uint32Array([5, 6, 7]), cells: undefined });
    print([dims, report.flags.map(({ flag }) => flag)]);
  `);
  assert.deepEqual(found, [[5, 6, 7], [1]]);
});

/** Wrong calls: code in the project, the key at fault, and how the message begins. */
const WRONG = [
  ["createMesher({ bakend: 'cpu' })", 'bakend', 'bakend is no option of this call; allowed: backend, '],
  ["createMesher({ backend: 'cuda' })", 'backend', 'backend is "cuda"; allowed: "auto", "gpu", "cpu"'],
  ['createMesher(null)', 'the options', 'the options is null'],
  ['createMesher({ worker: 5 })', 'worker', 'worker is 5; allowed: '],
  ['createMesher({ wasm: 5 })', 'wasm', 'wasm is 5; allowed: '],
  ['createMesher({ signal: 5 })', 'signal', 'signal is 5; allowed: an AbortSignal'],
  ['mesher.mesh()', 'the job', 'the job is undefined; allowed: an object'],
  ['mesher.mesh(5)', 'the job', 'the job is 5'],
  ["mesher.mesh({ ...job, backend: 'gpu' })", 'backend', 'backend is no key of a job'],
  [
    'mesher.mesh(job, { spil: true })',
    'spil',
    'spil is no option of this call; allowed: spill, maxDeviceBytes, signal, onProgress',
  ],
  ["mesher.mesh(job, { spill: 'yes' })", 'spill', 'spill is "yes"; allowed: "auto", true, false'],
  ['mesher.mesh(job, { onProgress: 5 })', 'onProgress', 'onProgress is 5; allowed: a function'],
  ['mesher.mesh({ geometries: {} })', 'geometries', 'geometries is an object (Object); allowed: a list'],
  ['mesher.mesh({ geometries: [null] })', 'geometries[0]', 'geometries[0] is null; allowed: an object with a source'],
  ['mesher.mesh({ geometries: [{}] })', 'geometries[0].source', 'geometries[0].source is undefined; allowed: a Blob, '],
  ['mesher.mesh({ geometries: [{ source: stl, file: 5 }] })', 'geometries[0].file', 'geometries[0].file is 5; allowed: text'],
  ['mesher.mesh({ geometries: [{ source: gone }] })', 'geometries[0].source', 'geometries[0].source is "detached"'],
  [
    'mesher.mesh({ ...job, padding: { cells: [0, { a: new Map(), b: NaN }, 0] } })',
    'padding.cells[1].b',
    'padding.cells[1].b is NaN',
  ],
  ['mesher.mesh(circle)', 'self.self.self.self.self.self.self.self', ''],
  [
    'mesher.mesh(job, { maxDeviceBytes: NaN })',
    'maxDeviceBytes',
    'maxDeviceBytes is NaN; allowed: whole numbers from 1048576 to ',
  ],
  ["mesher.read(stl, { check: 'no' })", 'check', 'check is "no"; allowed: true, false'],
  ['mesher.read(null)', 'source', 'source is null; allowed: '],
  ['mesher.read(stl, { file: 5 })', 'file', 'file is 5; allowed: text'],
  ['mesher.read(new Date())', 'source', 'source is an object (Date); allowed: '],
  [
    'mesher.read({ positions: [0, 0, 0, 1, 0, 0, 0, 1, 0], index: [0, 1, 3] })',
    'source.index[2]',
    'source.index[2] is 3; allowed: whole numbers from 0 to 2',
  ],
  ['mesher.read({ positions: [0, 0, 0], index: [0, 0] })', 'source.index', 'source.index has 2 numbers'],
  [
    'mesher.read({ positions: [0, 0, 0], indices: [0, 0, 0] })',
    'source.indices',
    'source.indices is a list of 3; allowed: nothing',
  ],
  ["mesher.read({ positions: ['0', 0, 0] })", 'source.positions[0]', 'source.positions[0] is "0"; allowed: numbers'],
  ['mesher.open(5)', 'file', 'file is 5; allowed: a Blob, '],
  ['mesh.flag(1.7, 0, 0)', 'x', 'x is 1.7; allowed: whole numbers from 0 to 7'],
  ['mesh.flag(0, 2 ** 32, 0)', 'y', 'y is 4294967296; allowed: whole numbers from 0 to 5'],
  ['mesh.flag(0, 0)', 'z', 'z is undefined'],
  ['mesh.box([2 ** 32, 0, 0], [1, 1, 1])', 'start[0]', 'start[0] is 4294967296; allowed: whole numbers from 0 to 8'],
  ['mesh.box([0, 3, 0], [1, 1, 1])', 'end[1]', 'end[1] is 1; allowed: whole numbers from 3 to 6'],
  ['mesh.box([0, 0], [1, 1, 1])', 'start', 'start is a list of 2; allowed: three whole numbers'],
  ['mesh.box([0, 0, 0], [2, 2, 2], { into: new Uint8Array(7) })', 'into', 'into has 7 bytes; a box of 2 x 2 x 2 cells has 8'],
  ['mesh.slice(3, 0)', 'axis', 'axis is 3; allowed: whole numbers from 0 to 2'],
  ['mesh.slice(0, 8)', 'index', 'index is 8; allowed: whole numbers from 0 to 7'],
  ['mesh.skin({ maxQuads: NaN })', 'maxQuads', 'maxQuads is NaN'],
  ['mesh.slabs({ maxBytes: 0 }).next()', 'maxBytes', 'maxBytes is 0'],
  ["mesh.blob('dae')", 'format', 'format is "dae"; allowed: "vti", "vtr", "npy", "npz", "raw", "hxc"'],
  ["mesh.blob('vti', { compress: 300 })", 'compress', 'compress is 300; allowed: whole numbers from 0 to 9'],
  ["mesh.blob('vti', { compres: 3 })", 'compres', 'compres is no option of this call'],
  ["mesh.size('raw', { bits: 1 })", 'bits', 'bits is 1; allowed: true, false'],
  ['mesh.columns.ray(0.5, 0)', 'i', 'i is 0.5'],
];

test('wrong calls are job-value errors with the key and no stack in the message', () => {
  const found = inNode(`
    const job = { geometries: [{ source: stl }], dims: [8, 6, 7] };
    const mesh = await mesher.mesh(job);
    const circle = {};
    circle.self = circle;
    const gone = new ArrayBuffer(100);
    structuredClone(gone, { transfer: [gone] });
    print([${WRONG.map(([call]) => `await told(() => ${call})`).join(', ')}]);
  `);
  assert.equal(found.length, WRONG.length);
  for (const [at, [call, key, message]] of WRONG.entries()) {
    const { code, details } = found[at];
    assert.deepEqual([code, details?.key], ['job-value', key], `${call}: ${JSON.stringify(found[at])}`);
    assert.ok(found[at].message.startsWith(message), `${call}: ${found[at].message}`);
    assert.doesNotMatch(found[at].message, /\n| at .*\.js/);
  }
});

test('errors of the core name the key, and hints speak of the package, not of the command line', () => {
  const [empty, unknown, memory, range] = inNode(`
    const geometries = [{ source: stl }];
    print([
      await told(() => mesher.mesh({ geometries: [] })), await told(() => mesher.mesh({ geometries, cels: 3 })),
      await told(() => mesher.mesh({ geometries, cells: 4000, max_memory: '1MB' })), await told(() => mesher.mesh({ geometries: [{ source: stl, scale: 0 }] })),
    ]);
  `);
  assert.deepEqual([empty.code, empty.hint], ['job-empty', 'give at least one geometry']);
  assert.deepEqual(
    [unknown.code, unknown.details, unknown.hint],
    ['job-value', { key: 'cels' }, 'compare with the type Job of the package'],
  );
  assert.equal(memory.code, 'memory');
  assert.match(memory.hint, /^allow [\d.]+ MB with max_memory/);
  assert.deepEqual([range.code, range.details], ['job-value', { key: 'geometries[0].scale' }]);
  for (const { hint } of [empty, unknown, memory, range]) assert.doesNotMatch(hint, /--|TOML|\[\[/);
});

test('a box that no array can hold is the error memory, and the mesh stays usable', () => {
  const { refused, flag } = inNode(`
    const mesh = await mesher.mesh({ geometries: [{ source: stl }], dims: [1098, 1969, 2000] });
    print({ refused: await told(() => mesh.box([0, 0, 0], [1098, 1969, 2000])), flag: await mesh.flag(0, 0, 0) });
  `);
  assert.deepEqual([refused.code, refused.hint, refused.details], ['memory', 'read slabs', { bytes: 1098 * 1969 * 2000 }]);
  assert.match(refused.message, /^a box of 1098 x 1969 x 2000 cells has 4323924000 bytes/);
  assert.equal(flag, 0);
});

test('what was disposed of says so', () => {
  const found = inNode(`
    const surface = await mesher.read(stl);
    const mesh = await mesher.mesh({ geometries: [{ source: surface }], cells: 5 });
    const other = await mesher.mesh({ geometries: [{ source: surface }], cells: 5 });
    surface.dispose();
    mesh.dispose();
    const found = [];
    for (const call of [() => surface.corners(), () => mesher.mesh({ geometries: [{ source: surface }] }), () => mesh.flag(0, 0, 0),
      () => mesh.blob('raw'), () => mesh.slabs().next()]) found.push((await told(call)).code);
    mesher.dispose();
    for (const call of [() => other.flag(0, 0, 0), () => mesher.read(stl)]) found.push((await told(call)).code);
    print(found);
  `);
  assert.deepEqual(found, Array(7).fill('disposed'));
});

test('where onProgress throws the call rejects with callback and that error as its cause, and the next one works', () => {
  const found = inNode(`
    const job = { geometries: [{ source: stl }], cells: 60 };
    const onProgress = () => { throw new TypeError('mine'); };
    const found = [await told(() => mesher.mesh(job, { onProgress })), await told(() => mesher.read(stl, { onProgress }))];
    const mesh = await mesher.mesh(job);
    for (const call of [() => mesh.sha256({ onProgress }), () => mesh.blob('vti', { compress: 1, onProgress })]) found.push(await told(call));
    print(found);
  `);
  for (const { code, message, cause } of found)
    assert.deepEqual([code, message, cause], ['callback', 'onProgress threw: mine', 'TypeError: mine']);
  assert.equal(found.length, 4);
});

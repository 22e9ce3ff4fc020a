// Pictures and comparisons of meshes: their bytes and numbers are those of the native command.

import assert from 'node:assert/strict';
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { after, before, test } from 'node:test';

import { SPOT, installedProject, nativeCommand, writeBodies } from './project.mjs';

let project;
let folder;
before(() => {
  project = installedProject();
  folder = mkdtempSync(path.join(tmpdir(), 'hexcast-pictures-'));
  writeBodies(folder);
});
after(() => {
  project.remove();
  rmSync(folder, { recursive: true, force: true });
});

const BODIES = [
  { file: 'foot.stl', flag: 3, name: 'Fuß <1>' },
  { file: 'arm.stl', flag: 1, name: '7 arms' },
  { file: 'tip.stl', flag: 200 },
];
const COW = { file: SPOT, flag: 7, name: 'cow' };

/** Jobs by what they are. */
const JOBS = {
  'cubes of several flags': { geometries: BODIES, cell_size: 0.5, padding: { cells: 1 }, unit: 'mm' },
  'cells that are no cubes, rays along y': { geometries: [COW], dims: [31, 17, 43], axis: 'y' },
  'cells that differ in size': { geometries: BODIES, graded: { max_size: [2, 1.5, 1] }, padding: { length: 3 }, unit: 'cm' },
  'more cells than pixels': { geometries: [COW], cells: 900, axis: 'z' },
};

/** The call, its options, and the words of the command, for a mesh that has cells in a box. */
const picturesOf = (box) => [
  ['slice', {}, []],
  ['slice', { axis: 'x', at: ['25%', '0%', '100%', 0.3], size: 300 }, ['--axis=x', '--at=25%,0%,100%,0.3', '--size=300']],
  ['slice', { axis: ['z', 'y'], at: 0.1, lines: false }, ['--axis=z,y', '--at=0.1', '--no-lines']],
  ['slice', { flags: [0, 7, 3], colours: { 7: '#010203', 0: '#FFEEDD' } }, ['--flags=0,7,3', '--colours=7=010203,0=#FFEEDD']],
  ['view', {}, []],
  ['view', { direction: [30.5, -20], size: 411 }, ['--direction=30.5,-20', '--size=411']],
  [
    'view',
    { window: [...box.start, ...box.end], colours: { 1: '#abcdef' } },
    [`--window=${[...box.start, ...box.end]}`, '--colours=1=abcdef'],
  ],
  ['view', { flags: [7, 3], size: 200 }, ['--flags=7,3', '--size=200']],
];

const command = (...args) => nativeCommand(folder, ...args);

/** Meshes a job with the command. */
function meshed(job, name) {
  writeFileSync(path.join(folder, `${name}.json`), JSON.stringify(job));
  const { status, stderr } = command('mesh', '--job', `${name}.json`, '--backend=cpu', '-q', '-o', `${name}.hxc`);
  assert.equal(status, 0, stderr);
}

/** Runs a script that has `mesher`, `meshOf(name)` of the jobs written here, `read(name)`, `told(promise)`, `asked` and `folder`. */
function run(script, asked = {}) {
  writeFileSync(path.join(folder, 'asked.json'), JSON.stringify(asked));
  const code = `
    import { readFileSync, writeFileSync } from 'node:fs';
    import { createMesher } from 'hexcast';
    const [folder] = process.argv.slice(2);
    const read = (name) => readFileSync(folder + '/' + name);
    const asked = JSON.parse(read('asked.json'));
    const mesher = await createMesher({ backend: 'cpu' });
    const meshOf = (name) => {
      const job = JSON.parse(read(name + '.json'));
      const source = (file) => readFileSync(file.startsWith('/') ? file : folder + '/' + file);
      return mesher.mesh({ ...job, geometries: job.geometries.map((one) => ({ ...one, source: source(one.file) })) });
    };
    const bytesOf = async (blob) => Buffer.from(await blob.arrayBuffer());
    const told = (promise) => promise.then(() => 'done', ({ code, message, hint, name }) => ({ code, message, hint, name }));
    ${script}
    mesher.dispose();
  `;
  return JSON.parse(project.run('script.js', code, folder));
}

for (const [name, job] of Object.entries(JOBS)) {
  test(`${name}: pictures are those of the native command`, () => {
    meshed(job, 'mesh');
    const [{ dims }] = JSON.parse(command('info', 'mesh.hxc', '--json').stdout);
    const pictures = picturesOf({ start: [0, 0, 0], end: [dims[0], Math.ceil(dims[1] / 2), dims[2]] });
    const types = run(
      `const meshes = [await meshOf('mesh'), await mesher.open(read('mesh.hxc'))];
      const types = [];
      for (const [at, [call, options]] of asked.entries()) {
        for (const [of, mesh] of meshes.entries()) {
          const blob = await mesh[call](options);
          types.push(blob.type);
          writeFileSync(folder + '/ours-' + at + '-' + of + '.png', await bytesOf(blob));
        }
      }
      console.log(JSON.stringify(types));`,
      pictures,
    );
    assert.deepEqual([...new Set(types)], ['image/png']);
    assert.equal(types.length, 2 * pictures.length);
    for (const [at, [call, options, words]] of pictures.entries()) {
      const { status, stderr } = command(call, 'mesh.hxc', ...words, '-o', 'native.png');
      assert.equal(status, 0, `${call} ${words}: ${stderr}`);
      const bytes = readFileSync(path.join(folder, 'native.png'));
      assert.equal(bytes.toString('latin1', 1, 4), 'PNG');
      for (const of of [0, 1]) {
        const ours = readFileSync(path.join(folder, `ours-${at}-${of}.png`));
        const what = `${call} ${JSON.stringify(options)}, ${of ? 'an opened file' : 'a mesh'}`;
        assert.ok(ours.equals(bytes), `${what}: ${ours.length} bytes, natively ${bytes.length}`);
      }
    }
  });
}

test('what differs between two meshes is what the native command finds, and so is the mask', () => {
  const dims = { dims: [31, 17, 43], domain: [-0.6, -0.8, -0.6, 0.6, 1.0, 1.2] };
  const jobs = {
    one: { geometries: [COW], ...dims, axis: 'x' },
    // the cow moved, of another flag, rays along another axis
    other: { geometries: [{ ...COW, flag: 9, translate: [0.1, 0, 0.05] }], ...dims, axis: 'z', unit: 'mm' },
    lines: { geometries: [COW], ...dims, domain: [-0.6, -0.8, -0.6, 0.6, 1.0, 1.3] },
  };
  for (const [name, job] of Object.entries(jobs)) meshed(job, name);
  const pairs = [
    ['one', 'other'],
    ['other', 'one'],
    ['one', 'one'],
    ['one', 'lines'],
  ];
  const found = run(
    `const found = [];
    for (const [at, [one, other]] of asked.entries()) {
      const mesh = await meshOf(one);
      const bytes = read(other + '.hxc');
      const others = [await meshOf(other), await mesher.open(bytes), bytes, new Blob([bytes]), new Uint8Array(bytes).buffer];
      for (const of of others) {
        const { mask, ...facts } = await mesh.diff(of);
        writeFileSync(folder + '/ours-' + at + '.raw', await bytesOf(await mask.blob('raw')));
        found.push({ facts, hash: await mask.sha256(), names: mask.report.flags.map(({ name }) => name) });
        mask.dispose();
      }
      mesh.dispose();
    }
    console.log(JSON.stringify(found));`,
    pairs,
  );
  assert.equal(found.length, 5 * pairs.length);
  for (const [at, [one, other]] of pairs.entries()) {
    const { status, stdout, stderr } = command('diff', `${one}.hxc`, `${other}.hxc`, '--json', '-o', 'native.raw');
    assert.equal(status, one === other ? 0 : 1, stderr);
    const expected = JSON.parse(stdout);
    for (const { facts } of found.slice(5 * at, 5 * at + 5)) assert.deepEqual(facts, expected);
    assert.equal(new Set(found.slice(5 * at, 5 * at + 5).map(({ hash }) => hash)).size, 1);
    assert.ok(readFileSync(path.join(folder, `ours-${at}.raw`)).equals(readFileSync(path.join(folder, 'native.raw'))));
  }
  assert.equal(found[0].facts.pairs.length, 3);
  assert.deepEqual(found[0].names, ['different']);
  assert.equal(found.at(-1).facts.are_lines_equal, false);
});

test('what cannot be drawn or compared is refused, and the mesher stays usable', () => {
  meshed({ geometries: BODIES, cells: 9 }, 'mesh');
  meshed({ geometries: BODIES, cells: 10 }, 'other');
  const asked = [
    ["mesh.slice({ axis: 'w' })", 'job-value', /^axis is "w"; allowed: "x", "y", "z"/],
    ['mesh.slice({ axis: 0 })', 'job-value', /^axis is 0/],
    ['mesh.slice({ at: NaN })', 'job-value', /^at is NaN/],
    ["mesh.slice({ at: '' })", 'job-value', /^at is ""/],
    ["mesh.slice({ at: ['1,2'] })", 'job-value', /^at is "1,2"/],
    ["mesh.slice({ at: '101%' })", 'job-value', /^"101%" is not a place/],
    ["mesh.slice({ axis: 'x', at: 9.1 })", 'job-value', /^9\.1 is not within the mesh, which reaches from 0 to 9 along x/],
    ['mesh.slice({ size: 0 })', 'job-value', /^size is 0; allowed: whole numbers from 1 to 32768/],
    ["mesh.slice({ axis: 'z', size: 32000 })", 'memory', /bytes of memory; 1073741824 are allowed$/],
    ['mesh.slice({ max_memory: 1000 })', 'memory', /; 1000 are allowed$/],
    ["mesh.slice({ colours: { 1: 'red' } })", 'job-value', /^colours\[1\] is "red"/],
    ["mesh.slice({ colours: { 256: '#000000' } })", 'job-value', /^a flag of colours is 256/],
    ["mesh.slice({ colours: { '': '#000000' } })", 'job-value', /^a flag of colours is ""/],
    ['mesh.slice({ flags: 1 })', 'job-value', /^flags is 1/],
    ['mesh.slice({ flags: [1, -1] })', 'job-value', /^flags\[1\] is -1/],
    ['mesh.slice({ lines: 1 })', 'job-value', /^lines is 1/],
    ['mesh.slice({ axes: [] })', 'job-value', /^axes is no option of this call/],
    ['mesh.slice(null)', 'job-value', /^axis is null/],
    ['mesh.view({ direction: [1] })', 'job-value', /^direction is a list of 1; allowed: two angles/],
    ['mesh.view({ direction: [1, Infinity] })', 'job-value', /^direction is/],
    ['mesh.view({ window: [0, 0, 0, 10, 1, 1] })', 'job-value', /^the end of window\[0\] is 10/],
    ['mesh.view({ window: [0, 0, 5, 1, 1, 6] })', 'job-value', /^no cell has a flag: there is nothing to see/],
    ['mesh.view({ flags: [77] })', 'job-value', /^no cell has one of the flags \[77\]/],
    ['mesh.view({ max_memory: 100000 })', 'memory', /bytes of memory; 100000 are allowed$/],
    ['mesh.view({ at: 1 })', 'job-value', /^at is no option/],
    ["mesh.diff(read('other.hxc'))", 'job-conflict', /^one mesh has 9 x 4 x 6 cells, the other 10 x /],
    ["mesh.diff(read('foot.stl'))", 'columns-corrupt', /./],
    ['mesh.diff(7)', 'job-value', /^other is 7/],
    ['mesh.diff(elsewhere)', 'job-value', /^the other mesh belongs to another mesher/],
    ['mesh.diff(gone)', 'disposed', /^the mesh was disposed of/],
    ['gone.slice({})', 'disposed', /./],
    ['mesh.diff(mesh, { max_memory: -1 })', 'job-value', /^max_memory is -1/],
    ['mesh.diff(shifted, { max_memory: 8 })', 'memory', /^the cells that differ take more than 8 bytes/],
  ];
  const script = `
    const mesh = await meshOf('mesh');
    const gone = await meshOf('mesh');
    gone.dispose();
    const second = await createMesher({ backend: 'cpu' });
    const elsewhere = await second.open(read('mesh.hxc'));
    const job = JSON.parse(read('mesh.json'));
    const shifted = await mesher.mesh({ cells: 9, geometries: job.geometries.map((one) => ({ ...one, flag: 5, source: read(one.file) })) });
    const all = [];
    ${asked.map(([call]) => `all.push(await told(${call}));`).join('\n')}
    all.push((await bytesOf(await mesh.slice({}))).length);
    second.dispose();
    console.log(JSON.stringify(all));`;
  const told = run(script);
  for (const [at, [call, code, pattern]] of asked.entries()) {
    assert.equal(told[at].code, code, `${call}: ${JSON.stringify(told[at])}`);
    assert.match(told[at].message, pattern, call);
  }
  assert.ok(told.at(-1) > 1000);
});

test('work rests, so that other calls and an abort arrive while it goes on', () => {
  meshed({ geometries: [COW], cells: 700, axis: 'x' }, 'large');
  meshed({ geometries: [COW], cells: 700, axis: 'z' }, 'turned');
  const { order, stopped, after } = run(`
    const [mesh, other] = [await meshOf('large'), await meshOf('turned')];
    const work = {
      slice: (options) => mesh.slice({ size: 3000, ...options }),
      view: (options) => mesh.view({ size: 3000, ...options }),
      diff: (options) => mesh.diff(other, options),
    };
    const order = [];
    const stopped = [];
    for (const [name, start] of Object.entries(work)) {
      const done = start().then(() => order.push(name));
      await mesh.flag(1, 2, 3);
      await mesh.flag(3, 2, 1);
      order.push('flags');
      await done;
      const stop = new AbortController();
      const ended = told(start({ signal: stop.signal }));
      await mesh.flag(1, 2, 3);
      stop.abort();
      stopped.push((await ended).name);
    }
    const [picture] = await Promise.all([mesh.view({ size: 100 }), mesh.slice({ size: 100 })]);
    console.log(JSON.stringify({ order, stopped, after: picture.size }));`);
  assert.deepEqual(order, ['flags', 'slice', 'flags', 'view', 'flags', 'diff']);
  assert.deepEqual(stopped, ['AbortError', 'AbortError', 'AbortError']);
  assert.ok(after > 500);
});

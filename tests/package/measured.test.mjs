// Cells that differ in size, links, fractions of cells, staggered grids, edges and faces outside metal, permittivity, and distances: the bytes of every file are those of the native command.

import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { after, before, test } from 'node:test';

import { ROOT } from '../../scripts/run.mjs';
import { OPEN_BOX, boxBetween } from '../e2e/open_box.mjs';
import { COMMAND, SPOT, installedProject } from './project.mjs';

let project;
let folder;
before(() => {
  project = installedProject();
  folder = mkdtempSync(path.join(tmpdir(), 'hexcast-measured-'));
  writeFileSync(path.join(folder, 'board.stl'), boxBetween([0, 0, 0], [40, 30, 1.6]));
  writeFileSync(path.join(folder, 'patch.stl'), boxBetween([10, 8, 1.6], [28, 21, 1.65]));
  writeFileSync(path.join(folder, 'open.stl'), OPEN_BOX);
});
after(() => {
  project.remove();
  rmSync(folder, { recursive: true, force: true });
});

const board = { file: 'board.stl', min_cells: 3, material: { eps_r: 4.5 } };
const patch = { file: 'patch.stl', metal: true, max_size: 1 };
const cow = { file: SPOT, flag: 7, name: 'cow' };
const uneven = (first, last, n) => Array.from({ length: n + 1 }, (_, i) => first + (last - first) * (i / n) ** 1.3);

/** Jobs by what they ask for. */
const JOBS = {
  'generated lines': {
    geometries: [board, patch],
    graded: { max_size: [3, 3, 2], min_size: 0.02, growth: 1.4, absorbing: 3 },
    padding: { length: 12 },
    unit: 'mm',
  },
  'listed lines': {
    geometries: [cow],
    lines: { x: uneven(-0.6, 0.5, 37), y: uneven(-0.8, 1, 41), z: uneven(-0.6, 1.1, 29) },
    axis: 'y',
    tensors: { anisotropic: [{ flag: 7, eps_r: [2.25, 3, 4, 0.5, 0, 0] }] },
  },
  'a window of listed lines': {
    geometries: [cow],
    lines: { x: uneven(-0.6, 0.5, 37), y: uneven(-0.8, 1, 41), z: uneven(-0.6, 1.1, 29) },
    window: [5, 6, 7, 30, 31, 20],
    halo: 2,
    certify: true,
    links: { stencil: 'D3Q7' },
    fractions: { rays: 2, surfaces: true },
  },
  'lines that are equally spaced': {
    geometries: [{ ...cow, fill: 'separating' }],
    lines: { x: [-1, -0.75, -0.5, -0.25, 0, 0.25, 0.5], y: [-1, -0.5, 0, 0.5, 1], z: [-1, -0.5, 0, 0.5] },
  },
  'links, fractions and a staggered grid': {
    geometries: [cow],
    cells: 25,
    padding: { cells: 2 },
    links: { stencil: 'D3Q27' },
    fractions: { rays: 2, faces: true, surfaces: true },
    staggered: true,
    conformal: { metal: [7] },
    tensors: {},
  },
  'links and fractions on generated lines': {
    geometries: [board, patch],
    graded: { max_size: 4 },
    links: { stencil: 'D3Q7', fluid: [0, 1] },
    fractions: { method: 'exact', faces: true, surfaces: true, edges: true, centroids: true },
    staggered: true,
    conformal: { stable: 0.25 },
    distance: { at: 'nodes', band: 'all' },
    tensors: {},
  },
  'links and a staggered grid around an open surface and a sheet': {
    geometries: [
      { file: 'open.stl', flag: 3 },
      { file: 'patch.stl', fill: 'separating', shell: true },
    ],
    dims: [31, 26, 22],
    domain: [-4, -4, -4, 30, 25, 7],
    links: { stencil: 'D3Q15' },
    staggered: true,
  },
};

const FILES = { vtr: ['vtr'], npz: ['npz'], hxc: ['hxc'], npy: ['npy'], raw: ['raw'] };

/** What the native command makes of a job: its report, and the bytes of all files. */
function native(job, compress) {
  const name = path.join(folder, 'native');
  writeFileSync(`${name}.json`, JSON.stringify(job));
  const outputs = Object.keys(FILES)
    .filter((ending) => compress === 'none' || !['npy', 'raw'].includes(ending))
    .map((ending) => `${name}.${ending}`);
  const measured = ['links', 'fractions', 'staggered', 'conformal', 'tensors', 'distance'].filter((of) => job[of]);
  const args = ['mesh', '--job', `${name}.json`, '--backend', 'cpu', '--json', `--compress=${compress}`];
  for (const output of outputs) args.push('-o', output);
  for (const of of measured) args.push(`--${of}`, `${name}.${of}.npz`);
  const report = JSON.parse(
    execFileSync(COMMAND, args, {
      cwd: folder,
      encoding: 'utf8',
      stdio: ['ignore', 'pipe', 'pipe'],
    }),
  );
  const files = [...outputs, ...measured.map((of) => `${name}.${of}.npz`)];
  return { report, files: Object.fromEntries(files.map((file) => [file.slice(name.length + 1), readFileSync(file)])) };
}

const CODE = `
  import { readFileSync, writeFileSync } from 'node:fs';
  import { createMesher } from 'hexcast';
  const [given, folder] = process.argv.slice(2);
  const { job, formats, compress } = JSON.parse(readFileSync(given, 'utf8'));
  const mesher = await createMesher({ backend: 'cpu' });
  const geometries = job.geometries.map(({ file, ...rest }) => ({ ...rest, file, source: readFileSync(file.startsWith('/') ? file : folder + '/' + file) }));
  const whole = { ...job, geometries };
  const { dims, grading } = await mesher.estimate(whole);
  const mesh = await mesher.mesh(whole);
  for (const format of formats) {
    const options = { compress: ['npy', 'raw'].includes(format) ? 0 : compress };
    writeFileSync(folder + '/ours.' + format, Buffer.from(await (await mesh.blob(format, options)).arrayBuffer()));
  }
  // columns read back, and their files
  const again = await mesher.open(readFileSync(folder + '/ours.hxc'));
  writeFileSync(folder + '/again.vtr', Buffer.from(await (await again.blob('vtr', { compress })).arrayBuffer()));
  const measured = {};
  for (const of of ['links', 'fractions', 'staggered', 'conformal', 'tensors', 'distance']) {
    const arrays = await mesh[of]().catch(({ code }) => code);
    if (typeof arrays === 'string') measured[of] = arrays;
    else {
      measured[of] = Object.entries(arrays).map(([name, array]) => {
        const file = folder + '/ours.' + of + '.' + name;
        writeFileSync(file, new Uint8Array(array.buffer));
        return [name, array.constructor.name, array.length];
      });
    }
  }
  const wrong = await again.links().catch(({ code, message }) => ({ code, message }));
  console.log(JSON.stringify({ report: mesh.report, lines: mesh.lines, of_again: again.lines, estimate: { dims, grading }, measured, wrong }));
  mesher.dispose();
`;

function ours(job, formats, compress) {
  const given = path.join(folder, 'given.json');
  writeFileSync(given, JSON.stringify({ job, formats, compress }));
  return JSON.parse(project.run('measured.js', CODE, given, folder));
}

/** Bytes of an array of a stored NumPy archive, which lie between its header and the next entry; by a reader of its own. */
function arrayOf(npz, name) {
  let at = 0;
  const nameAt = () => npz.toString('latin1', at + 30, at + 30 + npz.readUInt16LE(at + 26));
  while (nameAt() !== `${name}.npy`) {
    at = npz.indexOf('PK\x03\x04', at + 4, 'latin1');
    assert.ok(at > 0, `the archive has ${name}`);
  }
  const head = npz.indexOf('\x93NUMPY', at, 'latin1');
  const text = head + 10;
  const described = npz.toString('latin1', text, text + npz.readUInt16LE(head + 8));
  const [, kind] = /'descr': '([^']+)'/.exec(described);
  const shape = /'shape': \(([^)]*)\)/
    .exec(described)[1]
    .split(',')
    .filter((n) => n.trim())
    .map(Number);
  const start = text + npz.readUInt16LE(head + 8);
  const n = shape.reduce((product, length) => product * length, 1);
  return { kind, n, bytes: npz.subarray(start, start + n * Number(kind[2])) };
}

for (const [name, job] of Object.entries(JOBS)) {
  test(`${name}: the files of the package are those of the native command`, () => {
    for (const [compress, level] of [
      ['none', 0],
      [6, 6],
    ]) {
      const { report, files } = native(job, compress);
      const made = ours(job, Object.keys(files), level);
      assert.equal(made.report.flags_hash, report.flags_hash);
      for (const key of [
        'dims',
        'origin',
        'spacing',
        'grading',
        'links',
        'fractions',
        'staggered',
        'conformal',
        'distance',
        'tensors',
        'flags',
        'certificate',
        'window',
      ])
        assert.deepEqual(made.report[key], report[key], key);
      for (const [ending, bytes] of Object.entries(files)) {
        const found = readFileSync(path.join(folder, `ours.${ending}`));
        assert.equal(found.length, bytes.length, `${ending}, ${compress}: length`);
        assert.ok(found.equals(bytes), `${ending}, ${compress}: bytes`);
      }
      assert.ok(readFileSync(path.join(folder, 'again.vtr')).equals(files.vtr), 'a column file that is read back');
      assert.deepEqual(made.of_again, made.lines);
      if (!job.window) assert.deepEqual(made.estimate, { dims: report.dims, grading: report.grading });
      assert.match(made.wrong.message, /the mesh has no links/);
      if (compress === 'none') checkArrays(job, made.measured, files);
    }
  });
}

/** Holds the typed arrays to those of the native archives. */
function checkArrays(job, measured, files) {
  const KINDS = { '|u1': 'Uint8Array', '|i1': 'Int8Array', '<i2': 'Int16Array', '<i4': 'Int32Array', '<u4': 'Uint32Array' };
  Object.assign(KINDS, { '<f4': 'Float32Array', '<f8': 'Float64Array', '<u8': 'Float64Array' });
  for (const [of, arrays] of Object.entries(measured)) {
    if (!job[of]) {
      assert.equal(arrays, 'job-conflict', of);
      continue;
    }
    assert.ok(arrays.length >= 4, of);
    for (const [name, kind, length] of arrays) {
      const expected = arrayOf(files[`${of}.npz`], name);
      assert.equal(kind, KINDS[expected.kind], `${of}.${name}`);
      assert.equal(length, expected.n, `${of}.${name}`);
      const found = readFileSync(path.join(folder, `ours.${of}.${name}`));
      if (expected.kind !== '<u8') assert.ok(found.equals(expected.bytes), `${of}.${name}`);
      else
        for (let at = 0; at < length; at += 1)
          assert.equal(found.readDoubleLE(8 * at), Number(expected.bytes.readBigUInt64LE(8 * at)));
    }
  }
}

test('the JavaScript of the documentation runs as it is written', () => {
  const results = {
    lines: 'vtr',
    links: 'records',
    fractions: 'image',
    staggered: 'npz',
    conformal: 'npz',
    tensors: 'npz',
    distance: 'npz',
  };
  for (const [page, result] of Object.entries(results)) {
    const text = readFileSync(path.join(ROOT, `docs/${page}.md`), 'utf8');
    const blocks = [...text.matchAll(/```js\n(.*?)```/gs)].map(([, block]) => block);
    assert.equal(blocks.length, 1, page);
    const code = `
      import { readFileSync } from 'node:fs';
      import { createMesher } from 'hexcast';
      const mesher = await createMesher({ backend: 'cpu' });
      const [board, patch, source] = process.argv.slice(2).map((name) => readFileSync(name));
      ${blocks[0]}
      console.log('bytes', ${result}.size, mesh.report.cells);
      mesher.dispose();
    `;
    const printed = project.run(`${page}.js`, code, path.join(folder, 'board.stl'), path.join(folder, 'patch.stl'), SPOT);
    const [, bytes, cells] = /^bytes (\d+) (\d+)$/m.exec(printed).map(Number);
    assert.ok(bytes > 1000 && cells > 10_000, printed);
  }
});

test('.vti refuses cells that differ in size, and says what holds them', () => {
  const code = `
    import { readFileSync } from 'node:fs';
    import { createMesher } from 'hexcast';
    const mesher = await createMesher({ backend: 'cpu' });
    const source = readFileSync(process.argv[2]);
    const mesh = await mesher.mesh({ geometries: [{ source }], lines: { x: [0, 1, 40], y: [0, 30], z: [0, 1.6] } });
    const refused = await mesh.blob('vti').catch(({ code, message, hint }) => ({ code, message, hint }));
    const wrong = [];
    for (const more of [{ graded: {} }, { graded: { max_size: 4, grow: 2 } }, { lines: { x: [0, 1, 1], y: [0, 1], z: [0, 1] } },
      { links: { stencil: 'D3Q9' } }, { fractions: { rays: 3 } }, { graded: { max_size: 1e-9 } }])
      wrong.push(await mesher.mesh({ geometries: [{ source }], ...more }).catch(({ code, message }) => ({ code, message })));
    console.log(JSON.stringify({ refused, wrong }));
    mesher.dispose();
  `;
  const { refused, wrong } = JSON.parse(project.run('refused.js', code, path.join(folder, 'board.stl')));
  assert.equal(refused.code, 'lines-graded');
  assert.match(refused.hint, /\.vtr/);
  assert.deepEqual(
    wrong.map(({ code }) => code),
    ['job-value', 'job-value', 'lines-wrong', 'job-value', 'job-value', 'too-many-cells'],
  );
  assert.match(wrong[1].message, /grow/);
});

test('sizes of cells are compared as by the native command', () => {
  const code = `
    import { readFileSync } from 'node:fs';
    import { createMesher } from 'hexcast';
    const mesher = await createMesher({ backend: 'cpu' });
    const geometries = [{ source: readFileSync(process.argv[2]), name: 'cow', flag: 7 }];
    const steps = [];
    const levels = await mesher.converge({ geometries, unit: 'mm' }, { sizes: [10, 21], onProgress: ({ stage }) => steps.push(stage) });
    const wrong = [];
    for (const [job, options] of [[{ geometries, cells: 3 }], [{ geometries }, { sizes: [] }], [{ geometries }, { sizes: [0] }]])
      wrong.push(await mesher.converge(job, options).catch(({ code, message }) => code + ': ' + message));
    console.log(JSON.stringify({ levels, steps: [...new Set(steps)], wrong }));
    mesher.dispose();
  `;
  const { levels, steps, wrong } = JSON.parse(project.run('converge.js', code, SPOT));
  const args = ['converge', `${SPOT}:name=cow,flag=7`, '--unit=mm', '--sizes=10,21', '--json', '--backend=cpu'];
  const native = JSON.parse(execFileSync(COMMAND, args, { cwd: ROOT, encoding: 'utf8', stdio: ['ignore', 'pipe', 'pipe'] }));
  const untimed = (all) => all.map(({ seconds, ...level }) => level);
  assert.deepEqual(untimed(levels), untimed(native));
  assert.deepEqual(
    steps.filter((stage) => stage !== 'read'),
    ['mesh'],
  );
  assert.match(wrong[0], /^job-conflict: cells is given/);
  assert.match(wrong[1], /^job-value: sizes is a list of 0/);
  assert.match(wrong[2], /^job-value: sizes\[0\] is 0/);
});

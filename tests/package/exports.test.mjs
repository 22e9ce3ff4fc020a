// Files for solvers: the bytes of every exporter, or what an HDF5 file holds, are those of the native command, and what it refuses is refused in the
// same words.

import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { mkdirSync, mkdtempSync, readFileSync, readdirSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { after, before, test } from 'node:test';

import { byteStream } from '../../www/client/byte_stream.js';
import { hdf5Reader } from './hdf5.mjs';
import { MESH_OF_FILE, SPOT, installedProject, nativeCommand, writeBodies } from './project.mjs';

let project;
let folder;
let readHdf5;
before(async () => {
  readHdf5 = await hdf5Reader();
  project = installedProject();
  folder = mkdtempSync(path.join(tmpdir(), 'hexcast-exports-'));
  writeBodies(folder);
});
after(() => {
  project.remove();
  rmSync(folder, { recursive: true, force: true });
});

const BODIES = [
  { file: 'foot.stl', flag: 3, name: 'Fuß <1>', material: { E: 2.1e11, nu: 0.3, density: 7850, sigma: 2.5 } },
  { file: 'arm.stl', flag: 1, name: '7 arms', material: { eps_r: 2.25, mu_r: 1.5 } },
  { file: 'tip.stl', flag: 200, name: 'FU_ _1_', material: { pec: true } },
];
const AIR = { name: 'air & more', material: { eps_r: 1.0006 } };
const COW = { file: SPOT, flag: 7, name: 'cow', material: { eps_r: 50, sigma: 0.5 } };

/** Jobs by what they are, with the formats that their cells have. */
const JOBS = {
  'cubes of several substances': {
    job: { geometries: BODIES, cell_size: 0.5, padding: { cells: 1 }, unit: 'mm', background: AIR },
    formats: ['foam', 'inp', 'msh', 'xdmf', 'csx.xml', 'in', 'geometry.xml', 'nrrd', 'vox', 'glb', 'stl', 'binvox'],
  },
  'cells that are no cubes, in inches': {
    job: { geometries: [COW], dims: [31, 17, 43], axis: 'y', unit: 'in', background: AIR },
    formats: ['foam', 'inp', 'msh', 'xdmf', 'csx.xml', 'in', 'geometry.xml', 'nrrd', 'vox', 'glb', 'stl'],
  },
  'cells that differ in size': {
    job: { geometries: BODIES, graded: { max_size: [2, 1.5, 1] }, padding: { length: 3 }, unit: 'cm', background: AIR },
    formats: ['foam', 'inp', 'msh', 'xdmf', 'csx.xml'],
  },
  'more cells along x than a model of .vox and a slab have': {
    job: { geometries: [COW], domain: [-0.6, -0.8, -0.6, 0.6, 1.0, 1.2], dims: [301, 30, 40], unit: 'm', background: AIR },
    formats: ['foam', 'nrrd', 'vox', 'glb', 'csx.xml', 'in', 'xdmf'],
  },
};

/** Options of JavaScript, those of the command, and the formats that they are for. */
const CHOICES = [
  { options: {}, words: [], fits: () => true },
  { options: { compress: 0 }, words: ['--compress=none'], fits: (format) => ['nrrd', 'xdmf', 'in'].includes(format) },
  { options: { ascii: true }, words: ['--ascii'], fits: (format) => ['foam', 'msh'].includes(format) },
  { options: { compress: 6 }, words: ['--compress=6'], fits: (format) => ['nrrd', 'xdmf', 'in'].includes(format) },
  // the command has no archive
  { options: { compress: 1 }, words: [], fits: (format) => format === 'foam' },
  { options: { exportFlags: 'some' }, words: ['--export-flags=some'], fits: (format) => format !== 'nrrd' },
];

/** Formats of several files, which come as an archive, and how many files each has. */
const ARCHIVES = { foam: 7, xdmf: 2, in: 3 };

/** The name that the command gives a format. @param {string} format */
const nameOf = (format) => (format === 'geometry.xml' ? format : `mesh.${format}`);

const command = (...args) => nativeCommand(folder, ...args);

/** All files of a folder and of those in it, by their names. */
function filesOf(root) {
  const names = readdirSync(root, { recursive: true, withFileTypes: true }).filter((entry) => entry.isFile());
  const found = names.map((entry) => path.join(entry.parentPath, entry.name));
  return Object.fromEntries(found.sort().map((file) => [path.relative(root, file), readFileSync(file)]));
}

const CODE = `${MESH_OF_FILE}
  // a column file has names and materials, too
  const again = await mesher.open(await mesh.blob('hxc'));
  for (const { format, options, file } of files) {
    const blob = await mesh.blob(format, options);
    const size = mesh.size(format, options);
    if (size !== null && size !== blob.size) throw new Error(format + ' has ' + blob.size + ' bytes, and ' + size + ' were announced');
    const bytes = Buffer.from(await blob.arrayBuffer());
    writeFileSync(folder + '/' + file, bytes);
    if (!bytes.equals(Buffer.from(await (await again.blob(format, options)).arrayBuffer()))) throw new Error(format + ' of an opened mesh');
  }
  console.log(JSON.stringify({ flags: mesh.report.flags_hash, announced: mesh.size('nrrd', { compress: 0 }) }));
  mesher.dispose();
`;

for (const [name, { job, formats }] of Object.entries(JOBS)) {
  test(`${name}: the files are those of the native command`, () => {
    writeFileSync(path.join(folder, 'job.json'), JSON.stringify(job));
    const meshed = command('mesh', '--job', 'job.json', '--backend=cpu', '--json', '-o', 'native.hxc');
    assert.equal(meshed.status, 0, meshed.stderr);
    const flags = JSON.parse(meshed.stdout).flags.map(({ flag }) => flag);
    // the background, and one more where there is
    const some = [0, flags.at(-1)];
    const asked = CHOICES.flatMap(({ options, words, fits }, at) => {
      const chosen = formats.filter(fits).map((format) => {
        const wanted = format === 'vox' ? some.slice(1) : some;
        const given = options.exportFlags ? { exportFlags: wanted } : options;
        return {
          format,
          options: given,
          file: `ours-${at}-${format}`,
          at,
          words: words.map((word) => word.replace('some', wanted)),
        };
      });
      return chosen;
    });
    writeFileSync(path.join(folder, 'given.json'), JSON.stringify({ job, files: asked }));
    const made = JSON.parse(project.run('exports.js', CODE, path.join(folder, 'given.json'), folder));
    assert.equal(made.flags, JSON.parse(meshed.stdout).flags_hash);
    assert.equal(typeof made.announced, formats.includes('nrrd') ? 'number' : 'object');
    for (const { format, file, words, options } of asked) {
      const [theirs, unpacked] = [`native-${file}`, `unpacked-${file}`].map((part) => path.join(folder, part));
      mkdirSync(theirs);
      const done = command('convert', 'native.hxc', path.join(theirs, nameOf(format)), ...words);
      assert.equal(done.status, 0, `${format}: ${done.stderr}`);
      const expected = filesOf(theirs);
      const ours = path.join(folder, file);
      // the archive is read by a program that shares nothing with ours
      if (format in ARCHIVES) execFileSync('python3', ['-m', 'zipfile', '-e', ours, unpacked]);
      const found = format in ARCHIVES ? filesOf(unpacked) : { [nameOf(format)]: readFileSync(ours) };
      assert.deepEqual(Object.keys(found), Object.keys(expected), format);
      assert.equal(Object.keys(found).length, ARCHIVES[format] ?? 1);
      for (const [part, bytes] of Object.entries(expected)) {
        const what = `${format}, ${JSON.stringify(options)}, ${part}`;
        if (part.endsWith('.h5')) {
          // another crate writes it
          const [mine, native] = [unpacked, theirs].map((where) => readHdf5(path.join(where, part)));
          assert.ok(Object.keys(native.datasets).length >= 2, what);
          assert.deepEqual(mine, native, what);
          continue;
        }
        assert.ok(found[part].equals(bytes), `${what}: ${found[part].length} bytes, natively ${bytes.length}`);
      }
      for (const made of [theirs, unpacked]) rmSync(made, { recursive: true, force: true });
    }
  });
}

const CUT = `${MESH_OF_FILE}
  const lacks = {};
  for (const format of ['foam', 'eb']) {
    lacks[format] = [];
    const onLack = (lack) => lacks[format].push(lack);
    const blob = await mesh.blob(format, { onLack });
    writeFileSync(folder + '/cut.' + format + '.zip', Buffer.from(await blob.arrayBuffer()));
  }
  console.log(JSON.stringify(lacks));
  mesher.dispose();
`;

test('cut cells and embedded boundaries are those of the native command, and say what they lack', () => {
  const job = { geometries: [COW], cells: 20, unit: 'm', cut_cells: { fluid: 0, boundary: true }, padding: { cells: 2 } };
  writeFileSync(path.join(folder, 'given.json'), JSON.stringify({ job, files: [] }));
  const lacks = JSON.parse(project.run('cut.js', CUT, path.join(folder, 'given.json'), folder));
  writeFileSync(path.join(folder, 'cut.json'), JSON.stringify(job));
  const theirs = path.join(folder, 'cut');
  mkdirSync(theirs);
  const outputs = ['foam', 'eb'].flatMap((format) => ['-o', path.join('cut', `mesh.${format}`)]);
  const { status, stderr } = command('mesh', '--job', 'cut.json', '--backend=cpu', ...outputs);
  assert.equal(status, 0, stderr);
  for (const format of ['foam', 'eb']) {
    execFileSync('python3', ['-m', 'zipfile', '-e', path.join(folder, `cut.${format}.zip`), path.join(folder, 'ours')]);
    assert.ok(lacks[format].length > 0, format);
    for (const lack of lacks[format]) assert.ok(stderr.replace(/\s+/g, ' ').includes(lack), `${lack} in ${stderr}`);
  }
  const [ours, expected] = [path.join(folder, 'ours'), theirs].map(filesOf);
  assert.deepEqual(Object.keys(ours), Object.keys(expected));
  assert.ok(Object.keys(ours).length > 30);
  for (const [part, bytes] of Object.entries(expected)) assert.ok(ours[part].equals(bytes), part);
});

const REFUSED = `
  import { readFileSync } from 'node:fs';
  import { createMesher } from 'hexcast';
  const [given, folder] = process.argv.slice(2);
  const mesher = await createMesher({ backend: 'cpu' });
  const source = readFileSync(folder + '/foot.stl');
  const meshes = [];
  const told = [];
  for (const [at, format, options] of JSON.parse(readFileSync(given, 'utf8')).asked) {
    const job = JSON.parse(readFileSync(folder + '/' + at + '.json', 'utf8'));
    meshes[at] ??= await mesher.mesh({ ...job, geometries: job.geometries.map((geometry) => ({ ...geometry, source })) });
    const write = async () => { await meshes[at].blob(format, options ?? {}); return {}; };
    told.push(await write().catch(({ code, message, hint }) => ({ code, message, hint })));
  }
  console.log(JSON.stringify(told));
  mesher.dispose();
`;

test('what cannot be exported is refused as by the native command, in its words', () => {
  const geometries = [{ file: 'foot.stl', flag: 3 }];
  const jobs = {
    plain: { geometries, cells: 9 },
    furlong: { geometries, cells: 9, unit: 'furlong' },
    metric: { geometries, cells: 9, unit: 'mm', padding: { cells: 1 } },
    slabs: { geometries, dims: [9, 3, 2], unit: 'mm' },
    graded: { geometries, graded: { max_size: 2, min_size: 0.1 }, padding: { length: 0.7 }, unit: 'mm' },
    stiff: { geometries: [{ ...geometries[0], material: { E: 1e9 } }], cells: 9, unit: 'mm' },
    metal: {
      geometries: [{ ...geometries[0], material: { eps_r: 2 } }],
      cells: 9,
      padding: { cells: 1 },
      unit: 'mm',
      background: { material: { pec: true } },
    },
  };
  for (const [name, job] of Object.entries(jobs)) writeFileSync(path.join(folder, `${name}.json`), JSON.stringify(job));
  const flagsOf = (...flags) => [{ exportFlags: flags }, `--export-flags=${flags}`];
  const asked = [
    ['plain', 'foam', 'export-unit'],
    ['plain', 'inp', 'export-unit'],
    ['plain', 'csx.xml', 'export-unit'],
    ['plain', 'geometry.xml', 'export-unit'],
    ['furlong', 'foam', 'export-unit'],
    ['metric', 'csx.xml', 'export-material'],
    ['metal', 'csx.xml', 'job-conflict'],
    ['metric', 'in', 'export-material'],
    ['plain', 'in', 'export-unit'],
    ['graded', 'in', 'lines-graded'],
    ['stiff', 'inp', 'export-material'],
    // the command knows of the job alone, and so before it meshes
    [
      'metric',
      'foam',
      'job-conflict',
      ...flagsOf(3, 9),
      'flag 9 is to be exported, and no geometry has it; flags of the job: 0, 3',
    ],
    ['metric', 'vox', 'job-conflict', ...flagsOf(0)],
    ['slabs', 'binvox', 'lines-graded'],
    ['graded', 'nrrd', 'lines-graded'],
    ['graded', 'vox', 'lines-graded'],
    ['graded', 'binvox', 'lines-graded'],
    ['graded', 'geometry.xml', 'lines-graded'],
  ];
  const questions = asked.map(([at, format, , options]) => [at, format, options]);
  writeFileSync(path.join(folder, 'asked.json'), JSON.stringify({ asked: questions }));
  const told = JSON.parse(project.run('refused.js', REFUSED, path.join(folder, 'asked.json'), folder));
  for (const [index, [at, format, code, , word, words]] of asked.entries()) {
    const args = [
      'mesh',
      '--job',
      `${at}.json`,
      '--backend=cpu',
      '-o',
      `refused-${nameOf(format)}`.replace('refused-geometry', 'geometry'),
    ];
    const { status, stderr } = command(...args, ...(word ? [word] : []));
    assert.ok(status > 0 && status < 8, `${at}, ${format}: ${status}, ${stderr}`);
    assert.equal(told[index].code, code, `${at}, ${format}: ${JSON.stringify(told[index])}`);
    const plain = (text) => text.replace(/\s+/g, ' ');
    assert.ok(
      plain(stderr).includes(plain(words ?? told[index].message)),
      `${at}, ${format}: "${told[index].message}", natively ${stderr}`,
    );
    assert.ok(told[index].hint.length > 0);
    assert.doesNotMatch(told[index].hint, /--|\[|eps_r =/, 'hints speak of the package');
  }
});

test('options that a format would ignore, and what is no format, are refused', () => {
  writeFileSync(path.join(folder, 'box.json'), JSON.stringify({ geometries: [{ file: 'foot.stl' }], cells: 9, unit: 'mm' }));
  const asked = [
    ['box', 'nrrd', { exportFlags: [1] }, 'job-conflict', /exportFlags is given, and \.nrrd/],
    ['box', 'vti', { exportFlags: [1] }, 'job-conflict', /exportFlags is given, and \.vti/],
    ['box', 'inp', { ascii: true }, 'job-conflict', /ascii is given, and \.inp/],
    ['box', 'npz', { ascii: true }, 'job-conflict', /ascii is given, and \.npz/],
    ['box', 'msh', { bits: true }, 'job-conflict', /bits is given, and \.msh/],
    ['box', 'vox', { compress: 3 }, 'job-conflict', /compress is given, and \.vox/],
    ['box', 'raw', { compress: 3 }, 'job-conflict', /\.raw cannot be compressed/],
    ['box', 'msh', { exportFlags: [] }, 'job-conflict', /no flag is to be exported/],
    ['box', 'msh', { exportFlags: 1 }, 'job-value', /exportFlags is 1; allowed: a list of flags/],
    ['box', 'msh', { exportFlags: [1, 256] }, 'job-value', /exportFlags\[1\] is 256/],
    ['box', 'msh', { ascii: 1 }, 'job-value', /ascii is 1/],
    ['box', 'msh', { flags: [1] }, 'job-value', /flags is no option/],
    ['box', 'xdmf', { ascii: true }, 'job-conflict', /ascii is given, and \.xdmf/],
    ['box', 'in', { map: { 1: 0 } }, 'job-conflict', /map is given, and \.in/],
    ['box', 'links.h5', {}, 'job-conflict', /the mesh has no links/],
    ['box', 'distance.h5', {}, 'job-conflict', /the mesh has no distance/],
    ['box', 'eb', {}, 'job-conflict', /does not know where surfaces cross/],
    ['box', 'foam', { onLack: 1 }, 'job-value', /onLack is 1/],
    ['box', 'vtk', {}, 'job-value', /format is "vtk"; allowed: .*"foam".*"binvox"/],
  ];
  writeFileSync(path.join(folder, 'asked.json'), JSON.stringify({ asked }));
  const told = JSON.parse(project.run('options.js', REFUSED, path.join(folder, 'asked.json'), folder));
  for (const [index, [, format, options, code, pattern]] of asked.entries()) {
    assert.equal(told[index].code, code, `${format}, ${JSON.stringify(options)}: ${JSON.stringify(told[index])}`);
    assert.match(told[index].message, pattern);
  }
});

test('planes that do not fit the memory are refused by those that hold them', () => {
  const wide = { geometries: [{ file: 'foot.stl' }], dims: [2100, 2000, 2], unit: 'mm' };
  writeFileSync(path.join(folder, 'wide.json'), JSON.stringify(wide));
  writeFileSync(
    path.join(folder, 'long.json'),
    JSON.stringify({ ...wide, dims: [2, 2100, 2000], domain: [8.999, 3.9, 0, 9.001, 6, 2] }),
  );
  const material = { eps_r: 2 };
  const many = { geometries: [{ file: 'foot.stl', material }], dims: [700, 700, 600], unit: 'mm' };
  writeFileSync(path.join(folder, 'many.json'), JSON.stringify(many));
  const asked = [
    ['wide', 'foam', 'memory', /^a plane across z has 4200000 cells, and exporters hold planes of up to 4194304 here/],
    ['wide', 'inp', 'memory', /across z/],
    ['wide', 'nrrd', undefined, /^undefined$/],
    ['wide', 'vox', undefined, /^undefined$/],
    ['long', 'msh', undefined, /^undefined$/],
    ['long', 'binvox', 'memory', /across x/],
    ['many', 'in', 'memory', /^mesh_geo\.h5 has 588000000 bytes, and HDF5 files of up to 268435456 are made here, in memory/],
    ['many', 'nrrd', undefined, /^undefined$/],
  ];
  const options = { msh: { exportFlags: [1] }, nrrd: { compress: 0 } };
  const questions = asked.map(([at, format]) => [at, format, options[format] ?? {}]);
  writeFileSync(path.join(folder, 'asked.json'), JSON.stringify({ asked: questions }));
  const told = JSON.parse(project.run('planes.js', REFUSED, path.join(folder, 'asked.json'), folder));
  for (const [index, [at, format, code, pattern]] of asked.entries()) {
    assert.equal(told[index].code, code, `${at}, ${format}: ${JSON.stringify(told[index])}`);
    assert.match(String(told[index].message), pattern);
  }
});

test('a stream that fails lets go of what it reads from', async () => {
  let n_cancelled = 0;
  let n_read = 0;
  const next = async () => {
    if (n_read === 1) throw new Error('enough');
    n_read += 1;
    return new Uint8Array(9 << 20);
  };
  const stream = byteStream({ start: async () => {}, next, cancel: () => (n_cancelled += 1) });
  await assert.rejects(stream.pipeTo(new WritableStream()), /enough/);
  assert.equal(n_cancelled, 1);
});

test('an export is made as it is read, counts what it has, and stops where it is told to', () => {
  const code = `
    import { readFileSync } from 'node:fs';
    import { createMesher } from 'hexcast';
    const mesher = await createMesher({ backend: 'cpu' });
    const mesh = await mesher.mesh({ geometries: [{ source: readFileSync(process.argv[2]) }], cells: 128, padding: { cells: 1 }, unit: 'mm' });
    const steps = [];
    const onProgress = ({ stage, done, total }) => steps.push([stage, done, total]);
    const reader = mesh.stream('inp', { exportFlags: [0, 1], onProgress }).getReader();
    const first = await reader.read();
    await new Promise((resolve) => setTimeout(resolve, 500));
    const ahead = steps.at(-1)[1];
    await reader.cancel();
    const head = Buffer.from(first.value).toString('latin1', 0, 40);
    // the stream that was cancelled is gone, and the mesher works
    const foam = [];
    const whole = await mesh.blob('foam', { onProgress: ({ stage, done, total }) => foam.push([stage, done, total]) });
    const stop = new AbortController();
    const stopped = await mesh.blob('msh', { signal: stop.signal, onProgress: () => stop.abort('enough') }).catch((reason) => reason);
    const thrown = await mesh.blob('vox', { onProgress() { throw new Error('no'); } }).catch(({ code }) => code);
    const nrrd = [];
    await mesh.blob('nrrd', { compress: 0, onProgress: ({ done, total }) => nrrd.push([done, total]) });
    console.log(JSON.stringify({ cells: mesh.report.cells, head, ahead, foam, size: whole.size, type: whole.type, stopped, thrown, nrrd: nrrd.at(-1), announced: mesh.size('nrrd', { compress: 0 }), flag: await mesh.flag(0, 0, 0) }));
    mesher.dispose();
  `;
  const told = JSON.parse(project.run('streams.js', code, SPOT));
  assert.match(told.head, /^\*HEADING\nhexcast/);
  // 8 MiB of the stream, and the bytes that became of the cells of a slab, some 60 each
  assert.ok(told.ahead > 0 && told.ahead < 32e6 && 60 * told.cells > 3 * told.ahead, `${told.ahead} of ${told.cells} cells`);
  const before = told.foam.filter(([, , total]) => total === told.cells);
  assert.ok(before.length > 0, 'faces are counted first');
  assert.ok(told.foam.every(([stage, done, total]) => stage === 'write' && done <= total));
  assert.deepEqual(told.foam.at(-1), ['write', told.size, told.size]);
  assert.equal(told.type, 'application/zip');
  assert.equal(told.stopped, 'enough');
  assert.equal(told.thrown, 'callback');
  assert.deepEqual(told.nrrd, [told.announced, told.announced]);
  assert.equal(told.flag, 0);
});

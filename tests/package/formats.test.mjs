// Files of a mesh in every form that the native command has: each is that file, byte for byte.

import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { mkdirSync, mkdtempSync, readFileSync, readdirSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { after, before, test } from 'node:test';

import { boxBetween } from '../e2e/open_box.mjs';
import { MESH_OF_FILE, SPOT, installedProject, nativeCommand } from './project.mjs';

let project;
let folder;
before(() => {
  project = installedProject();
  folder = mkdtempSync(path.join(tmpdir(), 'hexcast-formats-'));
  writeFileSync(path.join(folder, 'board.stl'), boxBetween([0, 0, 0], [40, 30, 1.6]));
  writeFileSync(path.join(folder, 'patch.stl'), boxBetween([10, 9.5, 1.6], [26.5, 21, 1.635]));
});
after(() => {
  project.remove();
  rmSync(folder, { recursive: true, force: true });
});

const command = (...args) => nativeCommand(folder, ...args);

const CODE = `${MESH_OF_FILE}
  const told = [];
  for (const { format, options, file } of files) {
    try {
      const made = format === 'sidecar' ? new Blob([await mesh.sidecar(options)]) : await mesh.blob(format, options);
      const size = format === 'sidecar' ? null : mesh.size(format, options);
      if (file) writeFileSync(folder + '/' + file, Buffer.from(await made.arrayBuffer()));
      told.push({ size, bytes: made.size, type: made.type });
    } catch ({ code, message, hint }) {
      told.push({ code, message, hint });
    }
  }
  console.log(JSON.stringify(told));
  mesher.dispose();
`;

/** What the package makes of a job: the facts of each file, or why it was refused. */
function ours(job, files) {
  writeFileSync(path.join(folder, 'given.json'), JSON.stringify({ job, files }));
  return JSON.parse(project.run('formats.js', CODE, path.join(folder, 'given.json'), folder));
}

/** Runs the command on a job, with these words, and makes sure that it did what it was told. */
function native(job, ...words) {
  writeFileSync(path.join(folder, 'job.json'), JSON.stringify(job));
  const { status, stderr } = command('mesh', '--job', 'job.json', '--backend=cpu', '--quiet', ...words);
  assert.equal(status, 0, stderr);
}

/** Compares two files of the folder. */
function assertSame(found, expected, what) {
  const [ours, theirs] = [found, expected].map((name) => readFileSync(path.join(folder, name)));
  assert.ok(ours.equals(theirs), `${what}: ${ours.length} bytes, natively ${theirs.length}`);
  return ours.length;
}

const COW = { file: SPOT, flag: 7, name: 'cow' };
const BOARD = { file: 'board.stl', flag: 2, name: 'FR4' };
const PATCH = { file: 'patch.stl', flag: 5, priority: 1 };

for (const [name, job] of Object.entries({
  'a body in cells that are no cubes': { geometries: [COW], dims: [31, 67, 23], axis: 'y', unit: 'mm' },
  'bodies on generated lines': { geometries: [BOARD, PATCH], graded: { max_size: 2 }, padding: { length: 3 } },
})) {
  test(`${name}: arrays in either order, of other numbers`, () => {
    const flag = job.geometries[0].flag;
    const choices = [
      [{ axisOrder: 'xyz' }, ['--axis-order=xyz']],
      [{ map: { [flag]: 0, 0: 1 } }, [`--map=${flag}=0,0=1`]],
      [{ axisOrder: 'xyz', map: { [flag]: 255, 3: 4 } }, ['--axis-order=xyz', `--map=${flag}=255,3=4`]],
      [{ axisOrder: 'zyx', map: {} }, ['--map=9=9']],
    ];
    const files = choices.flatMap(([options], at) => [
      { format: 'raw', options, file: `ours-${at}.raw` },
      { format: 'sidecar', options: { ...options, hash: 'sha256' }, file: `ours-${at}.raw.json` },
      { format: 'npy', options, file: `ours-${at}.npy` },
      { format: 'npz', options: { ...options, compress: 0 }, file: `ours-${at}.npz` },
      { format: 'npz', options, file: `ours-${at}-packed.npz` },
    ]);
    const told = ours(job, files);
    for (const [index, { format, file }] of files.entries()) {
      assert.equal(told[index].code, undefined, JSON.stringify(told[index]));
      if (['raw', 'npy'].includes(format)) assert.equal(told[index].size, told[index].bytes, file);
    }
    for (const [at, [, words]] of choices.entries()) {
      const outputs = ['raw', 'npy', 'npz'].flatMap((format) => ['-o', `native-${at}.${format}`]);
      native(job, '--hash=sha256', '--compress=none', ...words, ...outputs);
      native(job, ...words, '-o', `native-${at}-packed.npz`);
      for (const part of ['.raw', '.raw.json', '.npy', '.npz', '-packed.npz'])
        assertSame(`ours-${at}${part}`, `native-${at}${part}`, `${words}, ${part}`);
    }
    // by the flags themselves, too
    native(job, '-o', 'plain.raw');
    const [plain, turned, changed] = ['plain', 'ours-0', 'ours-2'].map((file) => readFileSync(path.join(folder, `${file}.raw`)));
    const [nx, ny, nz] = JSON.parse(readFileSync(path.join(folder, 'plain.raw.json'), 'utf8')).dims;
    assert.ok(new Set([nx, ny, nz]).size > 1 && plain.length === nx * ny * nz);
    for (const [at, found] of plain.entries()) {
      const [x, y, z] = [at % nx, Math.floor(at / nx) % ny, Math.floor(at / nx / ny)];
      const to = z + nz * (y + ny * x);
      assert.ok(turned[to] === found && changed[to] === ({ [flag]: 255, 3: 4 }[found] ?? found), `cell ${x}, ${y}, ${z}`);
    }
  });
}

/** Jobs with all that is measured, and the format of images that their cells have. */
const MEASURED = {
  'a cow': {
    job: { geometries: [COW], cells: 70, padding: { cells: 2 }, unit: 'mm', links: { stencil: 'D3Q27' }, fractions: { rays: 2 } },
    image: 'vti',
  },
  'a cow beside a fluid that is not the background': {
    job: {
      geometries: [{ ...COW, flag: 3 }],
      dims: [31, 67, 23],
      axis: 'z',
      links: { stencil: 'D3Q15', fluid: [3] },
      fractions: { faces: true, surfaces: true },
    },
    image: 'vti',
  },
  'bodies on generated lines': {
    job: {
      geometries: [BOARD, PATCH],
      graded: { max_size: 1.5 },
      padding: { length: 3 },
      unit: 'cm',
      links: { stencil: 'D3Q7' },
      fractions: { rays: 8 },
    },
    image: 'vtr',
  },
};

for (const [name, { job, image }] of Object.entries(MEASURED)) {
  test(`${name}: records of links, and fractions of every cell`, () => {
    const formats = ['links', 'fractions.npy', `fractions.${image}`];
    const files = formats.map((format) => ({ format, options: { compress: 0 }, file: `ours.${format}` }));
    const packed = { format: `fractions.${image}`, file: 'ours.packed' };
    const told = ours(job, [...files, packed]);
    for (const [index, format] of formats.entries())
      assert.equal(told[index].size, told[index].bytes, `${format}: ${JSON.stringify(told[index])}`);
    assert.equal(told[3].size, null);
    native(job, '--links=native.links', '--fractions=native.fractions.npy');
    native(job, '--compress=none', `--fractions=native.fractions.${image}`);
    for (const format of formats) assertSame(`ours.${format}`, `native.${format}`, format);
    native(job, `--fractions=native.packed.${image}`);
    assertSame('ours.packed', `native.packed.${image}`, 'compressed');
    // by what the report says of them
    const links = readFileSync(path.join(folder, 'ours.links'));
    const [head, n_links] = [links.toString('latin1', 0, 8), Number(links.readBigUInt64LE(32))];
    assert.deepEqual([head, links.length % 8], ['HEXLINKS', 0]);
    assert.ok(n_links > 100 && links.length >= 40 + 24 * n_links);
  });
}

/** All files of a folder, by their names. */
function filesOf(root) {
  const entries = readdirSync(root, { recursive: true, withFileTypes: true }).filter((entry) => entry.isFile());
  const names = entries.map((entry) => path.join(entry.parentPath, entry.name)).sort();
  return names.map((file) => [path.relative(root, file), readFileSync(file)]);
}

for (const [name, job] of Object.entries({
  'one shard': { geometries: [COW], cells: 60, unit: 'mm' },
  'chunks and shards of the job': {
    geometries: [{ ...COW, material: { eps_r: 2.5 } }],
    dims: [70, 90, 50],
    axis: 'y',
    padding: { cells: 9 },
    zarr: { chunks: [16, 8, 8], shards: [32, 16, 24] },
  },
  'shards of few bytes': { geometries: [COW], cells: 90, padding: { cells: 4 }, zarr: { shard_bytes: 20_000 } },
  'generated lines': { geometries: [BOARD, PATCH], graded: { max_size: 1.5 }, padding: { length: 3 }, unit: 'cm' },
})) {
  test(`a store in an archive has the files of the native store: ${name}`, () => {
    const whole = { ...job, fractions: { rays: 4 }, background: { name: 'air', material: { eps_r: 1 } } };
    const files = ['zarr', 'fractions.zarr'].flatMap((format) => [
      { format, options: { compress: 0 }, file: `ours-0-${format}.zip` },
      { format, file: `ours-6-${format}.zip` },
    ]);
    for (const { type, size } of ours(whole, files)) assert.deepEqual([type, size], ['application/zip', null]);
    for (const [level, word] of [
      [0, 'none'],
      [6, '6'],
    ]) {
      const outputs = ['-o', `native-${level}.zarr`, '-o', `native-${level}.zarr.zip`];
      native(whole, `--compress=${word}`, ...outputs, `--fractions=solid-${level}.zarr`);
      // the whole archive, too, where the command writes one
      assertSame(`ours-${level}-zarr.zip`, `native-${level}.zarr.zip`, 'the archive');
      for (const [format, folderOf] of [
        ['zarr', `native-${level}.zarr`],
        ['fractions.zarr', `solid-${level}.zarr`],
      ]) {
        const unpacked = path.join(folder, 'unpacked');
        mkdirSync(unpacked);
        // a program that shares nothing with ours
        execFileSync('python3', ['-m', 'zipfile', '-e', path.join(folder, `ours-${level}-${format}.zip`), unpacked]);
        const [found, expected] = [filesOf(unpacked), filesOf(path.join(folder, folderOf))];
        assert.deepEqual(
          found.map(([file]) => file),
          expected.map(([file]) => file),
        );
        for (const [index, [file, bytes]] of expected.entries()) assert.ok(found[index][1].equals(bytes), `${format}: ${file}`);
        assert.ok(expected.length >= 9);
        rmSync(unpacked, { recursive: true });
      }
    }
  });
}

test('files of what was not measured, and shapes that a store cannot have, are refused', () => {
  const board = { geometries: [{ file: 'board.stl' }], cells: 9 };
  const files = (asked) => asked.map(([format, options]) => ({ format, options }));
  const check = (job, asked) => {
    const told = ours(job, files(asked));
    for (const [index, [format, options, code, pattern]] of asked.entries()) {
      assert.equal(told[index].code, code, `${format}, ${JSON.stringify(options)}: ${JSON.stringify(told[index])}`);
      assert.match(told[index].message, pattern);
    }
  };
  check(board, [
    ['links', {}, 'job-conflict', /^the mesh has no links$/],
    ['fractions.vti', {}, 'job-conflict', /^the mesh has no fractions$/],
    ['fractions.zarr', {}, 'job-conflict', /^the mesh has no fractions$/],
    ['fractions.hxc', {}, 'job-value', /^format is "fractions.hxc"/],
    ['zarr', { bits: true }, 'job-conflict', /^\.zarr\.zip has no bit-packed variant$/],
    ['zarr', { map: { 1: 0 } }, 'job-conflict', /^map is given, and \.zarr/],
  ]);
  const measured = { ...board, links: {}, fractions: {} };
  check({ ...measured, zarr: { chunks: [2, 2, 2], shards: [3, 4, 4] } }, [
    ['links', { compress: 6 }, 'job-conflict', /^compress is given, and \.links cannot be compressed$/],
    ['links', { bits: true }, 'job-conflict', /^bits is given, and \.links/],
    ['fractions.npy', { compress: 6 }, 'job-conflict', /^\.npy cannot be compressed$/],
    ['fractions.npy', { bits: true }, 'job-conflict', /^bits is given, and \.fractions\.npy/],
    ['fractions.npy', { axisOrder: 'xyz' }, 'job-conflict', /^axisOrder is given, and \.fractions\.npy/],
    ['zarr', {}, 'job-value', /^zarr: shards of 3 cells along x are not a multiple of the chunks, 2$/],
  ]);
  // wasm has no room for a chunk as large
  check({ ...board, cells: undefined, dims: [900, 900, 900], zarr: { chunks: [900, 900, 900] } }, [
    ['zarr', {}, 'memory', /^zarr: a row of chunks has 729000000 bytes, and at most 536870912 are held here$/],
  ]);
  check({ ...MEASURED['bodies on generated lines'].job, links: undefined }, [
    ['fractions.vti', {}, 'lines-graded', /^cells differ in size, and \.vti holds equal ones only$/],
    ['links.npz', {}, 'job-conflict', /^the mesh has no links$/],
  ]);
});

test('an order and numbers are refused where a file has neither, and where they are none', () => {
  const asked = [
    ['vti', { axisOrder: 'xyz' }, 'job-conflict', /^axisOrder is given, and \.vti always has the flags, in one order of cells/],
    ['hxc', { map: { 1: 0 } }, 'job-conflict', /^map is given, and \.hxc/],
    ['nrrd', { map: { 1: 0 } }, 'job-conflict', /^map is given, and \.nrrd/],
    ['links.npz', { axisOrder: 'xyz' }, 'job-conflict', /^axisOrder is given, and \.links\.npz/],
    ['npy', { axisOrder: 'xyz', bits: true }, 'job-conflict', /^bits are given with an axis order/],
    ['sidecar', { map: { 1: 0 }, bits: true }, 'job-conflict', /^bits are given with an axis order or a map/],
    ['raw', { axisOrder: 'yxz' }, 'job-value', /^axisOrder is "yxz"; allowed: "zyx", "xyz"$/],
    ['raw', { map: [0, 1] }, 'job-value', /^map is a list of 2; allowed: an object, such as \{ 1: 0, 0: 1 \}$/],
    ['raw', { map: { 1: 256 } }, 'job-value', /^map\[1\] is 256; allowed: whole numbers from 0 to 255$/],
    ['raw', { map: { 256: 1 } }, 'job-value', /^a key of map is 256; allowed: whole numbers from 0 to 255$/],
    ['raw', { map: { length: 1 } }, 'job-value', /^a key of map is "length"/],
  ];
  const files = asked.map(([format, options]) => ({ format, options }));
  const told = ours({ geometries: [{ file: 'board.stl' }], cells: 9, links: {} }, files);
  for (const [index, [format, options, code, pattern]] of asked.entries()) {
    assert.equal(told[index].code, code, `${format}, ${JSON.stringify(options)}: ${JSON.stringify(told[index])}`);
    assert.match(told[index].message, pattern);
  }
});

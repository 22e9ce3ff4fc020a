// The packed tarball, installed into an empty project, runs in Node.

import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { readFileSync, symlinkSync, writeFileSync } from 'node:fs';
import path from 'node:path';
import { after, before, test } from 'node:test';

import { swiftshaderEnv } from '../../scripts/machine.mjs';
import { ROOT } from '../../scripts/run.mjs';
import { CLOSED_BOX, OPEN_BOX } from '../e2e/open_box.mjs';
import { COMMAND, SPOT, installedProject, nativeReport } from './project.mjs';

const { version } = JSON.parse(readFileSync(path.join(ROOT, 'package.json'), 'utf8'));
const SHOW_VERSION = `
  import { version } from 'hexcast';
  console.log(version);
`;

let project;
let files;
let remove;
before(() => ({ folder: project, files, remove } = installedProject()));
after(() => remove());

test('the tarball holds the wasm, the glue and the shaders, and no sources', () => {
  const told = ['README.md', 'CHANGELOG.md', 'LICENSE-MIT', 'LICENSE-APACHE', 'package.json'];
  for (const file of ['dist/hexcast.js', 'dist/hexcast_bg.wasm', 'dist/hexcast.d.ts', 'shaders/map.wgsl', ...told]) {
    assert.ok(files.includes(file), `${file} of ${files.join(' ')}`);
  }
  assert.deepEqual(
    files.filter((file) => /^(src|tests|scripts|target|www)\/|page|index\.html|assets|offline/.test(file)),
    [],
  );
});

test('the crate and the package are the same version', () => {
  const cargo = readFileSync(path.join(ROOT, 'Cargo.toml'), 'utf8');
  assert.equal(/^version = "(.+)"$/m.exec(cargo)[1], version);
});

test('Node loads the installed package', () => {
  writeFileSync(path.join(project, 'show.js'), SHOW_VERSION);
  assert.equal(execFileSync(process.execPath, ['show.js'], { cwd: project, encoding: 'utf8' }), `${version}\n`);
});

const MESH = `
  import { readFileSync } from 'node:fs';
  import { HexcastError, createMesher } from 'hexcast';
  const bytes = readFileSync(process.argv[2]);
  const mesher = await createMesher({ backend: process.argv[3] });
  const job = { geometries: [{ source: bytes, file: 'spot.stl', name: 'cow', flag: 7 }], cells: 40, unit: 'mm' };
  const mesh = await mesher.mesh(job);
  const files = {};
  for (const format of ['raw', 'npy', 'vti', 'hxc']) files[format] = Buffer.from(await (await mesh.blob(format)).arrayBuffer()).toString('base64');
  let error;
  try { await mesher.mesh({ ...job, dims: [1, 1, 1] }); } catch (caught) { error = caught; }
  const abort = new AbortController();
  abort.abort('enough');
  let reason;
  try { await mesher.mesh(job, { signal: abort.signal }); } catch (caught) { reason = caught; }
  console.log(JSON.stringify({
    backend: mesher.backend, dims: mesh.dims, flags: mesh.report.flags, sha256: await mesh.sha256(), files, reason,
    sidecar: await mesh.sidecar({ hash: 'sha256' }), plain: await mesh.sidecar(), intact: bytes.length, error: { code: error.code, isOurs: error instanceof HexcastError },
  }));
  mesher.dispose();
`;

test('Node meshes on the CPU, byte for byte like the native command', () => {
  writeFileSync(path.join(project, 'mesh.js'), MESH);
  const made = JSON.parse(
    execFileSync(process.execPath, ['mesh.js', SPOT, 'cpu'], { cwd: project, encoding: 'utf8', maxBuffer: 1 << 26 }),
  );
  assert.equal(made.backend, 'cpu');
  assert.equal(made.intact, readFileSync(SPOT).length);
  assert.deepEqual(made.error, { code: 'job-conflict', isOurs: true });
  assert.equal(made.reason, 'enough');
  const outputs = ['raw', 'npy', 'vti', 'hxc'].flatMap((format) => ['-o', path.join(project, `native.${format}`)]);
  const native = nativeReport(outputs);
  assert.deepEqual([made.dims, made.flags, made.sha256], [native.dims, native.flags, native.flags_sha256]);
  for (const [format, base64] of Object.entries(made.files)) {
    const expected = readFileSync(path.join(project, `native.${format}`));
    assert.ok(expected.equals(Buffer.from(base64, 'base64')), `${format} differs`);
  }
  const sidecar = JSON.parse(readFileSync(path.join(project, 'native.raw.json'), 'utf8'));
  assert.deepEqual(JSON.parse(made.sidecar), sidecar);
  assert.deepEqual(JSON.parse(made.plain), { ...sidecar, sha256: null });
});

const COMPRESS = `
  import { readFileSync, writeFileSync } from 'node:fs';
  import { createMesher } from 'hexcast';
  const mesher = await createMesher({ backend: 'cpu' });
  const geometries = [{ source: readFileSync(process.argv[2]), file: 'spot.stl', name: 'cow', flag: 7 }];
  const mesh = await mesher.mesh({ geometries, cells: 130, padding: { cells: 20 } });
  const names = [];
  for (const format of ['vti', 'hxc']) for (let compress = 1; compress <= 9; compress += 1) names.push([format, compress]);
  await Promise.all(names.map(async ([format, compress]) => {
    const bytes = new Uint8Array(await (await mesh.blob(format, { compress })).arrayBuffer());
    writeFileSync(\`ours-\${compress}.\${format}\`, bytes);
  }));
  const again = await mesher.open(readFileSync('ours-9.hxc'));
  console.log(JSON.stringify([await mesh.sha256(), await again.sha256()]));
  mesher.dispose();
`;

test('files compressed in Node are those of the native command at every level, and read back', () => {
  writeFileSync(path.join(project, 'compress.js'), COMPRESS);
  const [made, read] = JSON.parse(execFileSync(process.execPath, ['compress.js', SPOT], { cwd: project, encoding: 'utf8' }));
  assert.equal(read, made);
  for (let level = 1; level <= 9; level += 1) {
    const names = ['vti', 'hxc'].map((format) => `native-${level}.${format}`);
    const job = ['mesh', `${SPOT}:name=cow,flag=7`, '--cells', '130', '--padding-cells', '20', '--backend', 'cpu', '--quiet'];
    const outputs = names.flatMap((name) => ['-o', path.join(project, name)]);
    execFileSync(COMMAND, [...job, `--compress=${level}`, ...outputs]);
    for (const name of names) {
      const [expected, ours] = [name, name.replace('native', 'ours')].map((file) => readFileSync(path.join(project, file)));
      assert.ok(expected.equals(ours), `${name}: ${ours.length} bytes, ${expected.length} by the native command`);
    }
  }
});

const REFUSE = `
  import { readFileSync } from 'node:fs';
  import { createMesher } from 'hexcast';
  const [file, cases] = process.argv.slice(2);
  const mesher = await createMesher({ backend: 'cpu' });
  const problems = [];
  for (const { geometry, ...job } of JSON.parse(cases)) {
    const geometries = [{ source: readFileSync(file), file: 'spot.stl', ...geometry }];
    problems.push(await mesher.mesh({ ...job, geometries }).then(() => 'meshed', ({ code, message }) => \`\${code}: \${message}\`));
  }
  console.log(JSON.stringify(problems));
  mesher.dispose();
`;

test('a wrong job is refused by the name of its key, as the command line does', () => {
  const cases = [
    [{ cels: 3 }, 'cels: unknown field `cels`'],
    [{ cells: -1 }, 'cells: invalid value: integer `-1`'],
    [{ cells: 2.5 }, 'cells: invalid type: floating point `2.5`'],
    [{ cells: '8' }, 'cells: invalid type: string "8"'],
    [{ domain: [0, 0, 0, 1, 1, 1, 9] }, 'domain: invalid length 7, expected 6 numbers'],
    [{ domain: [0, 0, 0, 1, 1, true] }, 'domain[5]: invalid type: boolean `true`'],
    [{ cell_size: '1' }, 'cell_size: invalid type: string "1", expected a number or a list of three'],
    [{ cell_size: [1, 2, 3, 4] }, 'cell_size: invalid length 4, expected a number or a list of three'],
    [{ padding: { cell: 2 } }, 'padding'],
    [{ padding: { cells: 0.5 } }, 'padding.cells: invalid type: floating point `0.5`'],
    [{ padding: { cells: 1, length: 1 } }, 'padding'],
    [{ rule: 'even' }, 'rule: unknown variant `even`, expected `parity` or `nonzero`'],
    [{ open: 'close' }, 'open: unknown variant `close`, expected one of `winding`, `vote`, `error`, `parity`'],
    [{ unit: 5 }, 'unit: invalid type'],
    [{ geometry: { flg: 1 } }, 'geometries[0].flg: unknown field'],
    [{ geometry: { flag: 300 } }, 'geometries[0].flag: invalid value: integer `300`'],
    [{ geometry: { open: 'close' } }, 'geometries[0].open: unknown variant `close`'],
    [{ geometry: { rotate: [1, 2, 3, 4] } }, 'geometries[0].rotate: invalid length 4'],
    [{ geometry: { split: 'yes' } }, 'geometries[0].split: invalid type: string "yes"'],
  ];
  writeFileSync(path.join(project, 'refuse.js'), REFUSE);
  const jobs = JSON.stringify(cases.map(([job]) => job));
  const stl = path.join(ROOT, 'tests/fixtures/spot.stl');
  const problems = JSON.parse(execFileSync(process.execPath, ['refuse.js', stl, jobs], { cwd: project, encoding: 'utf8' }));
  assert.equal(problems.length, cases.length);
  cases.forEach(([, expected], index) => {
    assert.ok(problems[index].startsWith(`job-value: ${expected}`), `${problems[index]} instead of ${expected}`);
  });
});

const MESH_BOXES = `
  import { createMesher } from 'hexcast';
  const [closed, open] = process.argv.slice(2).map((text) => new TextEncoder().encode(text));
  const mesher = await createMesher({ backend: 'cpu' });
  const size = { cells: 40, padding: { cells: 3 } };
  const whole = await mesher.mesh({ geometries: [{ source: closed }], ...size });
  const policies = { default: {}, winding: { open: 'winding' }, vote: { open: 'vote' }, parity: { open: 'parity' } };
  const meshes = {};
  for (const [name, policy] of Object.entries(policies)) {
    const mesh = await mesher.mesh({ geometries: [{ source: open, file: 'box.stl' }], ...size, ...policy });
    meshes[name] = { isWhole: await mesh.sha256() === await whole.sha256(), open: mesh.report.open };
  }
  const refused = (job) => mesher.mesh({ ...job, ...size }).then(() => 'meshed', ({ code, message }) => \`\${code}: \${message}\`);
  const ofJob = await refused({ geometries: [{ source: open, file: 'box.stl' }], open: 'error' });
  const ofGeometry = await refused({ geometries: [{ source: closed }, { source: open, file: 'box.stl', open: 'error' }] });
  const ofClosed = await refused({ geometries: [{ source: closed }], open: 'error' });
  console.log(JSON.stringify({ found: whole.report.open, meshes, ofJob, ofGeometry, ofClosed }));
  mesher.dispose();
`;

test('a box without a side is meshed whole, as its report says, or refused where it must not be open', () => {
  writeFileSync(path.join(project, 'boxes.js'), MESH_BOXES);
  const made = JSON.parse(execFileSync(process.execPath, ['boxes.js', CLOSED_BOX, OPEN_BOX], { cwd: project, encoding: 'utf8' }));
  assert.deepEqual(made.found, [], 'a closed box is no finding');
  assert.ok(made.meshes.default.isWhole);
  const [found, ...others] = made.meshes.default.open;
  assert.deepEqual(others, []);
  const { geometry, policy, open_edges, holes, turned, odd_rays, longest_at, doubtful_cells } = found;
  assert.deepEqual([geometry, policy, open_edges, holes, turned], ['box', 'winding', 4, 1, 0]);
  // rays along z enter by the lower side, and there is no upper one
  assert.deepEqual(odd_rays, [0, 0, 40 * 20]);
  assert.ok(doubtful_cells >= 40 * 20 * 20, `${doubtful_cells} doubtful cells`);
  const [x, y, z] = longest_at.map((number) => Math.round(1e3 * number) / 1e3);
  assert.ok(x === 2 && (y === 0 || y === 2) && z === 2, `the longest edge is at ${longest_at}`);
  assert.deepEqual(made.meshes.winding, made.meshes.default);
  assert.deepEqual([made.meshes.vote.isWhole, made.meshes.vote.open[0].policy], [true, 'vote']);
  assert.deepEqual(made.meshes.parity.open, [], 'rays of one axis do not look for holes');
  for (const message of [made.ofJob, made.ofGeometry]) {
    assert.match(message, /^surface-open: geometry "box" is not closed: open edges 4, loops 1/);
  }
  assert.equal(made.ofClosed, 'meshed');
});

const SPILL = `
  import { readFileSync } from 'node:fs';
  import { createMesher } from 'hexcast';
  const mesher = await createMesher({ backend: 'cpu' });
  const job = { geometries: [{ source: readFileSync(process.argv[2]) }], dims: [16, 600, 600], axis: 'x', max_memory: '1.5MB' };
  const problems = [];
  for (const spill of ['auto', false, true]) problems.push(await mesher.mesh(job, { spill }).catch(({ code, message, hint }) => ({ code, message, hint })));
  console.log(JSON.stringify(problems));
  mesher.dispose();
`;

test('columns cannot spill in Node, and both errors say what to do', () => {
  writeFileSync(path.join(project, 'spill.js'), SPILL);
  const stl = path.join(ROOT, 'tests/fixtures/spot.stl');
  const [auto, never, always] = JSON.parse(execFileSync(process.execPath, ['spill.js', stl], { cwd: project, encoding: 'utf8' }));
  assert.equal(auto.code, 'memory');
  assert.match(auto.message, /takes about .*1\.50 MB are allowed/);
  assert.match(auto.hint, /max_memory.*spill/);
  assert.deepEqual(never, auto);
  assert.deepEqual([always.code, always.hint], ['io', 'leave out spill, or mesh in a worker of a secure page']);
});

test('Node with the package webgpu meshes on the GPU, the same bytes', () => {
  const mesh = (backend, env) =>
    JSON.parse(
      execFileSync(process.execPath, ['mesh.js', SPOT, backend], { cwd: project, encoding: 'utf8', maxBuffer: 1 << 26, env }),
    );
  writeFileSync(path.join(project, 'mesh.js'), MESH);
  const cpu = mesh('auto', process.env);
  assert.equal(cpu.backend, 'cpu', 'without the package there is no GPU in Node');
  symlinkSync(path.join(ROOT, 'node_modules/webgpu'), path.join(project, 'node_modules/webgpu'));
  const driver = swiftshaderEnv();
  assert.ok(driver, 'Chromium brings SwiftShader, which this test needs');
  const gpu = mesh('gpu', { ...process.env, ...driver });
  assert.equal(gpu.backend, 'gpu');
  assert.deepEqual([gpu.sha256, gpu.files], [cpu.sha256, cpu.files]);
});

test('the types name the error codes of the native library, no more and no fewer', () => {
  const rust = readFileSync(path.join(ROOT, 'crates/job/src/base/error.rs'), 'utf8');
  const types = readFileSync(path.join(ROOT, 'www/hexcast.d.ts'), 'utf8');
  const ofRust = [
    ...rust
      .slice(rust.indexOf('pub const CODES'))
      .split('];')[0]
      .matchAll(/\(\s*"([a-z-]+)",\s*Actor/g),
  ].map((match) => match[1]);
  const ofTypes = [
    ...types
      .split('export type ErrorCode =')[1]
      .split(';')[0]
      .matchAll(/'([a-z-]+)'/g),
  ].map((match) => match[1]);
  assert.ok(ofRust.length > 20);
  assert.deepEqual(ofTypes.sort(), ofRust.sort());
});

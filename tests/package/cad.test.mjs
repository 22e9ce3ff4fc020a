// STEP and IGES files in the installed package: volumes, names, colours and units of their bodies, and what cannot be read.

import assert from 'node:assert/strict';
import { copyFileSync, readFileSync, statSync, writeFileSync } from 'node:fs';
import path from 'node:path';
import { after, before, test } from 'node:test';

import { ROOT } from '../../scripts/run.mjs';
import { serve } from '../../scripts/serve.mjs';
import { BROWSERS, withBrowser } from './pages.mjs';
import { installedProject } from './project.mjs';

const FIXTURES = path.join(ROOT, 'tests/fixtures');
const [MACHINE, TUBE] = ['machine.step', 'tube.igs'].map((name) => path.join(FIXTURES, name));
/** Files of other programs of CAD: the tests of occt-import-js. */
const REAL = path.join(ROOT, 'node_modules/occt-import-js/test/testfiles');
/** A policy in headers, which holds in workers, too: no text becomes code. */
const POLICY = "default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; worker-src 'self'; connect-src 'self'; img-src data:";

/** Volume and surface of each body of machine.step, in mm. */
const BODIES = (() => {
  const [a, b, c, r] = [30, 20, 10, 3];
  const [x, y, z] = [a, b, c].map((edge) => edge - 2 * r);
  const { PI } = Math;
  const block = {
    volume: x * y * z + 2 * r * (x * y + y * z + z * x) + PI * r * r * (x + y + z) + (4 / 3) * PI * r ** 3,
    area: 2 * (x * y + y * z + z * x) + 2 * PI * r * (x + y + z) + 4 * PI * r * r,
  };
  const tube = { volume: PI * (36 - 16) * 20, area: 2 * PI * (6 + 4) * 20 + 2 * PI * (36 - 16) };
  const ball = { volume: (4 / 3) * PI * 125, area: 4 * PI * 25 };
  const ring = { volume: 2 * PI * PI * 8 * 4, area: 4 * PI * PI * 8 * 2 };
  return [
    { name: 'machine/block rounded', colour: null, ...block },
    { name: 'machine/tube', colour: '#0066cc', ...tube },
    { name: 'machine/pair/ball', colour: '#ff0000', ...ball },
    { name: 'machine/pair/ring', colour: '#009900', ...ring },
    { name: 'machine/pair/ball 2', colour: '#ff0000', ...ball },
    { name: 'machine/pair/ring 2', colour: '#009900', ...ring },
  ];
})();

const SHOW = `
  import { readFileSync } from 'node:fs';
  import { createMesher } from 'hexcast';
  import { readCad } from 'hexcast/cad';
  const mesher = await createMesher({ backend: 'cpu' });
  const made = [];
  for (const { file, name, options, cells = 64 } of JSON.parse(process.argv[2])) {
    try {
      const { surface, ...cad } = await readCad(readFileSync(file), { file: name ?? file, cells, ...options });
      const geometries = [{ source: surface, file: name ?? file, split: true }];
      const { dims, report } = await mesher.mesh({ geometries, cells });
      const { flags, findings, unit } = report;
      made.push({ ...cad, dims, flags, findings, meshUnit: unit, head: Buffer.from(await surface.slice(0, 4).arrayBuffer()).toString('hex') });
    } catch ({ name, code, message, hint, details }) {
      made.push({ name, code, message, hint, details });
    }
  }
  console.log(JSON.stringify(made));
  mesher.dispose();
`;

let project;
/** What a program with the package makes of files. */
const shown = (...asked) => JSON.parse(project.run('cad.js', SHOW, JSON.stringify(asked)));
before(() => (project = installedProject()));
after(() => project.remove());

test('the package has Open CASCADE as it was published, and its licences beside it', () => {
  const there = (name) => path.join(project.folder, 'node_modules/hexcast/dist/cad/occt', name);
  for (const name of ['occt-import-js.js', 'occt-import-js.wasm', 'license.occt-import-js.txt', 'license.occt.txt']) {
    assert.ok(project.files.includes(`dist/cad/occt/${name}`), project.files.join(' '));
    assert.deepEqual(readFileSync(there(name)), readFileSync(path.join(ROOT, 'node_modules/occt-import-js/dist', name)));
  }
  const { version } = JSON.parse(readFileSync(path.join(ROOT, 'node_modules/occt-import-js/package.json'), 'utf8'));
  const notice = readFileSync(there('NOTICE.txt'), 'utf8');
  assert.match(notice, new RegExp(`occt-import-js ${version.replaceAll('.', '\\.')}`));
  assert.match(notice, /Lesser General Public License 2\.1[\s\S]*https:\/\/github\.com\/kovacsv\/occt-import-js/);
});

test('bodies of a STEP file have the volumes that they were made with, within the deviation', () => {
  const asked = [{}, { cells: 400 }, { options: { deviation: 1 } }, { options: { unit: 'cm' } }];
  const made = shown(...asked.map((one) => ({ file: MACHINE, ...one })));
  for (const [at, { unit, kind, head, meshUnit, deviation, bodies, flags, findings }] of made.entries()) {
    const mm = unit === 'cm' ? 10 : 1;
    assert.deepEqual([kind, head, meshUnit], ['step', '504b0304', unit]);
    assert.deepEqual(
      bodies.map(({ name, colour }) => ({ name, colour })),
      BODIES.map(({ name, colour }) => ({ name, colour })),
    );
    const known = BODIES.map(({ name }, index) => ({ flag: index + 1, name }));
    assert.deepEqual(
      flags.map(({ flag, name }) => ({ flag, name })),
      known,
    );
    for (const [index, { mesh_volume }] of flags.entries()) {
      const { name, volume, area } = BODIES[index];
      const off = Math.abs(mesh_volume * mm ** 3 - volume);
      assert.ok(off <= area * deviation * mm, `${at} ${name}: ${off} mm3 off, of ${area * deviation * mm}`);
      // chords of a convex body are within it
      assert.ok(/ring|tube/.test(name) || mesh_volume * mm ** 3 < volume, `${at} ${name}`);
    }
    assert.deepEqual(
      findings.filter(({ code }) => code === 'surface-open'),
      [],
      'all bodies are closed',
    );
  }
  const [coarse, fine, given, inCm] = made;
  // from the longest edge of the box, a tenth of a cell
  const longest = Math.max(...[0, 1, 2].map((axis) => coarse.bounds[3 + axis] - coarse.bounds[axis]));
  assert.ok(Math.abs(longest - 66) < 0.1, `${longest}`);
  assert.ok(Math.abs(coarse.deviation - (0.1 * longest) / 64) < 1e-9 && Math.abs(fine.deviation - (0.1 * 66) / 400) < 1e-4);
  assert.deepEqual([given.deviation, inCm.unit], [1, 'cm']);
  assert.ok(Math.abs(10 * inCm.deviation - coarse.deviation) < 1e-6);
  const facets = ({ bodies }) => bodies.reduce((sum, { facets }) => sum + facets, 0);
  assert.ok(facets(given) < facets(coarse) && 2 * facets(coarse) < facets(fine), `${made.map(facets)}`);
});

test('files of other programs are read in their units: an assembly, an inch, a metre, IGES', () => {
  const files = ['cax-if/as1-oc-214.stp', 'cube-units/cube-in.step', 'cube-units/cube-m.step', 'cube-10x10mm/Cube 10x10.igs'];
  const [assembly, inch, metre, iges] = shown(...files.map((name) => ({ file: path.join(REAL, name), name })));
  assert.equal(assembly.bodies.length, 18);
  const [nut, , rod] = assembly.bodies;
  assert.deepEqual(
    [nut.name, rod.name, nut.colour, rod.colour],
    ['as1/rod-assembly/nut', 'as1/rod-assembly/rod', '#ff0000', '#ff8000'],
  );
  assert.equal(new Set(assembly.bodies.map(({ name }) => name)).size, 18, 'each body has a name of its own');
  // a rod of 10 mm and 200 mm
  assert.ok(Math.abs(assembly.flags[2].mesh_volume / (Math.PI * 25 * 200) - 1) < 0.01, `${assembly.flags[2].mesh_volume}`);
  for (const { flags, unit } of [inch, metre]) {
    assert.equal(unit, 'mm');
    // both are cubes of a metre
    assert.ok(Math.abs(flags[0].mesh_volume / 1e9 - 1) < 1e-6, `${flags[0].mesh_volume}`);
  }
  assert.deepEqual([iges.kind, iges.bodies[0].name, iges.flags[0].mesh_volume], ['iges', 'Solid1', 1000]);
});

test('a body that is not closed is named, and is meshed by the winding number', () => {
  const [{ kind, flags, findings }] = shown({ file: TUBE, name: 'tube.igs', cells: 96 });
  assert.equal(kind, 'iges');
  const open = findings.filter(({ code }) => code === 'surface-open');
  assert.equal(open.length, 1);
  assert.match(open[0].sentence, /^geometry "tube" is not closed: open edges \d+/);
  assert.ok(Math.abs(flags[0].volume / (Math.PI * 20 * 20) - 1) < 0.005, `${flags[0].volume}`);
});

test('what is no file of CAD, has no body or a wrong option is refused with what to do', () => {
  const parts = path.join(REAL, 'cax-if/s1-c5-214/s1-c5-214.stp');
  const refused = shown(
    { file: path.join(FIXTURES, 'spot.stl'), name: 'spot.stl' },
    { file: parts, name: 'parts.stp' },
    { file: MACHINE, options: { deviation: 0 } },
    { file: MACHINE, options: { unit: 'furlong' } },
    { file: MACHINE, options: { devation: 1 } },
  );
  assert.deepEqual(
    refused.map(({ name, code }) => [name, code]),
    ['stl-not-stl', 'stl-empty', 'job-value', 'job-value', 'job-value'].map((code) => ['HexcastError', code]),
  );
  assert.match(refused[0].message, /^spot\.stl is neither STEP nor IGES/);
  assert.match(refused[1].message, /^parts\.stp has no surface/);
  assert.match(refused[1].hint, /references to files/);
  assert.deepEqual(
    refused.slice(2).map(({ details }) => details.key),
    ['deviation', 'unit', 'devation'],
  );
});

const CANCEL = `
  import { readFileSync } from 'node:fs';
  import { gzipSync } from 'node:zlib';
  import { readCad } from 'hexcast/cad';
  const bytes = readFileSync(process.argv[2]);
  const stop = new AbortController();
  let asked;
  setTimeout(() => { asked = performance.now(); stop.abort('enough'); }, 300);
  const reason = await readCad(bytes, { signal: stop.signal, deviation: 1e-5 }).then(() => 'made', (error) => error);
  const waited = performance.now() - asked;
  const { bodies } = await readCad(gzipSync(bytes), { deviation: 0.5 });
  const cut = await readCad(gzipSync(bytes).subarray(0, 9000)).catch(({ code }) => code);
  console.log(JSON.stringify({ reason, waited, bodies: bodies.length, cut, intact: bytes.length }));
`;

test('a call ends within half a second of its abort, and a packed file is read', () => {
  const { reason, waited, bodies, cut, intact } = JSON.parse(project.run('cancel.js', CANCEL, MACHINE));
  assert.equal(reason, 'enough');
  assert.ok(waited < 500, `${waited} ms`);
  assert.deepEqual([bodies, cut, intact], [6, 'file-syntax', statSync(MACHINE).size]);
});

const PAGE = `<!doctype html><meta charset="utf-8"><link rel="icon" href="data:,">
<script type="module" src="show.js"></script>`;
const IN_PAGE = `
  import { readCad } from './node_modules/hexcast/dist/cad.js';
  const bytes = await (await fetch('machine.step')).arrayBuffer();
  const { bodies, surface } = await readCad(bytes, { file: 'machine.step' });
  const stop = new AbortController();
  setTimeout(() => stop.abort('enough'), 200);
  const reason = await readCad(bytes, { signal: stop.signal, deviation: 1e-5 }).catch((error) => error);
  globalThis.outcome = { bodies, size: surface.size, reason };
`;

for (const [name, open] of Object.entries(BROWSERS)) {
  test(`a page without a bundler whose policy allows no text as code reads a STEP file in ${name}`, {
    timeout: 300_000,
  }, async () => {
    const put = (file, text) => writeFileSync(path.join(project.folder, file), text);
    put('index.html', PAGE);
    put('show.js', IN_PAGE);
    copyFileSync(MACHINE, path.join(project.folder, 'machine.step'));
    const server = await serve({ root: project.folder, headers: { 'Content-Security-Policy': POLICY } });
    await withBrowser(open, server, async (browser) => {
      const page = await browser.newPage();
      const said = [];
      page.on('console', (message) => said.push(message.text()));
      page.on('pageerror', (error) => said.push(error.message));
      await page.goto(server.url);
      const patience = { timeout: 120_000 };
      const outcome = await (await page.waitForFunction(() => globalThis.outcome, patience, patience))
        .jsonValue()
        .catch(() => assert.fail(said.join('\n')));
      assert.deepEqual(
        outcome.bodies.map(({ name, colour }) => [name, colour]),
        BODIES.map(({ name, colour }) => [name, colour]),
      );
      assert.ok(outcome.size > 1e5);
      assert.equal(outcome.reason, 'enough');
      assert.deepEqual(said, []);
    });
  });
}

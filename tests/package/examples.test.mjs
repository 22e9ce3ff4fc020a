// The examples, with the installed package: those of pages as Vite builds them, in Chromium; those of Node in Node.

import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { cpSync, readFileSync, readdirSync } from 'node:fs';
import path from 'node:path';
import { after, before, test } from 'node:test';

import { build } from 'vite';

import { ROOT } from '../../scripts/run.mjs';
import { serve } from '../../scripts/serve.mjs';
import { complaintsOf, openChromium } from '../e2e/browsers.mjs';
import { COMMAND, SPOT, installedProject } from './project.mjs';

const LONG = { timeout: 300_000 };
const EXAMPLES = path.join(ROOT, 'examples');

let project;
let server;
let browser;
before(async () => {
  project = installedProject();
  const outDir = path.join(project.folder, 'site');
  const hexcast = path.join(project.folder, 'node_modules/hexcast/dist/hexcast.js');
  await build({
    configFile: path.join(EXAMPLES, 'vite.config.js'),
    logLevel: 'warn',
    resolve: { alias: { hexcast } },
    build: { outDir, emptyOutDir: true },
  });
  server = await serve({ root: outDir });
  browser = await openChromium();
});
after(async () => {
  await browser?.close();
  await server?.close();
  project?.remove();
});

/** Opens an example, runs a check on its page, and holds it to be without complaints. */
async function onPage(name, check) {
  const page = await browser.newPage();
  const url = `${server.url}${name}/index.html`;
  const complaints = complaintsOf(page, url);
  await page.goto(url);
  // it takes files once its mesher is there
  await page.waitForSelector('#file:enabled');
  const state = async (pattern) => {
    await page.waitForFunction((text) => new RegExp(text).test(document.getElementById('state').textContent), pattern.source);
    return pattern.exec(await page.textContent('#state'));
  };
  await check(page, state);
  // SwiftShader says this of pictures that tests take
  const isOurs = (line) => !line.includes('GPU stall due to ReadPixels');
  assert.deepEqual(complaints.filter(isOurs), []);
  await page.close();
}

/** Writes a file of the model by the native command. */
function native(name, ...options) {
  const file = path.join(project.folder, name);
  const job = ['mesh', SPOT, '--backend', 'cpu', '--quiet', ...options, '-o', file];
  execFileSync(COMMAND, job);
  return readFileSync(file);
}

/** Runs an example of Node in the project. */
function inNode(name, ...args) {
  cpSync(path.join(EXAMPLES, name), path.join(project.folder, name));
  return execFileSync(process.execPath, [name, ...args], { cwd: project.folder, encoding: 'utf8' });
}

test('every example is listed on their page and is part of a test', () => {
  // scale/ has what schedulers run
  const isPage = (entry) => entry.isDirectory() && entry.name !== 'scale';
  const pages = readdirSync(EXAMPLES, { withFileTypes: true }).filter(isPage);
  const listed = readFileSync(path.join(EXAMPLES, 'index.html'), 'utf8');
  for (const { name } of pages) assert.ok(listed.includes(`./${name}/index.html`), name);
  assert.deepEqual(pages.map(({ name }) => name).sort(), ['cubes', 'download', 'lbm', 'progress']);
  const scripts = readdirSync(EXAMPLES).filter((name) => name.endsWith('.js') && name !== 'vite.config.js');
  assert.deepEqual(scripts.sort(), ['columns.js', 'vti.js']);
});

test('vti.js writes the file of the native command', LONG, () => {
  const told = inNode('vti.js', SPOT, 'spot.vti', '100');
  const [, ...dims] = /^spot\.vti: (\d+) x (\d+) x (\d+) cells, meshed on the cpu$/m.exec(told);
  assert.equal(Math.max(...dims.map(Number)), 100);
  assert.ok(readFileSync(path.join(project.folder, 'spot.vti')).equals(native('native.vti', '--cells', '100', '--compress=6')));
});

test('columns.js counts the cells of the report', LONG, () => {
  const { dims, axis, flags } = JSON.parse(inNode('columns.js', SPOT));
  const raw = native('native.raw', '--cells', '256');
  assert.equal(raw.length, dims[0] * dims[1] * dims[2]);
  const stride = { x: 1, y: dims[0], z: dims[0] * dims[1] }[axis];
  const size = dims['xyz'.indexOf(axis)];
  let [cells, longest] = [0, 0];
  for (let at = 0; at < raw.length; at += 1) {
    if (raw[at] !== 1) continue;
    cells += 1;
    // the run that begins here
    if (Math.floor(at / stride) % size > 0 && raw[at - stride] === 1) continue;
    let length = 1;
    while ((Math.floor(at / stride) % size) + length < size && raw[at + length * stride] === 1) length += 1;
    longest = Math.max(longest, length);
  }
  assert.deepEqual(flags, { 1: { cells, longest } });
});

test('download/ saves the file of the native command', LONG, () =>
  onPage('download', async (page, state) => {
    const saved = page.waitForEvent('download');
    await page.setInputFiles('#file', SPOT);
    const download = await saved;
    assert.equal(download.suggestedFilename(), 'spot.vti');
    assert.ok(readFileSync(await download.path()).equals(native('download.vti', '--cells', '128', '--compress=6')));
    await state(/^spot\.vti: \d+ x \d+ x \d+ cells$/);
    await page.setInputFiles('#file', { name: 'no.stl', mimeType: 'model/stl', buffer: Buffer.from('nothing') });
    await state(/text that begins with "nothing".*; export the model as STL, OBJ, OFF, PLY, 3MF or GLB$/);
  }),
);

test('progress/ shows how far it is, is cancelled, and then ends', LONG, () =>
  onPage('progress', async (page, state) => {
    await page.evaluate(() => {
      globalThis.shares = [];
      const bar = document.getElementById('bar');
      new MutationObserver(() => globalThis.shares.push(bar.value)).observe(bar, { attributes: true });
    });
    await page.setInputFiles('#file', SPOT);
    await state(/^(Reading|Meshing): \d+ %$/);
    await page.click('#cancel');
    await state(/^Cancelled$/);
    assert.ok(await page.isDisabled('#cancel'));
    await page.setInputFiles('#file', []);
    await page.setInputFiles('#file', SPOT);
    const [, cells, hash] = await state(/^SHA-256 of (\d+) flags: ([0-9a-f]{64})$/);
    const raw = native('progress.raw', '--cells', '1000');
    assert.equal(Number(cells), raw.length);
    const expected = await crypto.subtle.digest('SHA-256', raw);
    assert.equal(hash, Buffer.from(expected).toString('hex'));
    const shares = await page.evaluate(() => globalThis.shares);
    assert.ok(
      shares.some((share) => share > 0 && share < 1),
      `${shares}`,
    );
  }),
);

test('cubes/ draws a cube for each cell that can be seen', LONG, () =>
  onPage('cubes', async (page, state) => {
    await page.setInputFiles('#file', SPOT);
    const [, n, ...sizes] = (await state(/^(\d+) cubes of (\d+) x (\d+) x (\d+) cells$/)).map(Number);
    const [nx, ny, nz] = sizes;
    const raw = native('cubes.raw', '--cells', '64');
    const flag = (x, y, z) => (x >= 0 && y >= 0 && z >= 0 && x < nx && y < ny && z < nz ? raw[x + nx * (y + ny * z)] : 0);
    let expected = 0;
    for (let z = 0; z < nz; z += 1) {
      for (let y = 0; y < ny; y += 1) {
        for (let x = 0; x < nx; x += 1) {
          const steps = [
            [1, 0, 0],
            [0, 1, 0],
            [0, 0, 1],
          ].flatMap((step) => [step, step.map((n) => -n)]);
          if (flag(x, y, z) && steps.some(([dx, dy, dz]) => !flag(x + dx, y + dy, z + dz))) expected += 1;
        }
      }
    }
    assert.equal(n, expected);
    const picture = await page.locator('#view').screenshot();
    await page.setInputFiles('#file', []);
    assert.ok(picture.length > 10_000, `a picture of ${picture.length} bytes is empty`);
  }),
);

/** In the page: what the flow is now, from its distributions and from the flags that the host expands. */
async function flowNow() {
  const { mesh, flow } = globalThis.lbm;
  const [{ flags }, moments] = [await mesh.box([0, 0, 0], mesh.dims), await flow.moments()];
  const found = { dims: mesh.dims, names: mesh.report.flags.map(({ name }) => name), steps: flow.steps, n_solid: 0, n_moved: 0 };
  let [mass, momentum, n_fluid] = [0, 0, 0];
  for (let cell = 0; cell < flags.length; cell += 1) {
    const [density, u, v, w] = moments.subarray(4 * cell, 4 * cell + 4);
    if (flags[cell] > 0) {
      found.n_solid += 1;
      if (u !== 0 || v !== 0 || w !== 0) found.n_moved += 1;
    } else {
      n_fluid += 1;
      mass += density;
      momentum += (1 + density) * u;
    }
  }
  return { ...found, mass: mass / n_fluid, momentum: momentum / n_fluid };
}

test('lbm/ steps around samples and dropped files: mass stays, solid cells rest, MLUPS are shown', LONG, () =>
  onPage('lbm', async (page, state) => {
    const check = async (name) => {
      await page.waitForFunction((wanted) => globalThis.lbm?.mesh.report.flags[0].name === wanted, name);
      await page.waitForFunction(() => globalThis.lbm.flow.steps >= 8);
      await state(/^Step \d+: \d+\.\d MLUPS \(\d+ fluid cells\), fastest \d\.\d\de-\d cells a step$/);
      await page.click('#pause');
      const now = await page.evaluate(flowNow);
      await page.click('#pause');
      assert.deepEqual(now.dims, [64, 64, 64]);
      assert.ok(now.n_solid > 1000, `${now.n_solid} solid cells`);
      assert.equal(now.n_moved, 0, 'solid cells are at rest');
      // distributions differ by 1e-5 or less from those at rest, and f32 has 24 bits
      assert.ok(Math.abs(now.mass) < 1e-10, `a cell has gained a mass of ${now.mass}`);
      // the force gives 4e-6 a step, of which the walls take a hundredth in the first steps
      const given = 4e-6 * now.steps;
      assert.ok(
        now.momentum > 0 && now.momentum < 0.995 * given,
        `momentum ${now.momentum} of ${given} after ${now.steps} steps`,
      );
      return now;
    };
    await check('knot');
    await page.selectOption('#sample', 'cubes');
    assert.deepEqual((await check('copper')).names, ['copper', 'epoxy']);
    const stl = [...readFileSync(SPOT)];
    await page.evaluate((bytes) => {
      const dataTransfer = new DataTransfer();
      dataTransfer.items.add(new File([Uint8Array.from(bytes)], 'dropped.stl'));
      document.body.dispatchEvent(new DragEvent('drop', { dataTransfer, bubbles: true, cancelable: true }));
    }, stl);
    await check('dropped');
    const options = await page.locator('#sample option').allTextContents();
    assert.equal(options.length, 6, options.join());
  }),
);

// Times the page in Chromium beside the native program, both on SwiftShader, then makes the largest mesh in the page and
// saves it to the private file system: "npm run bench -- page". bench.mjs writes the tables into benches/RESULTS.md.

import { createHash } from 'node:crypto';
import { execFileSync } from 'node:child_process';
import { cpSync, readFileSync, statSync } from 'node:fs';
import path from 'node:path';

import { openChromiumProfile } from '../tests/e2e/browsers.mjs';
import { DIST, build } from './build.mjs';
import { NATIVE_ENV, swiftshaderEnv } from './machine.mjs';
import { serve } from './serve.mjs';

/** Cells along an edge of the largest mesh: 1.0008e10 cells. */
const LARGEST = 2155;

/**
 * Times everything.
 *
 * @param {{sizes: number[], rounds: number, runs: string, largest?: string, quick: boolean}} options
 * @param {object} tools of bench.mjs: the folder for files, the program, how to run it, and how tables are written
 * @returns {Promise<{adapter: string, text: string}>}
 */
export async function benchPage({ sizes, rounds, runs, largest, quick }, tools) {
  const driver = swiftshaderEnv();
  if (!driver) throw new Error("missing: SwiftShader as a Vulkan driver, which Debian's package chromium brings");
  console.log(await build());
  const root = path.join(tools.scratch, 'site');
  cpSync(DIST, root, { recursive: true });
  const file = path.join(root, 'spheres.stl');
  tools.run(tools.bench, ['--spheres', file]);
  const server = await serve({ root });
  const context = await openChromiumProfile(path.join(tools.scratch, 'profile'), ['--enable-unsafe-swiftshader']);
  try {
    const site = { context, url: server.url, file, driver };
    const races = [];
    for (const n of sizes) races.push(await race(site, tools, { n, rounds, runs }));
    const n = Number(largest ?? (quick ? 300 : LARGEST));
    const biggest = { page: await largestInPage(site, n), native: largestNatively(site, tools, n), n };
    const text = [
      '### From the read file to columns, 64 spheres\n',
      races.map((result) => raceTable(result, tools)).join('\n\n'),
      '\n### The largest mesh\n',
      largestTable(biggest, tools),
    ].join('\n');
    return { adapter: `SwiftShader, for both (${races[0].adapter} to the page)`, text };
  } finally {
    await context.close();
    await server.close();
  }
}

/** Who meshes, and how: a native backend with its environment, or the page's. */
const RACERS = [
  { id: 'nativeGpu', name: 'native, GPU', backend: 'gpu' },
  { id: 'pageGpu', name: 'page, GPU', backend: 'gpu', isPage: true, beside: 'nativeGpu' },
  { id: 'nativeCpu', name: 'native, CPU, all cores', backend: 'cpu' },
  { id: 'nativeOne', name: 'native, CPU, one thread', backend: 'cpu', env: { RAYON_NUM_THREADS: '1' } },
  { id: 'pageCpu', name: 'page, CPU (wasm, one thread)', backend: 'cpu', isPage: true, beside: 'nativeOne' },
];

/** Seconds of every warm run of every racer, in turn: of the stages from the read file to columns, and from click to result. */
async function race(site, tools, { n, rounds, runs }) {
  const stages = Object.fromEntries(RACERS.map(({ id }) => [id, []]));
  const clicks = Object.fromEntries(RACERS.map(({ id }) => [id, []]));
  let adapter;
  const sum = ({ lines, snap, columns }) => lines + snap + columns;
  for (let round = 0; round < rounds; round += 1) {
    for (const { id, backend, isPage, env } of RACERS) {
      if (isPage) {
        const made = await runInPage(site, n, backend, Number(runs));
        stages[id].push(...made.map(({ report }) => sum(report.seconds)));
        clicks[id].push(...made.map(({ seconds }) => seconds));
        adapter ??= made[0].report.adapter;
      } else {
        const args = ['--file', site.file, '--cells', String(n), '--backends', backend, '--runs', runs];
        const environment = { ...process.env, ...NATIVE_ENV, ...(backend === 'gpu' ? site.driver : {}), ...env };
        const [made] = tools.jsonLines(
          execFileSync(tools.bench, args, { encoding: 'utf8', env: environment, stdio: ['ignore', 'pipe', 'ignore'] }),
        );
        stages[id].push(...made.runs.map(sum));
      }
    }
  }
  return { n, stages, clicks, adapter };
}

/** Meshes with a click on the page, as often as asked and once before; with the seconds until the page shows the result. */
async function runInPage({ context, url, file }, n, backend, runs) {
  const page = await context.newPage();
  try {
    // another hash alone would not load the page again
    await page.goto(`${url}?${backend}#cells=${n}&backend=${backend}`);
    await page.waitForSelector('body[data-phase=idle]');
    await page.setInputFiles('#file-input', file);
    await page.waitForSelector('.geometry');
    const made = [];
    for (let run = 0; run <= runs; run += 1) {
      await page.waitForSelector('#run:enabled');
      await page.evaluate(pictureIsDrawn);
      made.push(await page.evaluate(clickAndWait));
      // the surface for the 3-D view is made after the mesh, and must not count as the next one's
      await page.waitForFunction(() => /triangles|No cell/.test(document.querySelector('#view-status').textContent), null, {
        timeout: 0,
      });
    }
    return made.slice(1);
  } finally {
    await page.close();
  }
}

/** In the page: resolves once the 3-D view stands still, which takes a driver on the processor a second after a mesh. */
async function pictureIsDrawn() {
  const gl = document.querySelector('#canvas-3d').getContext('webgl2');
  for (let frame = 0; frame < 3; frame += 1) {
    await new Promise(requestAnimationFrame);
    // reading waits for all that was drawn
    gl?.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
  }
}

/** In the page: clicks, and resolves once the result is shown. */
function clickAndWait() {
  return new Promise((resolve, reject) => {
    const start = performance.now();
    const observer = new MutationObserver(() => {
      if (document.body.dataset.phase !== 'idle') return;
      observer.disconnect();
      const seconds = (performance.now() - start) / 1000;
      // the report is written in the same task
      setTimeout(() => {
        const message = document.querySelector('#messages [role=alert]')?.textContent;
        if (message) reject(new Error(message));
        else resolve({ seconds, report: JSON.parse(document.querySelector('#report').textContent) });
      });
    });
    observer.observe(document.body, { attributeFilter: ['data-phase'] });
    document.querySelector('#run').click();
  });
}

/** Makes the largest mesh with the package in a page, and streams its column file and its bits to the private file system. */
async function largestInPage({ context, url }, n) {
  const page = await context.newPage();
  await page.goto(url);
  const made = await page.evaluate(async (n) => {
    const { createMesher } = await import(new URL('hexcast.js', location.href).href);
    const mesher = await createMesher({ backend: 'gpu' });
    const source = new File([await (await fetch('spheres.stl')).blob()], 'spheres.stl');
    const mesh = await mesher.mesh({ geometries: [{ source }], cells: n });
    const root = await navigator.storage.getDirectory();
    const files = {};
    for (const [id, format, options] of [
      ['hxc', 'hxc', {}],
      ['bits', 'raw', { bits: true }],
    ]) {
      const start = performance.now();
      const handle = await root.getFileHandle(`largest.${id}`, { create: true });
      await mesh.stream(format, options).pipeTo(await handle.createWritable());
      const seconds = (performance.now() - start) / 1000;
      const file = await handle.getFile();
      files[id] = { seconds, bytes: file.size };
      if (id === 'hxc') files.hash = [...new Uint8Array(await crypto.subtle.digest('SHA-256', await file.arrayBuffer()))];
      await root.removeEntry(`largest.${id}`);
    }
    const { report, columns } = mesh;
    mesher.dispose();
    return { report, columnBytes: columns.bytes, files };
  }, n);
  await page.close();
  return made;
}

/** The same with the native command; its files must be those of the page. */
function largestNatively({ file, driver }, tools, n) {
  const command = tools.command;
  const write = (name, ...options) => {
    const args = [
      'mesh',
      file,
      '--cells',
      String(n),
      '--backend',
      'gpu',
      '--hash',
      'never',
      '--quiet',
      '--json',
      ...options,
      '-o',
      path.join(tools.scratch, name),
    ];
    const env = { ...process.env, ...driver };
    return JSON.parse(execFileSync(command, args, { encoding: 'utf8', env, stdio: ['ignore', 'pipe', 'ignore'] }));
  };
  const bytes = (name) => statSync(path.join(tools.scratch, name)).size;
  const [hxc, bits] = [write('largest.hxc', '--compress=none'), write('largest.raw', '--bits')];
  const hash = [
    ...createHash('sha256')
      .update(readFileSync(path.join(tools.scratch, 'largest.hxc')))
      .digest(),
  ];
  return {
    report: hxc,
    files: {
      hxc: { seconds: hxc.seconds.write, bytes: bytes('largest.hxc') },
      bits: { seconds: bits.seconds.write, bytes: bytes('largest.raw') },
      hash,
    },
  };
}

function raceTable({ n, stages, clicks }, { median, ms, table }) {
  const rows = RACERS.map(({ id, name, beside }) => {
    const [all, middle] = [stages[id], median(stages[id])];
    const other = beside && RACERS.find((racer) => racer.id === beside);
    const ratio = other ? `${(middle / median(stages[other.id])).toFixed(2)} of ${other.name}` : '';
    const click = clicks[id].length > 0 ? ms(median(clicks[id])) : '';
    return [
      name,
      ms(middle),
      `${ms(Math.min(...all))} - ${ms(Math.max(...all))}`,
      click,
      (n ** 3 / middle / 1e9).toFixed(2),
      ratio,
    ];
  });
  return table([`${n}^3`, 'columns, ms', 'from - to', 'click to result, ms', '1e9 cells/s', 'time'], rows);
}

function largestTable({ n, page, native }, { table }) {
  if (page.files.hash.join() !== native.files.hash.join())
    throw new Error("the page's column file is not that of the native command");
  const s = (seconds) => seconds.toFixed(2);
  const stages = ({ seconds: { lines, snap, columns } }) => s(lines + snap + columns);
  const row = (name, { report, files }) => [name, stages(report), s(files.hxc.seconds), s(files.bits.seconds)];
  const { report } = page;
  return [
    table(
      [`${n}^3 = ${report.cells} cells, SwiftShader`, 'columns, s', 'column file, s', 'packed file, s'],
      [row('page', page), row('native', native)],
    ),
    '',
    `The columns take ${page.columnBytes} bytes of memory (${report.runs} runs, ${report.rays} rays), the device's buffers ${report.peak_bytes.device}; ` +
      `the column file has ${page.files.hxc.bytes} bytes, the same as the native command's, the packed file ${page.files.bits.bytes}.`,
  ].join('\n');
}

// The largest mesh on the page and with the native program, for page.mjs.

import { createHash } from 'node:crypto';
import { readFileSync, statSync } from 'node:fs';
import path from 'node:path';

import { meshByClick } from '../tests/e2e/browsers.mjs';
import { output, table } from './results.mjs';

/**
 * @typedef {import('./page.mjs').Site} Site
 *
 * The report; seconds to write the column file and the packed file, their bytes, and the hash of the column file.
 *
 * @typedef {object} Largest
 * @property {import('./results.mjs').Report} report
 * @property {number} [columnBytes]
 * @property {Record<'hxc' | 'bits', { seconds: number, bytes: number }>} files
 * @property {string} sha256
 */

/**
 * Makes the largest mesh with the package in a page, and streams its column file and its bits to the private file system.
 *
 * @param {Site} site
 * @param {number} n
 * @returns {Promise<Largest>}
 */
async function largestInPage({ context, url, spheres }, n) {
  const page = await context.newPage();
  // the page meshes nothing by itself beside it
  await page.addInitScript(meshByClick);
  await page.goto(url);
  const input = await page.evaluateHandle(() =>
    document.body.appendChild(Object.assign(document.createElement('input'), { type: 'file' })),
  );
  await input.setInputFiles(spheres);
  const made = await page.evaluate(
    async ({ input, n }) => {
      const { createMesher } = await import(new URL('hexcast.js', location.href).href);
      const mesher = await createMesher({ backend: 'gpu' });
      const [source] = input.files ?? [];
      const mesh = await mesher.mesh({ geometries: [{ source }], cells: n });
      const root = await navigator.storage.getDirectory();
      const write = async (/** @type {string} */ format, /** @type {object} */ options) => {
        const start = performance.now();
        const handle = await root.getFileHandle(`largest.${format}`, { create: true });
        await mesh.stream(format, options).pipeTo(await handle.createWritable());
        const seconds = (performance.now() - start) / 1000;
        const file = await handle.getFile();
        return { file, written: { seconds, bytes: file.size } };
      };
      const hxc = await write('hxc', {});
      const hash = new Uint8Array(await crypto.subtle.digest('SHA-256', await hxc.file.arrayBuffer()));
      await root.removeEntry('largest.hxc');
      const bits = await write('raw', { bits: true });
      await root.removeEntry('largest.raw');
      const { report, columns } = mesh;
      mesher.dispose();
      const sha256 = [...hash].map((byte) => byte.toString(16).padStart(2, '0')).join('');
      return { report, columnBytes: columns.bytes, files: { hxc: hxc.written, bits: bits.written }, sha256 };
    },
    { input, n },
  );
  await page.close();
  return made;
}

/**
 * Does the same with the native command.
 *
 * @param {Site} site
 * @param {number} n
 * @returns {Largest}
 */
function largestNatively({ spheres, driver, command, folder }, n) {
  const write = (/** @type {string} */ name, /** @type {string[]} */ ...options) => {
    const file = path.join(folder, name);
    const how = ['--cells', String(n), '--backend', 'gpu', '--quiet', '--json', ...options];
    const report = JSON.parse(output(command, ['mesh', spheres, ...how, '-o', file], driver));
    return { file, report, written: { seconds: report.seconds.write, bytes: statSync(file).size } };
  };
  const [hxc, bits] = [write('largest.hxc', '--compress=none'), write('largest.raw', '--bits')];
  const sha256 = createHash('sha256').update(readFileSync(hxc.file)).digest('hex');
  return { report: hxc.report, files: { hxc: hxc.written, bits: bits.written }, sha256 };
}

/** Makes the largest mesh on the page and natively; the files must be the same. @param {Site} site @param {number} n */
export async function benchLargest(site, n) {
  const [page, native] = [await largestInPage(site, n), largestNatively(site, n)];
  if (page.sha256 !== native.sha256) throw new Error("the page's column file is not that of the native command");
  const s = (/** @type {number} */ seconds) => seconds.toFixed(2);
  const row = (/** @type {string} */ name, /** @type {Largest} */ { report, files }) => {
    const { lines, snap, columns } = report.seconds;
    return [name, s(lines + snap + columns), s(files.hxc.seconds), s(files.bits.seconds)];
  };
  const { report } = page;
  const head = [`${n}^3 = ${report.cells} cells, SwiftShader`, 'columns, s', 'column file, s', 'packed file, s'];
  const sizes =
    `The columns take ${page.columnBytes} bytes of memory (${report.runs} runs, ${report.rays} rays), the device's buffers ${report.peak_bytes.device}; ` +
    `the column file has ${page.files.hxc.bytes} bytes, the same as the native command's, the packed file ${page.files.bits.bytes}.`;
  return `${table(head, [row('page', page), row('native', native)])}\n\n${sizes}`;
}

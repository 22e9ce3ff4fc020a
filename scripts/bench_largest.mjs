// The largest mesh in the page and with the native program, for bench_page.mjs.

import { execFileSync } from 'node:child_process';
import { createHash } from 'node:crypto';
import { readFileSync, statSync } from 'node:fs';
import path from 'node:path';

/**
 * @typedef {import('./bench_page.mjs').Site} Site
 * @typedef {import('./bench_page.mjs').Tools} Tools
 * @typedef {import('./bench_page.mjs').Writing} Writing
 *
 * Seconds to write a file, and its bytes.
 *
 * @typedef {{ seconds: number, bytes: number }} Written
 *
 * The report, the files, and the hash of the column file.
 *
 * @typedef {object} Largest
 * @property {import('./results.mjs').Report} report
 * @property {number} [columnBytes]
 * @property {{ hxc: Written, bits: Written, hash: number[] }} files
 */

/**
 * Makes the largest mesh with the package in a page, and streams its column file and its bits to the private file system.
 *
 * @param {Site} site
 * @param {number} n
 * @returns {Promise<Largest>}
 */
export async function largestInPage({ context, url }, n) {
  const page = await context.newPage();
  await page.goto(url);
  const made = await page.evaluate(async (n) => {
    const { createMesher } = await import(new URL('hexcast.js', location.href).href);
    const mesher = await createMesher({ backend: 'gpu' });
    const source = new File([await (await fetch('spheres.stl')).blob()], 'spheres.stl');
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
    const hash = [...new Uint8Array(await crypto.subtle.digest('SHA-256', await hxc.file.arrayBuffer()))];
    await root.removeEntry('largest.hxc');
    const bits = await write('raw', { bits: true });
    await root.removeEntry('largest.raw');
    const { report, columns } = mesh;
    mesher.dispose();
    return { report, columnBytes: columns.bytes, files: { hxc: hxc.written, bits: bits.written, hash } };
  }, n);
  await page.close();
  return made;
}

/**
 * The same with the native command; its files must be those of the page.
 *
 * @param {Site} site
 * @param {Tools} tools
 * @param {number} n
 * @returns {Largest}
 */
export function largestNatively({ file, driver }, tools, n) {
  const write = (/** @type {string} */ name, /** @type {string[]} */ ...options) => {
    const how = ['--cells', String(n), '--backend', 'gpu', '--hash', 'never', '--quiet', '--json', ...options];
    const args = ['mesh', file, ...how, '-o', path.join(tools.scratch, name)];
    const env = { ...process.env, ...driver };
    return JSON.parse(execFileSync(tools.command, args, { encoding: 'utf8', env, stdio: ['ignore', 'pipe', 'ignore'] }));
  };
  const bytes = (/** @type {string} */ name) => statSync(path.join(tools.scratch, name)).size;
  const [hxc, bits] = [write('largest.hxc', '--compress=none'), write('largest.raw', '--bits')];
  const columns = readFileSync(path.join(tools.scratch, 'largest.hxc'));
  const hash = [...createHash('sha256').update(columns).digest()];
  return {
    report: hxc,
    files: {
      hxc: { seconds: hxc.seconds.write, bytes: bytes('largest.hxc') },
      bits: { seconds: bits.seconds.write, bytes: bytes('largest.raw') },
      hash,
    },
  };
}

/** @param {{ n: number, page: Largest, native: Largest }} largest @param {Writing} writing */
export function largestTable({ n, page, native }, { table }) {
  if (page.files.hash.join() !== native.files.hash.join())
    throw new Error("the page's column file is not that of the native command");
  const s = (/** @type {number} */ seconds) => seconds.toFixed(2);
  const row = (/** @type {string} */ name, /** @type {Largest} */ { report, files }) => {
    const { lines, snap, columns } = report.seconds;
    return [name, s(lines + snap + columns), s(files.hxc.seconds), s(files.bits.seconds)];
  };
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

// Large models: a sphere with waves, closed, of as many facets as are asked for.

import { closeSync, openSync, writeSync } from 'node:fs';

/**
 * Writes binary STL of `2 * n * (n / 2 - 1)` facets: n points around the axis, n / 2 from pole to pole.
 *
 * @param {string} file
 * @param {number} n even
 * @returns {number} facets
 */
export function writeWave(file, n) {
  const n_rows = n / 2;
  const n_facets = 2 * n * (n_rows - 1);
  const out = openSync(file, 'w');
  const head = Buffer.alloc(84);
  head.writeUInt32LE(n_facets, 80);
  writeSync(out, head);
  // equal corners are equal bits: each is computed from its row and its place in it alone
  const corner = (/** @type {number} */ row, /** @type {number} */ place) => {
    if (row === 0 || row === n_rows) return [0, 0, row === 0 ? 1 : -1];
    const [t, p] = [(Math.PI * row) / n_rows, (2 * Math.PI * (place % n)) / n];
    const r = 1 + 0.05 * Math.sin(7 * p) * Math.sin(t) ** 2 * Math.cos(5 * t);
    return [r * Math.sin(t) * Math.cos(p), r * Math.sin(t) * Math.sin(p), r * Math.cos(t)];
  };
  let above = Array.from({ length: n + 1 }, (_, place) => corner(0, place));
  for (let row = 1; row <= n_rows; row += 1) {
    const below = Array.from({ length: n + 1 }, (_, place) => corner(row, place));
    const bytes = Buffer.alloc(100 * n);
    let at = 0;
    const put = (/** @type {number[][]} */ ...corners) => {
      corners.flat().forEach((number, k) => void bytes.writeFloatLE(number, at + 12 + 4 * k));
      at += 50;
    };
    for (let place = 0; place < n; place += 1) {
      if (row > 1) put(above[place], below[place], above[place + 1]);
      if (row < n_rows) put(above[place + 1], below[place], below[place + 1]);
    }
    writeSync(out, bytes.subarray(0, at));
    above = below;
  }
  closeSync(out);
  return n_facets;
}

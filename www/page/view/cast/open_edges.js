/** The open edges of a surface: those that an odd number of its facets have. */

const NONE = 2 ** 32 - 1;

/**
 * Corners with equal coordinates are one; a facet with two equal corners has no edges. Takes O(n log n) time, and 40 bytes a corner.
 *
 * @param {Float32Array} corners nine numbers a facet
 * @returns {Float32Array} six numbers an edge: its two ends
 */
export function openEdges(corners) {
  const first = firstOfEach(corners);
  const n = first.length;
  const keys = new Float64Array(n);
  let n_edges = 0;
  for (let at = 0; at < n; at += 3) {
    const [a, b, c] = first.subarray(at, at + 3);
    if (a === b || b === c || a === c) continue;
    for (const [one, other] of [
      [a, b],
      [b, c],
      [c, a],
    ])
      keys[n_edges++] = Math.min(one, other) * n + Math.max(one, other);
  }
  const sorted = keys.subarray(0, n_edges).sort();
  /** @type {number[]} */
  const open = [];
  for (let at = 0, end = 0; at < n_edges; at = end) {
    while (end < n_edges && sorted[end] === sorted[at]) end += 1;
    if ((end - at) % 2 === 0) continue;
    for (const corner of [Math.floor(sorted[at] / n), sorted[at] % n]) open.push(...corners.subarray(3 * corner, 3 * corner + 3));
  }
  return Float32Array.from(open);
}

/** Of each corner the first that is equal, by a table of hashes. @param {Float32Array} corners */
function firstOfEach(corners) {
  const n = corners.length / 3;
  const bits = new Uint32Array(corners.map((number) => number + 0).buffer); // -0 is 0
  let size = 16;
  while (size < 2 * n) size *= 2;
  const table = new Uint32Array(size).fill(NONE);
  const first = new Uint32Array(n);
  for (let corner = 0; corner < n; corner += 1) {
    const [x, y, z] = [bits[3 * corner], bits[3 * corner + 1], bits[3 * corner + 2]];
    let hash = Math.imul(Math.imul(x ^ (x >>> 15), 0x2c1b3c6d) + y, 0x297a2d39) + z;
    hash = Math.imul(hash ^ (hash >>> 15), 0x1b56c4e9);
    let at = (hash ^ (hash >>> 16)) & (size - 1);
    for (; table[at] !== NONE; at = (at + 1) & (size - 1)) {
      const other = 3 * table[at];
      if (bits[other] === x && bits[other + 1] === y && bits[other + 2] === z) break;
    }
    if (table[at] === NONE) table[at] = corner;
    first[corner] = table[at];
  }
  return first;
}

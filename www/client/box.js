/** Boxes of cells: where their flags go, and the pieces in which they are expanded. */
import { kindOf, wrongValue } from './check.js';
import { HexcastError } from '../protocol/error.js';

/** @typedef {[number, number, number]} Cell */

/** Bytes that are expanded at a time. */
export const SLAB_BYTES = 16 << 20;
/** Most bytes of an array that every browser allows. */
const MOST_BYTES = 2 ** 32 - 1;

/**
 * A new array for the flags of a box, or the first bytes of the caller's.
 *
 * @param {Cell} start
 * @param {Cell} end
 * @param {Uint8Array} [into]
 * @returns {any} a `Uint8Array` of the kind of the caller's
 */
export function placeFor(start, end, into) {
  const sizes = end.map((number, axis) => number - start[axis]);
  const n_bytes = sizes.reduce((product, size) => product * size, 1);
  if (into !== undefined) {
    if (kindOf(into) !== 'Uint8Array') throw wrongValue('into', into, 'a Uint8Array');
    if (into.length >= n_bytes) return into.subarray(0, n_bytes);
    const details = { key: 'into', found: into.length, allowed: n_bytes };
    const message = `into has ${into.length} bytes; a box of ${sizes.join(' x ')} cells has ${n_bytes}`;
    throw new HexcastError('job-value', message, { hint: 'give a larger array', details });
  }
  try {
    if (n_bytes <= MOST_BYTES) return new Uint8Array(n_bytes);
  } catch {
    // there is not as much memory
  }
  const message = `a box of ${sizes.join(' x ')} cells has ${n_bytes} bytes, more than an array can have here`;
  throw new HexcastError('memory', message, { hint: 'read slabs', details: { bytes: n_bytes } });
}

/**
 * A box in pieces of whole planes, or of whole rows of one plane, in the order of its cells.
 *
 * @param {Cell} start
 * @param {Cell} end
 * @param {number} [rowBytes] of a row along x; a byte a cell
 * @returns {Generator<[Cell, Cell]>}
 */
export function* piecesOf([x0, y0, z0], [x1, y1, z1], rowBytes = x1 - x0) {
  const ny = y1 - y0;
  const n_rows = Math.max(1, Math.floor(SLAB_BYTES / Math.max(rowBytes, 1)));
  const n_planes = Math.max(1, Math.floor(n_rows / Math.max(ny, 1)));
  for (let z = z0; z < z1; z += n_planes) {
    const top = Math.min(z + n_planes, z1);
    for (let y = y0; y < y1; y += n_rows) {
      yield [
        [x0, y, z],
        [x1, Math.min(y + n_rows, y1), top],
      ];
    }
  }
}

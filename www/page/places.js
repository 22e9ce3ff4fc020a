/** Places in world lengths, cells that hold them, and how both are written. */
import { short } from './format.js';

/** @typedef {import('hexcast').Lines} Lines */

/** Size of the cells, which are equal: the page opens no others. @param {{ spacing: number[] | null }} lines */
export function spacingOf({ spacing }) {
  if (!spacing) throw new Error('cells differ in size, and the page shows equal ones only');
  return spacing;
}

/** The cell that holds a place; the nearest where it lies beside the mesh. @param {Lines} lines @param {number[]} place */
export function cellAt(lines, place) {
  const [{ origin, dims }, spacing] = [lines, spacingOf(lines)];
  return place.map((at, axis) => Math.min(Math.max(Math.floor((at - origin[axis]) / spacing[axis]), 0), dims[axis] - 1));
}

/** The centre of a cell. @param {Lines} lines @param {number[]} cell */
export function centreOf(lines, cell) {
  const spacing = spacingOf(lines);
  return cell.map((index, axis) => lines.origin[axis] + (index + 0.5) * spacing[axis]);
}

/** "1.5, 2, 0.25", to a thousandth of a cell. @param {number[]} place @param {{ spacing: number[] | null }} lines */
export function placeText(place, lines) {
  const spacing = spacingOf(lines);
  return place.map((number, axis) => String(Number(number.toFixed(decimals(spacing[axis]))))).join(', ');
}

/** A coordinate with six digits, or as many more as tell it from one that is so far away. @param {number} at @param {number} length */
export function endText(at, length) {
  const text = short(at);
  return Math.abs(Number(text) - at) <= 1e-4 * length ? text : String(Number(at.toFixed(decimals(length / 10))));
}

/** Decimals down to a thousandth of a cell. @param {number} size */
function decimals(size) {
  return Math.min(Math.max(Math.ceil(3 - Math.log10(size)), 0), 100);
}

/** @param {number} n @param {string} what */
export function many(n, what) {
  return `${n.toLocaleString('en')} ${what}${n === 1 ? '' : 's'}`;
}

/** @typedef {{ scale: number | number[] | null, rotate: number[] | null, translate: number[] | null }} Placing */

/**
 * The box around a box that was scaled, rotated about x, y and z, and moved, as the job does.
 *
 * @param {number[][]} box least and greatest coordinates
 * @param {Placing} placing
 */
export function placedBox([low, high], { scale, rotate, translate }) {
  const factors = [scale ?? 1, scale ?? 1, scale ?? 1].flat();
  const corners = Array.from({ length: 8 }, (_, corner) => {
    const point = [0, 1, 2].map((axis) => factors[axis] * ((corner >> axis) & 1 ? high : low)[axis]);
    return rotated(point, rotate ?? [0, 0, 0]).map((at, axis) => at + (translate?.[axis] ?? 0));
  });
  const ends = (/** @type {(...numbers: number[]) => number} */ end) =>
    [0, 1, 2].map((axis) => end(...corners.map((at) => at[axis])));
  return [ends(Math.min), ends(Math.max)];
}

/** @param {number[]} point @param {number[]} angles degrees about x, then y, then z */
function rotated(point, angles) {
  let at = point;
  for (const [axis, degrees] of angles.entries()) {
    const radians = (degrees * Math.PI) / 180;
    // right angles are exact
    const part = (/** @type {number} */ number) => (degrees % 90 === 0 ? Math.round(number) : number);
    const [cos, sin] = [part(Math.cos(radians)), part(Math.sin(radians))];
    const [first, second] = [(axis + 1) % 3, (axis + 2) % 3];
    const ends = { [axis]: at[axis], [first]: cos * at[first] - sin * at[second], [second]: sin * at[first] + cos * at[second] };
    at = [ends[0], ends[1], ends[2]];
  }
  return at;
}

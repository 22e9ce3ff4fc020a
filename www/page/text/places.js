/** Places in world lengths, cells that hold them, and how both are written. */
import { short } from './format.js';

/**
 * Lines of a mesh, of a report or of an estimate: the lists are those of cells that differ in size.
 *
 * @typedef {{ x: number[], y: number[], z: number[] }} Lists
 * @typedef {{ origin: number[], spacing: number[] | null, dims: number[], lists?: Lists | null, grading?: Lists | null }} Lines
 */

const NAMES = /** @type {const} */ (['x', 'y', 'z']);

/** The coordinate of a place counted in cells from line 0: whole numbers are lines. @param {Lines} lines @param {number} axis @param {number} cells */
export function placeAt(lines, axis, cells) {
  const { origin, spacing } = lines;
  if (spacing) return origin[axis] + cells * spacing[axis];
  const list = listOf(lines, axis);
  const cell = Math.min(Math.max(Math.floor(cells), 0), list.length - 2);
  return cells === list.length - 1 ? list[cell + 1] : list[cell] + (cells - cell) * (list[cell + 1] - list[cell]);
}

/** All lines of an axis where cells differ in size. @param {Lines} lines @param {number} axis */
export function listOf({ lists, grading }, axis) {
  return (lists ?? grading)?.[NAMES[axis]] ?? [0, 1];
}

/** Length of a cell along an axis. @param {Lines} lines @param {number} axis @param {number} cell */
export function lengthOf(lines, axis, cell) {
  return lines.spacing ? lines.spacing[axis] : placeAt(lines, axis, cell + 1) - placeAt(lines, axis, cell);
}

/** Length of the smallest cell along an axis. @param {Lines} lines @param {number} axis */
export function smallest(lines, axis) {
  if (lines.spacing) return lines.spacing[axis];
  return listOf(lines, axis).reduce(
    (least, at, index, list) => (index ? Math.min(least, at - list[index - 1]) : least),
    Infinity,
  );
}

/** The last place of a sorted list whose number is at most `at`, or 0. @param {ArrayLike<number>} list @param {number} at */
export function lastUpTo(list, at) {
  let [low, high] = [0, list.length];
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (list[middle] <= at) low = middle;
    else high = middle;
  }
  return low;
}

/** The cell that holds a place; the nearest where it lies beside the mesh. @param {Lines} lines @param {number[]} place */
export function cellAt(lines, place) {
  const { origin, spacing, dims } = lines;
  const cell = (/** @type {number} */ at, /** @type {number} */ axis) =>
    spacing ? Math.floor((at - origin[axis]) / spacing[axis]) : lastUpTo(listOf(lines, axis), at);
  return place.map((at, axis) => Math.min(Math.max(cell(at, axis), 0), dims[axis] - 1));
}

/** The centre of a cell. @param {Lines} lines @param {number[]} cell */
export function centreOf(lines, cell) {
  return cell.map((index, axis) => placeAt(lines, axis, index + 0.5));
}

/** "1.5, 2, 0.25", to a thousandth of a cell. @param {number[]} place @param {Lines} lines */
export function placeText(place, lines) {
  return place.map((number, axis) => String(Number(number.toFixed(decimals(smallest(lines, axis)))))).join(', ');
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

/** @typedef {{ scale: number | number[] | null, rotate: number[] | null, about: number[] | null, translate: number[] | null }} Placing */

/**
 * The box around a box that was scaled, rotated about x, y and z around a point, and moved, as the job does.
 *
 * @param {number[][]} box least and greatest coordinates
 * @param {Placing} placing
 */
export function placedBox([low, high], { scale, rotate, about, translate }) {
  const factors = [scale ?? 1, scale ?? 1, scale ?? 1].flat();
  const by = movedBy({ rotate, about, translate });
  const corners = Array.from({ length: 8 }, (_, corner) => {
    const point = [0, 1, 2].map((axis) => factors[axis] * ((corner >> axis) & 1 ? high : low)[axis]);
    return rotated(point, rotate ?? [0, 0, 0]).map((at, axis) => at + by[axis]);
  });
  const ends = (/** @type {(...numbers: number[]) => number} */ end) =>
    [0, 1, 2].map((axis) => end(...corners.map((at) => at[axis])));
  return [ends(Math.min), ends(Math.max)];
}

/**
 * The box around several that were placed: six numbers, the least coordinates first.
 *
 * @param {(Placing & { info: import('hexcast').FileInfo })[]} models
 */
export function boxAround(models) {
  const boxes = models.map(({ info, ...placing }) => placedBox(info.bounding_box, placing));
  const ends = (/** @type {number} */ end, /** @type {(...numbers: number[]) => number} */ of) =>
    [0, 1, 2].map((axis) => of(...boxes.map((box) => box[end][axis])));
  return [...ends(0, Math.min), ...ends(1, Math.max)];
}

/** How far what was scaled, and rotated around the origin, is moved then. @param {Omit<Placing, 'scale'>} placing */
export function movedBy({ rotate, about, translate }) {
  const centre = about ?? [0, 0, 0];
  const turned = rotated(centre, rotate ?? [0, 0, 0]);
  return [0, 1, 2].map((axis) => (translate?.[axis] ?? 0) + (centre[axis] - turned[axis]));
}

/** @param {number[]} point @param {number[]} angles degrees about x, then y, then z */
export function rotated(point, angles) {
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

/** The matrix that scales, rotates about x, y and z around a point, and moves, as the job does; by columns. @param {Placing} placing */
export function matrixOf({ scale, rotate, about, translate }) {
  const factors = [scale ?? 1, scale ?? 1, scale ?? 1].flat();
  const columns = [0, 1, 2].map((axis) => {
    const along = [0, 1, 2].map((other) => (other === axis ? factors[axis] : 0));
    return [...rotated(along, rotate ?? [0, 0, 0]), 0];
  });
  return [...columns.flat(), ...movedBy({ rotate, about, translate }), 1];
}

/** Places in world lengths, cells that hold them, and how both are written. */
/** @typedef {import('hexcast').Lines} Lines */

/** The cell that holds a place; the nearest where it lies beside the mesh. @param {Lines} lines @param {number[]} place */
export function cellAt({ origin, spacing, dims }, place) {
  return place.map((at, axis) => Math.min(Math.max(Math.floor((at - origin[axis]) / spacing[axis]), 0), dims[axis] - 1));
}

/** The centre of a cell. @param {Lines} lines @param {number[]} cell */
export function centreOf({ origin, spacing }, cell) {
  return cell.map((index, axis) => origin[axis] + (index + 0.5) * spacing[axis]);
}

/** "1.5, 2, 0.25", to a thousandth of a cell. @param {number[]} place @param {number[]} spacing */
export function placeText(place, spacing) {
  return place.map((number, axis) => String(Number(number.toFixed(decimals(spacing[axis]))))).join(', ');
}

/** Decimals down to a thousandth of a cell. @param {number} size */
function decimals(size) {
  return Math.min(Math.max(Math.ceil(3 - Math.log10(size)), 0), 100);
}

/** @param {number} n @param {string} what */
export function many(n, what) {
  return `${n.toLocaleString('en')} ${what}${n === 1 ? '' : 's'}`;
}

/** Where the cells of a slice lie on its canvas. */
import { cellAt, placeAt } from '../../text/places.js';
import { stretch } from '../stretch.js';

/**
 * @typedef {0 | 1 | 2} Axis
 * @typedef {{ slice: import('hexcast').Slice, mesh: import('hexcast').Mesh, axis: Axis, index: number, bitmap: OffscreenCanvas, differs: OffscreenCanvas | null }} Picture a slice, painted
 * @typedef {object} Pane
 * @property {HTMLCanvasElement} canvas
 * @property {Axis} axis across the slice
 * @property {number} zoom 1 where the whole plane is seen
 * @property {number[]} pan in device pixels
 * @property {Picture | null} picture the one on the screen
 */

export const AXES = ['x', 'y', 'z'];

/** The axes of the plane, in the order x, y, z. @param {Axis} axis */
export function across(axis) {
  return [0, 1, 2].filter((other) => other !== axis);
}

/**
 * Where the plane lies on the canvas, in device pixels.
 *
 * @typedef {object} Layout
 * @property {number} left
 * @property {number} top
 * @property {number} width
 * @property {number} height
 * @property {number[]} perLength pixels a length on both axes
 * @property {(sample: number) => number} x left edge of a column of samples; that of their number is the right edge of the last
 * @property {(sample: number) => number} y lower edge of a row of samples, counted upwards
 */

/** @param {Pane} pane @param {Picture} picture @returns {Layout} */
export function layout(pane, picture) {
  return picture.mesh.lines.spacing ? equalCells(pane, picture) : unequalCells(pane, picture);
}

/** @param {Pane} pane @param {Picture} picture @returns {Layout} */
function equalCells(pane, { slice, mesh, axis }) {
  const axes = across(axis);
  const samples = axes.map((at) => /** @type {number[]} */ (mesh.lines.spacing)[at] * slice.step);
  const drawn = samples.map((length, k) => length * stretch[axes[k]]);
  const room = roomFor(pane, [slice.width * drawn[0], slice.height * drawn[1]]);
  let scale = drawn.map((length) => room * length);
  // whole pixels a cell where that changes little: all cells are drawn equally wide
  if (scale[0] === scale[1] && scale[0] >= 4) scale = scale.map(Math.floor);
  const [width, height] = [scale[0] * slice.width, scale[1] * slice.height];
  const { left, top } = placed(pane, width, height);
  const [x, y] = [
    (/** @type {number} */ i) => left + i * scale[0],
    (/** @type {number} */ j) => top + (slice.height - j) * scale[1],
  ];
  return { left, top, width, height, perLength: scale.map((size, at) => size / samples[at]), x, y };
}

/** @param {Pane} pane @param {Picture} picture @returns {Layout} */
function unequalCells(pane, { slice, mesh: { lines }, axis }) {
  const [first, second] = across(axis);
  const ends = [first, second].map((at) => placeAt(lines, at, lines.dims[at]) - lines.origin[at]);
  const drawn = [ends[0] * stretch[first], ends[1] * stretch[second]];
  const room = roomFor(pane, drawn);
  const [width, height] = drawn.map((length) => Math.max(Math.round(room * length), 1));
  const { left, top } = placed(pane, width, height);
  const perLength = [width / ends[0], height / ends[1]];
  const distance = (/** @type {number} */ at, /** @type {number} */ sample) =>
    placeAt(lines, at, Math.min(sample * slice.step, lines.dims[at])) - lines.origin[at];
  const [x, y] = [
    (/** @type {number} */ i) => left + perLength[0] * distance(first, i),
    (/** @type {number} */ j) => top + height - perLength[1] * distance(second, j),
  ];
  return { left, top, width, height, perLength, x, y };
}

/** Pixels a length. @param {Pane} pane @param {number[]} size of the plane */
function roomFor({ canvas, zoom }, [width, height]) {
  return 0.94 * Math.min(canvas.width / width, canvas.height / height) * zoom;
}

/** @param {Pane} pane @param {number} width @param {number} height */
function placed({ canvas, pan }, width, height) {
  return {
    left: Math.round((canvas.width - width) / 2 + pan[0]),
    top: Math.round((canvas.height - height) / 2 + pan[1]),
  };
}

/** Where a place in world lengths lies on the canvas. @param {Pane} pane @param {Picture} picture @param {number[]} place */
export function onCanvas(pane, picture, place) {
  const { left, top, height, perLength } = layout(pane, picture);
  const { mesh, axis } = picture;
  const [x, y] = across(axis).map((at, k) => (place[at] - mesh.lines.origin[at]) * perLength[k]);
  return [left + x, top + height - y];
}

/** The cell under a point of the canvas; null beside the plane. @param {Pane} pane @param {number[]} at */
export function cellUnder(pane, [x, y]) {
  if (!pane.picture) return null;
  const { mesh, slice, axis, index } = pane.picture;
  const { left, top, width, height, perLength } = layout(pane, pane.picture);
  if (x < left || y < top || x >= left + width || y >= top + height) return null;
  const place = [0, 0, 0];
  const [first, second] = across(axis);
  place[first] = mesh.lines.origin[first] + (x - left) / perLength[0];
  place[second] = mesh.lines.origin[second] + (top + height - y) / perLength[1];
  const cell = cellAt(mesh.lines, place).map((at) => at - (at % slice.step));
  cell[axis] = index;
  return cell;
}

/** The flag of a cell of the plane shown. @param {Pane} pane @param {number[]} cell */
export function flagOf({ picture }, cell) {
  if (!picture) return 0;
  const { slice, axis } = picture;
  const [i, j] = across(axis).map((other) => Math.floor(cell[other] / slice.step));
  return slice.flags[i + slice.width * j];
}

/** Zooms about a point of the canvas, its middle by default. @param {Pane} pane @param {number} factor @param {number[]} [at] */
export function zoomBy(pane, factor, at) {
  const { canvas } = pane;
  const zoom = Math.min(Math.max(pane.zoom * factor, 1), 400);
  const from = at ? [at[0] - canvas.width / 2, at[1] - canvas.height / 2] : [0, 0];
  const real = zoom / pane.zoom;
  pane.pan = pane.pan.map((pan, k) => (zoom === 1 ? 0 : from[k] + (pan - from[k]) * real));
  pane.zoom = zoom;
  // a plane that is whole is swiped past
  canvas.style.touchAction = zoom === 1 ? 'pan-y' : 'none';
}

/** Pans so that a place can be seen. @param {Pane} pane @param {Picture} picture @param {number[]} place */
export function reveal(pane, picture, place) {
  if (pane.zoom === 1) return;
  const sizes = [pane.canvas.width, pane.canvas.height];
  const at = onCanvas(pane, picture, place);
  pane.pan = pane.pan.map((pan, k) => {
    const margin = 0.1 * sizes[k];
    return pan + Math.min(Math.max(at[k], margin), sizes[k] - margin) - at[k];
  });
}

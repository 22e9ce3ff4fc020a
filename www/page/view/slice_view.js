/** What the slice view shows, and where its cells lie on the canvas. */
import { state } from '../state/state.js';
import { cellAt, placeAt } from '../text/places.js';

/**
 * @typedef {0 | 1 | 2} Axis
 * @typedef {{ slice: import('hexcast').Slice, mesh: import('hexcast').Mesh, axis: Axis, index: number, bitmap: OffscreenCanvas, differs: OffscreenCanvas | null }} Picture
 */

export const AXES = ['x', 'y', 'z'];

/**
 * The plane shown, the last plane of each axis, the zoom, and the cell of the cursor.
 *
 * @type {{ axis: Axis, index: number[], zoom: number, pan: number[], cursor: number[] | null, picture: Picture | null }}
 *   `picture` is the slice on the screen, painted
 */
export const view = { axis: 2, index: [0, 0, 0], zoom: 1, pan: [0, 0], cursor: null, picture: null };

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

/** @param {HTMLCanvasElement} canvas @param {Picture} picture @returns {Layout} */
export function layout(canvas, picture) {
  return picture.mesh.lines.spacing ? equalCells(canvas, picture) : unequalCells(canvas, picture);
}

/** @param {HTMLCanvasElement} canvas @param {Picture} picture @returns {Layout} */
function equalCells(canvas, { slice, mesh, axis }) {
  const samples = across(axis).map((at) => /** @type {number[]} */ (mesh.lines.spacing)[at] * slice.step);
  const room = roomFor(canvas, [slice.width * samples[0], slice.height * samples[1]]);
  let scale = samples.map((length) => room * length);
  // whole pixels a cell where that changes little: all cells are drawn equally wide
  if (scale[0] === scale[1] && scale[0] >= 4) scale = scale.map(Math.floor);
  const [width, height] = [scale[0] * slice.width, scale[1] * slice.height];
  const { left, top } = placed(canvas, width, height);
  const [x, y] = [
    (/** @type {number} */ i) => left + i * scale[0],
    (/** @type {number} */ j) => top + (slice.height - j) * scale[1],
  ];
  return { left, top, width, height, perLength: scale.map((size, at) => size / samples[at]), x, y };
}

/** @param {HTMLCanvasElement} canvas @param {Picture} picture @returns {Layout} */
function unequalCells(canvas, { slice, mesh: { lines }, axis }) {
  const [first, second] = across(axis);
  const ends = [first, second].map((at) => placeAt(lines, at, lines.dims[at]) - lines.origin[at]);
  const room = roomFor(canvas, ends);
  const [width, height] = ends.map((length) => Math.max(Math.round(room * length), 1));
  const { left, top } = placed(canvas, width, height);
  const perLength = [width / ends[0], height / ends[1]];
  const distance = (/** @type {number} */ at, /** @type {number} */ sample) =>
    placeAt(lines, at, Math.min(sample * slice.step, lines.dims[at])) - lines.origin[at];
  const [x, y] = [
    (/** @type {number} */ i) => left + perLength[0] * distance(first, i),
    (/** @type {number} */ j) => top + height - perLength[1] * distance(second, j),
  ];
  return { left, top, width, height, perLength, x, y };
}

/** Pixels a length. @param {HTMLCanvasElement} canvas @param {number[]} size of the plane */
function roomFor(canvas, [width, height]) {
  return 0.94 * Math.min(canvas.width / width, canvas.height / height) * view.zoom;
}

/** @param {HTMLCanvasElement} canvas @param {number} width @param {number} height */
function placed(canvas, width, height) {
  return {
    left: Math.round((canvas.width - width) / 2 + view.pan[0]),
    top: Math.round((canvas.height - height) / 2 + view.pan[1]),
  };
}

/** Where a place in world lengths lies on the canvas. @param {HTMLCanvasElement} canvas @param {Picture} picture @param {number[]} place */
export function onCanvas(canvas, picture, place) {
  const { left, top, height, perLength } = layout(canvas, picture);
  const { mesh, axis } = picture;
  const [x, y] = across(axis).map((at, k) => (place[at] - mesh.lines.origin[at]) * perLength[k]);
  return [left + x, top + height - y];
}

/** The cell under a point of the canvas; null beside the plane. @param {HTMLCanvasElement} canvas @param {number[]} at */
export function cellUnder(canvas, [x, y]) {
  if (!view.picture) return null;
  const { mesh, slice, axis, index } = view.picture;
  const { left, top, width, height, perLength } = layout(canvas, view.picture);
  if (x < left || y < top || x >= left + width || y >= top + height) return null;
  const place = [0, 0, 0];
  const [first, second] = across(axis);
  place[first] = mesh.lines.origin[first] + (x - left) / perLength[0];
  place[second] = mesh.lines.origin[second] + (top + height - y) / perLength[1];
  const cell = cellAt(mesh.lines, place).map((at) => at - (at % slice.step));
  cell[axis] = index;
  return cell;
}

/** The flag of a cell of the plane shown. @param {number[]} cell */
export function flagOf(cell) {
  if (!view.picture) return 0;
  const { slice, axis } = view.picture;
  const [i, j] = across(axis).map((other) => Math.floor(cell[other] / slice.step));
  return slice.flags[i + slice.width * j];
}

/** Zooms about a point of the canvas, its middle by default. @param {HTMLCanvasElement} canvas @param {number} factor @param {number[]} [at] */
export function zoomBy(canvas, factor, at) {
  const zoom = Math.min(Math.max(view.zoom * factor, 1), 400);
  const from = at ? [at[0] - canvas.width / 2, at[1] - canvas.height / 2] : [0, 0];
  const real = zoom / view.zoom;
  view.pan = view.pan.map((pan, k) => (zoom === 1 ? 0 : from[k] + (pan - from[k]) * real));
  view.zoom = zoom;
  // a plane that is whole is swiped past
  canvas.style.touchAction = zoom === 1 ? 'pan-y' : 'none';
}

export function resetZoom() {
  view.zoom = 1;
  view.pan = [0, 0];
}

/** The plane of the mesh in state, if it is the one painted. */
export function currentPicture() {
  return view.picture?.mesh === state.mesh ? view.picture : null;
}

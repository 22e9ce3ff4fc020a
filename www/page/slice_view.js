/** What the slice view shows, and where its cells lie on the canvas. */
import { state } from './state.js';
import { spacingOf } from './places.js';

/**
 * @typedef {0 | 1 | 2} Axis
 * @typedef {{ slice: import('hexcast').Slice, mesh: import('hexcast').Mesh, axis: Axis, index: number, bitmap: OffscreenCanvas }} Picture
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
 * Where the plane lies on the canvas, in device pixels: left, top, and pixels a sample on both axes.
 *
 * @param {HTMLCanvasElement} canvas
 * @param {Picture} picture
 */
export function layout(canvas, { slice, mesh, axis }) {
  const [first, second] = across(axis);
  const spacing = spacingOf(mesh.lines);
  const size = [slice.width * slice.step * spacing[first], slice.height * slice.step * spacing[second]];
  const room = 0.94 * Math.min(canvas.width / size[0], canvas.height / size[1]) * view.zoom;
  let scale = [room * spacing[first] * slice.step, room * spacing[second] * slice.step];
  // whole pixels a cell where that changes little: all cells are drawn equally wide
  if (scale[0] === scale[1] && scale[0] >= 4) scale = scale.map(Math.floor);
  const left = Math.round((canvas.width - scale[0] * slice.width) / 2 + view.pan[0]);
  const top = Math.round((canvas.height - scale[1] * slice.height) / 2 + view.pan[1]);
  return { left, top, scale };
}

/** Where a place in world lengths lies on the canvas. @param {HTMLCanvasElement} canvas @param {Picture} picture @param {number[]} place */
export function onCanvas(canvas, picture, place) {
  const { left, top, scale } = layout(canvas, picture);
  const { slice, mesh, axis } = picture;
  const spacing = spacingOf(mesh.lines);
  const [i, j] = across(axis).map((at) => (place[at] - mesh.lines.origin[at]) / (spacing[at] * slice.step));
  return [left + i * scale[0], top + (slice.height - j) * scale[1]];
}

/** The cell under a point of the canvas; null beside the plane. @param {HTMLCanvasElement} canvas @param {number[]} at */
export function cellUnder(canvas, [x, y]) {
  if (!view.picture) return null;
  const { slice, axis, index } = view.picture;
  const { left, top, scale } = layout(canvas, view.picture);
  const i = Math.floor((x - left) / scale[0]);
  const j = slice.height - 1 - Math.floor((y - top) / scale[1]);
  if (i < 0 || j < 0 || i >= slice.width || j >= slice.height) return null;
  const cell = [0, 0, 0];
  const [first, second] = across(axis);
  [cell[axis], cell[first], cell[second]] = [index, i * slice.step, j * slice.step];
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

/** Draws a slice: cells, mesh lines, the marks of findings, the path of a leak, the cursor. */
import { canvasOf, byId, inputOf } from '../elements/dom.js';
import { cellAt, centreOf, lengthOf } from '../text/places.js';
import { state } from '../state/state.js';
import { markCells } from './slice_difference.js';
import { AXES, across, currentPicture, layout, onCanvas, view } from './slice_view.js';

/** @typedef {import('./slice_view.js').Picture} Picture @typedef {import('./slice_view.js').Layout} Layout */

/** Mesh lines are drawn where a cell has at least so many pixels. */
const LINE_PIXELS = 4;
/** CSS pixels. */
const RING_RADIUS = 9;

/** Draws what the view shows. */
export function drawSlice() {
  const canvas = canvasOf('canvas-slice');
  const ratio = devicePixelRatio || 1;
  const { clientWidth, clientHeight } = /** @type {HTMLElement} */ (canvas.parentElement);
  if (clientWidth === 0) return;
  canvas.width = Math.round(clientWidth * ratio);
  canvas.height = Math.round(clientHeight * ratio);
  const picture = currentPicture();
  const context = canvas.getContext('2d');
  if (!picture || !context) return;
  const where = drawCells(canvas, context, picture, ratio);
  drawPath(canvas, context, picture, ratio);
  const n_marks = drawMarks(canvas, context, picture, ratio);
  drawCursor(canvas, context, picture, ratio);
  // where the cells are on the canvas, for tests
  const { slice, axis, index } = picture;
  const { left, top, width, height } = where;
  Object.assign(canvas.dataset, {
    axis: AXES[axis],
    index,
    left,
    top,
    scaleX: width / slice.width,
    scaleY: height / slice.height,
  });
  Object.assign(canvas.dataset, { width: slice.width, height: slice.height, marks: n_marks, zoom: view.zoom });
}

/** @param {HTMLCanvasElement} canvas @param {CanvasRenderingContext2D} context @param {Picture} picture @param {number} ratio */
function drawCells(canvas, context, picture, ratio) {
  const { slice, bitmap, differs } = picture;
  const where = layout(canvas, picture);
  const { left, top, width, height } = where;
  const style = getComputedStyle(canvas);
  context.fillStyle = style.getPropertyValue('--cells-background');
  context.fillRect(left, top, width, height);
  context.imageSmoothingEnabled = false;
  const cover = (
    /** @type {CanvasRenderingContext2D | OffscreenCanvasRenderingContext2D} */ on,
    /** @type {OffscreenCanvas} */ of,
  ) => (picture.mesh.lines.spacing ? on.drawImage(of, left, top, width, height) : drawUnequal(on, where, of));
  cover(context, bitmap);
  if (differs) markCells(context, (layer) => cover(layer, differs), ratio, narrowest(where, slice));
  if (inputOf('mesh-lines').checked && slice.step === 1) drawLines(context, where, slice, style.getPropertyValue('--cells-line'));
  context.lineWidth = 1;
  context.strokeStyle = style.getPropertyValue('--cells-edge');
  context.strokeRect(left + 0.5, top + 0.5, width - 1, height - 1);
  const notes = [
    slice.step > 1 ? `1 of every ${slice.step} cells on each axis is drawn` : '',
    differs ? `marked cells differ from ${state.difference?.file}` : '',
  ];
  byId('slice-note').textContent = notes.filter(Boolean).join(', ');
  return where;
}

/** Samples of different sizes: first columns, then rows, each as wide as it is. @param {CanvasRenderingContext2D | OffscreenCanvasRenderingContext2D} context @param {Layout} where @param {OffscreenCanvas} bitmap */
function drawUnequal(context, { x, y }, bitmap) {
  const { width, height } = context.canvas;
  const columns = new OffscreenCanvas(width, bitmap.height);
  const within = columns.getContext('2d');
  if (!within) return;
  within.imageSmoothingEnabled = false;
  for (let i = 0; i < bitmap.width; i += 1) {
    const [from, to] = [Math.round(x(i)), Math.round(x(i + 1))];
    if (to > Math.max(from, 0) && from < width)
      within.drawImage(bitmap, i, 0, 1, bitmap.height, from, 0, to - from, bitmap.height);
  }
  for (let j = 0; j < bitmap.height; j += 1) {
    const [from, to] = [Math.round(y(j + 1)), Math.round(y(j))];
    // rows of the bitmap are downwards
    if (to > Math.max(from, 0) && from < height)
      context.drawImage(columns, 0, bitmap.height - 1 - j, width, 1, 0, from, width, to - from);
  }
}

/** Pixels of the smallest cell. @param {Layout} where @param {import('hexcast').Slice} slice */
function narrowest({ x, y }, slice) {
  const least = (/** @type {number} */ n, /** @type {(cell: number) => number} */ at) =>
    Array.from({ length: n }, (_, cell) => Math.abs(at(cell + 1) - at(cell))).reduce((one, other) => Math.min(one, other));
  return Math.min(least(slice.width, x), least(slice.height, y));
}

/** Lines beside cells that are large enough. @param {CanvasRenderingContext2D} context @param {Layout} where @param {import('hexcast').Slice} slice @param {string} colour */
function drawLines(context, { left, top, width, height, x, y }, slice, colour) {
  const seen = context.canvas;
  context.beginPath();
  for (const at of wideEnough(slice.width, x, seen.width)) {
    context.moveTo(at, Math.max(0, top));
    context.lineTo(at, Math.min(seen.height, top + height));
  }
  for (const at of wideEnough(slice.height, y, seen.height)) {
    context.moveTo(Math.max(0, left), at);
    context.lineTo(Math.min(seen.width, left + width), at);
  }
  context.strokeStyle = colour;
  context.lineWidth = 1;
  context.stroke();
}

/** Where lines are drawn: in the middle of pixels, of cells with at least so many. @param {number} n cells @param {(cell: number) => number} place @param {number} seen */
function wideEnough(n, place, seen) {
  const at = Array.from({ length: n + 1 }, (_, line) => place(line));
  const isWide = (/** @type {number} */ cell) => cell >= 0 && cell < n && Math.abs(at[cell + 1] - at[cell]) >= LINE_PIXELS;
  const isDrawn = (/** @type {number} */ line) => (isWide(line - 1) || isWide(line)) && at[line] >= 0 && at[line] <= seen;
  return at.filter((_, line) => isDrawn(line)).map((line) => Math.round(line) + 0.5);
}

/** The path of the leak: what lies in the plane as a line, the rest of it dashed. @param {HTMLCanvasElement} canvas @param {CanvasRenderingContext2D} context @param {Picture} picture @param {number} ratio */
function drawPath(canvas, context, picture, ratio) {
  const path = state.leak?.path;
  if (!path) return;
  const { axis, index } = picture;
  const points = path.points.map((place) => onCanvas(canvas, picture, place));
  context.strokeStyle = getComputedStyle(canvas).getPropertyValue('--mark');
  for (let at = 1; at < points.length; at += 1) {
    const isIn = path.cells[at - 1][axis] === index && path.cells[at][axis] === index;
    context.lineWidth = (isIn ? 3 : 1.5) * ratio;
    context.setLineDash(isIn ? [] : [3 * ratio, 4 * ratio]);
    context.beginPath();
    context.moveTo(points[at - 1][0], points[at - 1][1]);
    context.lineTo(points[at][0], points[at][1]);
    context.stroke();
  }
  context.setLineDash([]);
}

/** Rings at the findings in the plane; returns how many. @param {HTMLCanvasElement} canvas @param {CanvasRenderingContext2D} context @param {Picture} picture @param {number} ratio */
function drawMarks(canvas, context, picture, ratio) {
  const { mesh, axis, index } = picture;
  const style = getComputedStyle(canvas);
  let n_marks = 0;
  for (const [at, { place }] of state.findings.entries()) {
    if (!place || cellAt(mesh.lines, place)[axis] !== index) continue;
    const isCurrent = at === state.finding;
    const [x, y] = onCanvas(canvas, picture, place);
    context.beginPath();
    context.arc(x, y, (isCurrent ? RING_RADIUS : 0.65 * RING_RADIUS) * ratio, 0, 2 * Math.PI);
    for (const [width, colour] of /** @type {[number, string][]} */ ([
      [5, '--mark-edge'],
      [3, isCurrent ? '--mark' : '--mark-other'],
    ])) {
      context.lineWidth = width * ratio;
      context.strokeStyle = style.getPropertyValue(colour);
      context.stroke();
    }
    n_marks += 1;
  }
  return n_marks;
}

/** The edges of the cell that the cursor is in. @param {HTMLCanvasElement} canvas @param {CanvasRenderingContext2D} context @param {Picture} picture @param {number} ratio */
function drawCursor(canvas, context, picture, ratio) {
  const { cursor } = view;
  if (!cursor) return;
  const [{ perLength }, { lines }] = [layout(canvas, picture), picture.mesh];
  const [x, y] = onCanvas(canvas, picture, centreOf(lines, cursor));
  const [width, height] = across(picture.axis).map((axis, k) =>
    Math.max(lengthOf(lines, axis, cursor[axis]) * perLength[k], 6 * ratio),
  );
  context.lineWidth = 2 * ratio;
  context.strokeStyle = getComputedStyle(canvas).getPropertyValue('--ink');
  context.strokeRect(x - width / 2, y - height / 2, width, height);
}

/** Pans so that a cell can be seen. @param {number[]} cell */
export function bringIntoView(cell) {
  const canvas = canvasOf('canvas-slice');
  const picture = currentPicture();
  if (!picture || view.zoom === 1) return;
  const sizes = [canvas.width, canvas.height];
  const at = onCanvas(canvas, picture, centreOf(picture.mesh.lines, cell));
  view.pan = view.pan.map((pan, k) => {
    const margin = 0.1 * sizes[k];
    return pan + Math.min(Math.max(at[k], margin), sizes[k] - margin) - at[k];
  });
}

/** The first or second axis of the plane and the direction that an arrow key points to. @param {string} key */
export function arrow(key) {
  const [first, second] = across(view.axis);
  return { ArrowLeft: [first, -1], ArrowRight: [first, 1], ArrowDown: [second, -1], ArrowUp: [second, 1] }[key];
}

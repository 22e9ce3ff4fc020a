/** Draws a slice: cells, mesh lines, the marks of findings, the path of a leak, what is measured, the crosshair. */
import { inputOf } from '../../elements/dom.js';
import { cellAt, centreOf, lengthOf } from '../../text/places.js';
import { state } from '../../state/state.js';
import { crosshair } from '../crosshair.js';
import { measured } from '../measure.js';
import { areFour } from '../panes.js';
import { markCells } from './slice_difference.js';
import { AXES, across, layout, onCanvas } from './slice_layout.js';

/** @typedef {import('./slice_layout.js').Picture} Picture @typedef {import('./slice_layout.js').Layout} Layout @typedef {import('./slice_layout.js').Pane} Pane */

/** Mesh lines are drawn where a cell has at least so many pixels. */
const LINE_PIXELS = 4;
/** CSS pixels. */
const RING_RADIUS = 9;

/** Gives the canvas the size of its stage, and draws what the pane shows. @param {Pane} pane @returns {Layout | null} where the cells are, if there are any */
export function drawSlice(pane) {
  const { canvas, picture, zoom } = pane;
  const ratio = devicePixelRatio || 1;
  const { clientWidth, clientHeight } = /** @type {HTMLElement} */ (canvas.parentElement);
  if (clientWidth === 0) return null;
  canvas.width = Math.round(clientWidth * ratio);
  canvas.height = Math.round(clientHeight * ratio);
  const context = canvas.getContext('2d');
  if (!picture || picture.mesh !== state.mesh || !context) return null;
  const where = drawCells(pane, context, picture, ratio);
  drawPath(pane, context, picture, ratio);
  const n_marks = drawMarks(pane, context, picture, ratio);
  drawMeasured(pane, context, picture, ratio);
  if (crosshair.isPicked || areFour()) drawCrosshair(pane, context, picture, ratio);
  // where the cells are on the canvas, for tests
  const { slice, axis, index } = picture;
  const { left, top, width, height } = where;
  const [scaleX, scaleY] = [width / slice.width, height / slice.height];
  Object.assign(canvas.dataset, { axis: AXES[axis], index, left, top, scaleX, scaleY });
  Object.assign(canvas.dataset, { width: slice.width, height: slice.height, marks: n_marks, zoom });
  return where;
}

/** @param {Pane} pane @param {CanvasRenderingContext2D} context @param {Picture} picture @param {number} ratio */
function drawCells(pane, context, picture, ratio) {
  const { slice, bitmap, differs } = picture;
  const where = layout(pane, picture);
  const { left, top, width, height } = where;
  const style = getComputedStyle(pane.canvas);
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

/** The path of the leak: what lies in the plane as a line, the rest of it dashed. @param {Pane} pane @param {CanvasRenderingContext2D} context @param {Picture} picture @param {number} ratio */
function drawPath(pane, context, picture, ratio) {
  const path = state.leak?.path;
  if (!path) return;
  const { axis, index } = picture;
  const points = path.points.map((place) => onCanvas(pane, picture, place));
  context.strokeStyle = getComputedStyle(pane.canvas).getPropertyValue('--mark');
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

/** Rings at the findings in the plane; returns how many. @param {Pane} pane @param {CanvasRenderingContext2D} context @param {Picture} picture @param {number} ratio */
function drawMarks(pane, context, picture, ratio) {
  const { mesh, axis, index } = picture;
  const style = getComputedStyle(pane.canvas);
  let n_marks = 0;
  for (const [at, { place }] of state.findings.entries()) {
    if (!place || cellAt(mesh.lines, place)[axis] !== index) continue;
    const isCurrent = at === state.finding;
    const [x, y] = onCanvas(pane, picture, place);
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

/** The centres of the cells that are measured, and the line between them, as they are seen across the plane. @param {Pane} pane @param {CanvasRenderingContext2D} context @param {Picture} picture @param {number} ratio */
function drawMeasured(pane, context, picture, ratio) {
  const points = measured().map((place) => onCanvas(pane, picture, place));
  const style = getComputedStyle(pane.canvas);
  for (const [width, name] of /** @type {[number, string][]} */ ([
    [4, '--mark-edge'],
    [2, '--measure'],
  ])) {
    context.lineWidth = width * ratio;
    context.strokeStyle = style.getPropertyValue(name);
    context.beginPath();
    for (const [x, y] of points) {
      context.moveTo(x + 4 * ratio, y);
      context.arc(x, y, 4 * ratio, 0, 2 * Math.PI);
    }
    if (points.length === 2) line(context, points[0][0], points[0][1], points[1][0], points[1][1]);
    context.stroke();
  }
}

/** Lines through the cell of the crosshair, and its edges where it lies in the plane. @param {Pane} pane @param {CanvasRenderingContext2D} context @param {Picture} picture @param {number} ratio */
function drawCrosshair(pane, context, picture, ratio) {
  const { cell } = crosshair;
  const [{ left, top, width, height, perLength }, { lines }] = [layout(pane, picture), picture.mesh];
  const [x, y] = onCanvas(pane, picture, centreOf(lines, cell));
  const sizes = across(picture.axis).map((axis, k) => Math.max(lengthOf(lines, axis, cell[axis]) * perLength[k], 6 * ratio));
  const half = sizes.map((size) => size / 2);
  context.beginPath();
  for (const [from, to] of [
    [left, x - half[0]],
    [x + half[0], left + width],
  ])
    if (from < to) line(context, from, y, to, y);
  for (const [from, to] of [
    [top, y - half[1]],
    [y + half[1], top + height],
  ])
    if (from < to) line(context, x, from, x, to);
  // seen on dark and on light
  for (const [width, name] of /** @type {[number, string][]} */ ([
    [3, '--mark-edge'],
    [1, '--cross'],
  ])) {
    context.lineWidth = width * ratio;
    context.strokeStyle = getComputedStyle(pane.canvas).getPropertyValue(name);
    context.globalAlpha = width > 1 ? 0.35 : 1;
    context.stroke();
  }
  context.globalAlpha = 1;
  if (cell[picture.axis] !== picture.index) return;
  context.lineWidth = 2 * ratio;
  context.strokeStyle = getComputedStyle(pane.canvas).getPropertyValue('--ink');
  context.strokeRect(x - half[0], y - half[1], sizes[0], sizes[1]);
}

/** @param {CanvasRenderingContext2D} context @param {number} x0 @param {number} y0 @param {number} x1 @param {number} y1 */
function line(context, x0, y0, x1, y1) {
  context.moveTo(x0, y0);
  context.lineTo(x1, y1);
}

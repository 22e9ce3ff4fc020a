/** Draws a slice: cells, mesh lines, the marks of findings, the path of a leak, the cursor. */
import { canvasOf, byId, inputOf } from './dom.js';
import { cellAt, centreOf } from './places.js';
import { state } from './state.js';
import { AXES, across, currentPicture, layout, onCanvas, view } from './slice_view.js';

/** @typedef {import('./slice_view.js').Picture} Picture */

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
  const where = drawCells(canvas, context, picture);
  drawPath(canvas, context, picture, ratio);
  const n_marks = drawMarks(canvas, context, picture, ratio);
  drawCursor(canvas, context, picture, ratio);
  // where the cells are on the canvas, for tests
  const { slice, axis, index } = picture;
  const { left, top, scale } = where;
  Object.assign(canvas.dataset, { axis: AXES[axis], index, left, top, scaleX: scale[0], scaleY: scale[1] });
  Object.assign(canvas.dataset, { width: slice.width, height: slice.height, marks: n_marks, zoom: view.zoom });
}

/** @param {HTMLCanvasElement} canvas @param {CanvasRenderingContext2D} context @param {Picture} picture */
function drawCells(canvas, context, picture) {
  const { slice, bitmap } = picture;
  const where = layout(canvas, picture);
  const { left, top, scale } = where;
  const style = getComputedStyle(canvas);
  context.fillStyle = style.getPropertyValue('--cells-background');
  const [width, height] = [scale[0] * slice.width, scale[1] * slice.height];
  context.fillRect(left, top, width, height);
  context.imageSmoothingEnabled = false;
  context.drawImage(bitmap, left, top, width, height);
  if (inputOf('mesh-lines').checked && Math.min(...scale) >= LINE_PIXELS && slice.step === 1) {
    drawLines(context, { left, top, scale, slice }, style.getPropertyValue('--cells-line'));
  }
  context.lineWidth = 1;
  context.strokeStyle = style.getPropertyValue('--cells-edge');
  context.strokeRect(left + 0.5, top + 0.5, width - 1, height - 1);
  byId('slice-note').textContent = slice.step > 1 ? `every ${slice.step}th cell is drawn` : '';
  return where;
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {ReturnType<typeof layout> & { slice: import('hexcast').Slice }} where
 * @param {string} colour
 */
function drawLines(context, { left, top, scale, slice }, colour) {
  const { width, height } = context.canvas;
  context.beginPath();
  for (let i = Math.max(0, Math.floor(-left / scale[0])); i <= slice.width && left + i * scale[0] <= width; i += 1) {
    const x = Math.round(left + i * scale[0]) + 0.5;
    context.moveTo(x, Math.max(0, top));
    context.lineTo(x, Math.min(height, top + slice.height * scale[1]));
  }
  for (let j = Math.max(0, Math.floor(-top / scale[1])); j <= slice.height && top + j * scale[1] <= height; j += 1) {
    const y = Math.round(top + j * scale[1]) + 0.5;
    context.moveTo(Math.max(0, left), y);
    context.lineTo(Math.min(width, left + slice.width * scale[0]), y);
  }
  context.strokeStyle = colour;
  context.lineWidth = 1;
  context.stroke();
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
  if (!view.cursor) return;
  const { scale } = layout(canvas, picture);
  const [x, y] = onCanvas(canvas, picture, centreOf(picture.mesh.lines, view.cursor));
  const [width, height] = scale.map((size) => Math.max(size / picture.slice.step, 6 * ratio));
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

/** The pointer and the cursor of the slice view: they zoom, pan, name cells and pick them. */
import { byId, canvasOf } from '../elements/dom.js';
import { cellText } from '../text/cell_facts.js';
import { cellAt, placeAt } from '../text/places.js';
import { state } from '../state/state.js';
import { arrow, bringIntoView } from './slice_draw.js';
import { cellUnder, currentPicture, flagOf, view, zoomBy } from './slice_view.js';

/** Pixels that a finger may move in a tap. */
const TAP = 6;

/** Receives the cell that is picked next. @type {((cell: number[]) => void) | null} */
let picker = null;

/** Lets the next click, tap or Enter pick a cell; null ends that. @param {((cell: number[]) => void) | null} listener */
export function pickNext(listener) {
  picker = listener;
  canvasOf('canvas-slice').classList.toggle('picking', listener !== null);
}

/** @param {MouseEvent} event */
const at = (event) => [event.offsetX * devicePixelRatio, event.offsetY * devicePixelRatio];
/** @param {number[]} a @param {number[]} b */
const distance = (a, b) => Math.hypot(a[0] - b[0], a[1] - b[1]);

/** Connects the pointers. @param {HTMLCanvasElement} canvas @param {() => void} draw */
export function startPointers(canvas, draw) {
  /** Pointers that are down: where they are, and where they began. @type {Map<number, { now: number[], start: number[] }>} */
  const down = new Map();
  const wheel = (/** @type {WheelEvent} */ event) => {
    event.preventDefault();
    zoomBy(canvas, 2 ** (-event.deltaY / 300), at(event));
    draw();
  };
  canvas.addEventListener('wheel', wheel, { passive: false });
  canvas.addEventListener('pointerdown', (event) => {
    canvas.setPointerCapture(event.pointerId);
    down.set(event.pointerId, { now: at(event), start: at(event) });
  });
  canvas.addEventListener('pointermove', (event) => {
    const now = at(event);
    const pointer = down.get(event.pointerId);
    if (pointer) {
      drag(canvas, pointer.now, now, [...down.values()].find((other) => other !== pointer)?.now);
      pointer.now = now;
      draw();
    }
    nameCell(cellUnder(canvas, now), 'off');
  });
  canvas.addEventListener('pointerup', (event) => {
    const pointer = down.get(event.pointerId);
    const isTap = down.size === 1 && pointer && distance(at(event), pointer.start) <= TAP * devicePixelRatio;
    down.delete(event.pointerId);
    if (isTap) put(cellUnder(canvas, at(event)));
    if (isTap) draw();
  });
  canvas.addEventListener('pointercancel', (event) => down.delete(event.pointerId));
  // a finger that is lifted leaves the name of its cell
  canvas.addEventListener('pointerleave', ({ pointerType }) => pointerType === 'mouse' && nameCell(view.cursor, 'off'));
}

/** One pointer pans, two zoom. @param {HTMLCanvasElement} canvas @param {number[]} before @param {number[]} now @param {number[]} [other] */
function drag(canvas, before, now, other) {
  if (other) zoomBy(canvas, distance(now, other) / Math.max(distance(before, other), 1), other);
  else if (view.zoom > 1) view.pan = view.pan.map((pan, k) => pan + now[k] - before[k]);
}

/** Puts the cursor on a cell, and picks that where one is to be picked. @param {number[] | null} cell */
function put(cell) {
  if (!cell) return;
  view.cursor = cell;
  nameCell(cell, 'polite');
  pick();
}

function pick() {
  if (!view.cursor || !picker) return;
  const listener = picker;
  pickNext(null);
  listener(view.cursor);
}

/** Moves the cursor by an arrow key, or picks its cell with Enter; whether the key was one of these. @param {KeyboardEvent} event */
export function moveCursor({ key, shiftKey }) {
  const picture = currentPicture();
  if (!picture) return false;
  const step = shiftKey ? arrow(key) : undefined;
  if (!step && key !== 'Enter') return false;
  const { lines } = picture.mesh;
  if (!view.cursor) view.cursor = cellAt(lines, middle(lines));
  else if (step) {
    const [axis, by] = step;
    view.cursor = view.cursor.map((at, k) => (k === axis ? Math.min(Math.max(at + by, 0), lines.dims[axis] - 1) : at));
  }
  view.cursor[view.axis] = view.index[view.axis];
  bringIntoView(view.cursor);
  nameCell(view.cursor, 'polite');
  if (key === 'Enter') pick();
  return true;
}

/** @param {import('hexcast').Lines} lines */
function middle(lines) {
  return lines.origin.map((start, axis) => (start + placeAt(lines, axis, lines.dims[axis])) / 2);
}

/** The cursor follows the plane. */
export function followPlane() {
  if (!view.cursor) return;
  view.cursor[view.axis] = view.index[view.axis];
  nameCell(view.cursor, 'off');
}

/** Says a cell, its place and its flag. @param {number[] | null} cell @param {'off' | 'polite'} live */
function nameCell(cell, live) {
  const output = byId('slice-cell');
  const { mesh } = state;
  output.ariaLive = live;
  if (!cell || !mesh) {
    output.textContent = '';
    return;
  }
  output.textContent = cellText(mesh, cell, flagOf(cell));
}

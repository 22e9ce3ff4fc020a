/**
 * The pointers of a slice: they name the cell below them; a press and a drag move the crosshair, a wheel and two fingers zoom, and a drag
 * with Shift or another button pans.
 */
import { crosshair, moveTo } from '../crosshair.js';
import { picked } from '../pick.js';
import { nameCell } from '../readout.js';
import { cellUnder, flagOf, zoomBy } from './slice_layout.js';

/** @typedef {import('./slice_layout.js').Pane} Pane */
/** @typedef {{ now: number[], start: number[], moves: 'crosshair' | 'plane' | 'nothing' }} Pointer where it is, and began, and what its drag moves */

/** Pixels that a finger may move in a tap. */
const TAP = 6;

/** @param {MouseEvent} event */
const at = (event) => [event.offsetX * devicePixelRatio, event.offsetY * devicePixelRatio];
/** @param {number[]} a @param {number[]} b */
const distance = (a, b) => Math.hypot(a[0] - b[0], a[1] - b[1]);

/** Connects the pointers. @param {Pane} pane @param {() => void} draw */
export function startPointers(pane, draw) {
  const { canvas } = pane;
  /** @type {Map<number, Pointer>} */
  const down = new Map();
  const wheel = (/** @type {WheelEvent} */ event) => {
    event.preventDefault();
    zoomBy(pane, 2 ** (-event.deltaY / 300), at(event));
    draw();
  };
  canvas.addEventListener('wheel', wheel, { passive: false });
  canvas.addEventListener('contextmenu', (event) => event.preventDefault());
  canvas.addEventListener('pointerdown', (event) => {
    canvas.setPointerCapture(event.pointerId);
    down.set(event.pointerId, { now: at(event), start: at(event), moves: movedBy(event, pane.zoom) });
    if (movedBy(event, pane.zoom) === 'crosshair') put(pane, at(event));
  });
  canvas.addEventListener('pointermove', (event) => {
    const now = at(event);
    const pointer = down.get(event.pointerId);
    if (pointer) {
      const other = [...down.values()].find((one) => one !== pointer);
      if (other) zoomBy(pane, distance(now, other.now) / Math.max(distance(pointer.now, other.now), 1), other.now);
      else if (pointer.moves === 'crosshair') put(pane, now);
      else if (pointer.moves === 'plane' && pane.zoom > 1) pane.pan = pane.pan.map((pan, k) => pan + now[k] - pointer.now[k]);
      pointer.now = now;
      draw();
    }
    name(pane, cellUnder(pane, now));
  });
  canvas.addEventListener('pointerup', (event) => {
    const pointer = down.get(event.pointerId);
    const isAlone = down.size === 1;
    down.delete(event.pointerId);
    if (!pointer || !isAlone) return;
    const isTap = event.button === 0 && !event.shiftKey && distance(at(event), pointer.start) <= TAP * devicePixelRatio;
    if (!isTap && pointer.moves !== 'crosshair') return;
    const cell = isTap ? put(pane, at(event)) : crosshair.cell;
    if (!cell) return;
    name(pane, cell, 'polite');
    picked(cell);
  });
  canvas.addEventListener('pointercancel', (event) => down.delete(event.pointerId));
  // a finger that is lifted leaves the name of its cell
  canvas.addEventListener('pointerleave', ({ pointerType }) => pointerType === 'mouse' && nameCell(null));
}

/** What a drag moves: fingers swipe past a plane that is whole. @param {PointerEvent} event @param {number} zoom @returns {Pointer['moves']} */
function movedBy({ pointerType, button, shiftKey, ctrlKey, metaKey }, zoom) {
  if (pointerType === 'touch') return zoom > 1 ? 'plane' : 'nothing';
  return button !== 0 || shiftKey || ctrlKey || metaKey ? 'plane' : 'crosshair';
}

/** Puts the crosshair on the cell under a point, and returns it. @param {Pane} pane @param {number[]} point */
function put(pane, point) {
  const cell = cellUnder(pane, point);
  if (cell) moveTo(cell, { isPicked: true, from: pane });
  return cell;
}

/** @param {Pane} pane @param {number[] | null} cell @param {'off' | 'polite'} [live] */
function name(pane, cell, live = 'off') {
  nameCell(cell, cell ? flagOf(pane, cell) : 0, live);
}

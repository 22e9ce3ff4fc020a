/** The crosshair: one cell, which all panes show. Each slice is the plane through it. */
import { lookOf, offerLook, takeNumbers } from '../settings/looks.js';
import { change, on, state } from '../state/state.js';
import { cellAt, centreOf, placeAt } from '../text/places.js';

/**
 * `cell` is where it is. `place` is where somebody put it, in world lengths: there it stays, whatever cells the next mesh has; null in the
 * middle. `isPicked` says whether somebody pointed at the cell, and did not only move a plane; `from` is the pane in which that was.
 * `isElsewhere` says whether the mesh does not hold the place that the crosshair had in the mesh before.
 *
 * @type {{ cell: number[], place: number[] | null, isPicked: boolean, from: object | null, isElsewhere: boolean }}
 */
export const crosshair = { cell: [0, 0, 0], place: null, isPicked: false, from: null, isElsewhere: true };

/** Keeps the crosshair at its place in each mesh. Starts before the views do. */
export function startCrosshair() {
  /** Of the last mesh. @type {import('hexcast').Lines | null} */
  let lines = null;
  on('mesh', () => {
    const { mesh } = state;
    const before = lines && (crosshair.place ?? centreOf(lines, crosshair.cell));
    lines = mesh?.lines ?? null;
    crosshair.isElsewhere = !mesh || !before || !holds(mesh.lines, before);
    if (crosshair.isElsewhere) Object.assign(crosshair, { place: null, isPicked: false });
    if (!mesh) return;
    crosshair.place = takeNumbers('at', 3) ?? crosshair.place;
    put(crosshair.place ? cellAt(mesh.lines, crosshair.place) : mesh.dims.map((n) => Math.floor(n / 2)));
  });
  offerLook('at', () => (crosshair.place ? lookOf(crosshair.place) : ''));
}

/** Whether a place is in the box of some lines. @param {import('hexcast').Lines} of @param {number[]} place */
function holds(of, place) {
  return place.every((at, axis) => at >= of.origin[axis] && at < placeAt(of, axis, of.dims[axis]));
}

/** @param {number[]} cell @param {object | null} [from] */
function put(cell, from = null) {
  Object.assign(crosshair, { cell, from });
  change('crosshair');
  change('look');
}

/**
 * Moves it to a cell, or to the nearest that there is.
 *
 * @param {number[]} cell
 * @param {{ isPicked?: boolean, from?: object }} [how]
 */
export function moveTo(cell, { isPicked = false, from } = {}) {
  if (!state.mesh) return;
  const { lines, dims } = state.mesh;
  const inside = cell.map((at, axis) => Math.min(Math.max(at, 0), dims[axis] - 1));
  const centre = centreOf(lines, inside);
  crosshair.place = (crosshair.place ?? centre).map((at, axis) => (inside[axis] === crosshair.cell[axis] ? at : centre[axis]));
  crosshair.isPicked ||= isPicked;
  put(inside, from);
}

/** Moves it to a place in world lengths. @param {number[]} place */
export function showPlace(place) {
  if (!state.mesh) return;
  crosshair.place = [...place];
  put(cellAt(state.mesh.lines, place));
}

/** Slices across x, y and z: crisp cells, mesh lines, zoom, keys. */
import { byId, canvasOf, inputOf, onInput, oncePerFrame } from '../elements/dom.js';
import { save } from '../downloads/downloads.js';
import { short } from '../text/format.js';
import { showError } from '../elements/messages.js';
import { paint } from './flag_pixels.js';
import { cellAt, centreOf, placeAt } from '../text/places.js';
import { lookOf, offerLook, takeNumbers } from '../settings/looks.js';
import { baseName } from '../settings/share.js';
import { followPlane, moveCursor, startPointers } from './slice_cursor.js';
import { maskBitmap } from './slice_difference.js';
import { drawSlice } from './slice_draw.js';
import { AXES, resetZoom, view, zoomBy } from './slice_view.js';
import { change, on, state } from '../state/state.js';

/** @typedef {import('./slice_view.js').Axis} Axis */

/** Most pixels a side that a slice is requested with: screens have no more. */
const MAX_PIXELS = 4096;
/** Pixels of the longest side of the mesh in pictures that are saved. */
const SAVED_PIXELS = 1200;

let request = 0;
/** Lines of the mesh that is shown. @type {import('hexcast').Lines | null} */
let lines = null;
/** Where planes were put, in world lengths: there they stay, whatever cells the next mesh has. Null in the middle. @type {number[] | null} */
let asked = null;
const draw = oncePerFrame(drawSlice);

/** Connects the view. */
export function startSlices() {
  on('mesh', () => {
    const { mesh } = state;
    const place = lines && (asked ?? centreOf(lines, view.index));
    if (!mesh || !place || !holds(mesh.lines, place)) {
      asked = null;
      resetZoom();
    }
    lines = mesh?.lines ?? null;
    takePlane();
    if (mesh) view.index = asked ? cellAt(mesh.lines, asked) : middleOf(mesh);
    view.cursor = null;
    load();
  });
  on(['colours', 'legend'], () => {
    repaint();
    draw();
  });
  on('findings', draw);
  on('difference', () => state.mesh && load());
  for (const [axis, name] of AXES.entries())
    byId(`slice-${name}`).addEventListener('change', () => cross(/** @type {Axis} */ (axis)));
  onInput('slice-at', 'input', ({ value }) => go(Number(value)));
  onInput('slice-number', 'input', ({ value }) => value !== '' && go(Number(value)));
  onInput('slice-number', 'change', (input) => {
    input.value = String(view.index[view.axis]);
  });
  byId('mesh-lines').addEventListener('change', draw);
  byId('zoom-in').addEventListener('click', () => zoom(1.5));
  byId('zoom-out').addEventListener('click', () => zoom(1 / 1.5));
  byId('zoom-fit').addEventListener('click', fit);
  byId('save-slice').addEventListener('click', savePicture);
  byId('save-slice-view').addEventListener('click', saveView);
  const canvas = canvasOf('canvas-slice');
  startPointers(canvas, draw);
  canvas.addEventListener('keydown', moveByKey);
  offerLook('slice', () => {
    const { axis, index } = view;
    if (!lines || (axis === 2 && !asked)) return '';
    return lookOf([axis, ...(asked ?? centreOf(lines, index))]);
  });
  new ResizeObserver(draw).observe(/** @type {HTMLElement} */ (canvas.parentElement));
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', draw);
}

/** The planes in the middle. @param {{ dims: number[] }} of */
function middleOf({ dims }) {
  return dims.map((n) => Math.floor(n / 2));
}

/** The planes of a link. */
function takePlane() {
  const [axis, ...place] = takeNumbers('slice', 4) ?? [];
  if (!lines || ![0, 1, 2].includes(axis)) return;
  view.axis = /** @type {Axis} */ (axis);
  inputOf(`slice-${AXES[axis]}`).checked = true;
  asked = place;
}

/** Whether a place is in the box of some lines. @param {import('hexcast').Lines} of @param {number[]} place */
function holds(of, place) {
  return place.every((at, axis) => at >= of.origin[axis] && at < placeAt(of, axis, of.dims[axis]));
}

/** @param {number} factor */
function zoom(factor) {
  zoomBy(canvasOf('canvas-slice'), factor);
  draw();
}

function fit() {
  resetZoom();
  draw();
}

/** Shows planes across another axis. @param {Axis} axis */
function cross(axis) {
  view.axis = axis;
  resetZoom();
  load();
}

/** @param {number} index */
function go(index) {
  if (!state.mesh) return;
  const { axis } = view;
  view.index[axis] = Math.min(Math.max(Math.round(index) || 0, 0), state.mesh.dims[axis] - 1);
  const centre = centreOf(state.mesh.lines, view.index);
  asked = (asked ?? centre).map((at, other) => (other === axis ? centre[other] : at));
  load();
}

/** Moves the planes of all axes to a place in world lengths. @param {number[]} place */
export function showPlace(place) {
  if (!state.mesh) return;
  asked = [...place];
  view.index = cellAt(state.mesh.lines, asked);
  resetZoom();
  load();
}

/** Puts the cursor on a cell, and moves the planes there. @param {number[]} cell */
export function showCell(cell) {
  if (!state.mesh) return;
  view.cursor = [...cell];
  showPlace(centreOf(state.mesh.lines, cell));
}

/** Requests the plane; an earlier request that is still running is ignored. */
async function load() {
  const { mesh } = state;
  byId('slices-empty').hidden = Boolean(mesh);
  /** @type {HTMLFieldSetElement} */ (byId('slices-tools')).disabled = !mesh;
  byId('canvas-slice').tabIndex = mesh ? 0 : -1;
  if (!mesh) return draw();
  const { axis } = view;
  const index = view.index[axis];
  change('look');
  showPlane(mesh, axis, index);
  const mine = ++request;
  try {
    const planes = [mesh, state.difference?.mask].map((of) => of?.slice(axis, index, MAX_PIXELS));
    const [slice, mask] = await Promise.all(planes);
    if (mine !== request || !slice) return undefined;
    const [bitmap, differs] = [new OffscreenCanvas(slice.width, slice.height), mask ? maskBitmap(mask) : null];
    view.picture = { slice, mesh, axis, index, bitmap, differs };
    followPlane();
    repaint();
    draw();
  } catch (error) {
    if (mine === request) showError(error);
  }
  return undefined;
}

/** Writes which plane it is. @param {import('hexcast').Mesh} mesh @param {Axis} axis @param {number} index */
function showPlane(mesh, axis, index) {
  const [slider, number] = [inputOf('slice-at'), inputOf('slice-number')];
  slider.max = number.max = String(mesh.dims[axis] - 1);
  slider.value = String(index);
  if (number !== document.activeElement) number.value = String(index);
  const centre = placeAt(mesh.lines, axis, index + 0.5);
  slider.setAttribute('aria-valuetext', `cell ${index} of ${mesh.dims[axis]}, ${AXES[axis]} = ${short(centre)}`);
  byId('slice-where').textContent = `${AXES[axis]} = ${short(centre)}${mesh.report.unit ? ` ${mesh.report.unit}` : ''}`;
}

function repaint() {
  const { picture } = view;
  picture?.bitmap.getContext('2d')?.putImageData(paint(picture.slice, state.hidden), 0, 0);
}

/** @param {KeyboardEvent} event */
function moveByKey(event) {
  if (!state.mesh || event.ctrlKey || event.metaKey || event.altKey) return;
  const here = view.index[view.axis];
  /** @type {Record<string, number>} */
  const steps = {
    ArrowLeft: -1,
    ArrowDown: -1,
    ArrowRight: 1,
    ArrowUp: 1,
    PageUp: 10,
    PageDown: -10,
    Home: -here,
    End: Infinity,
  };
  if (moveCursor(event)) draw();
  else if (event.key in steps) go(Math.min(here + steps[event.key], state.mesh.dims[view.axis]));
  else if (AXES.includes(event.key)) byId(`slice-${event.key}`).click();
  else if (event.key === '+' || event.key === '=') zoom(1.5);
  else if (event.key === '-') zoom(1 / 1.5);
  else if (event.key === '0') fit();
  else return;
  event.preventDefault();
}

/** Saves the whole plane with its legend, as the command draws it, in the colours of the page. */
async function savePicture() {
  if (!view.picture) return;
  const { mesh, axis, index } = view.picture;
  const { hidden, colours } = state;
  const shown = [0, ...mesh.report.flags.map(({ flag }) => flag)].filter((flag) => !hidden.has(flag));
  try {
    const picture = await mesh.slice({
      axis: /** @type {'x' | 'y' | 'z'} */ (AXES[axis]),
      at: placeAt(mesh.lines, axis, index + 0.5),
      size: SAVED_PIXELS,
      lines: inputOf('mesh-lines').checked,
      colours: Object.fromEntries(colours),
      ...(hidden.size > 0 ? { flags: shown } : {}),
    });
    save(picture, `${baseName(state.job)}-${AXES[axis]}${index}.png`);
  } catch (error) {
    showError(error);
  }
}

/** Saves what the screen shows: zoomed in, with marks. */
function saveView() {
  if (!view.picture) return;
  const { axis, index } = view.picture;
  const name = `${baseName(state.job)}-${AXES[axis]}${index}-view.png`;
  canvasOf('canvas-slice').toBlob((blob) => blob && save(blob, name), 'image/png');
}

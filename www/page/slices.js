/** Slices across x, y and z: crisp cells, mesh lines, zoom, keys. */
import { byId, canvasOf, inputOf, onInput, oncePerFrame } from './dom.js';
import { save } from './downloads.js';
import { short } from './format.js';
import { showError } from './messages.js';
import { paint } from './paint.js';
import { baseName } from './share.js';
import { on, state } from './state.js';

/**
 * @typedef {0 | 1 | 2} Axis
 * @typedef {{ slice: import('hexcast').Slice, mesh: import('hexcast').Mesh, axis: Axis, index: number, bitmap: OffscreenCanvas }} Picture
 */

const AXES = ['x', 'y', 'z'];
/** Mesh lines are drawn where a cell has at least so many pixels. */
const LINE_PIXELS = 4;
/** Most pixels a side that a slice is requested with: screens have no more. */
const MAX_PIXELS = 4096;

/** The plane shown, and the last plane of each axis. */
/** @type {{ axis: Axis, index: number[], zoom: number, pan: number[] }} */
const view = { axis: 2, index: [0, 0, 0], zoom: 1, pan: [0, 0] };
/** The slice on the screen, painted. */
let picture = /** @type {Picture | null} */ (null);
let request = 0;
const draw = oncePerFrame(drawNow);
/** The element that the canvas fills. */
const canvasFrame = () => /** @type {HTMLElement} */ (byId('canvas-slice').parentElement);

/** Connects the view. */
export function startSlices() {
  on('mesh', () => {
    view.index = state.mesh ? state.mesh.dims.map((n) => Math.floor(n / 2)) : [0, 0, 0];
    resetZoom();
    load();
  });
  on(['colours', 'legend'], () => {
    repaint();
    draw();
  });
  for (const [axis, name] of AXES.entries())
    byId(`slice-${name}`).addEventListener('change', () => cross(/** @type {Axis} */ (axis)));
  onInput('slice-at', 'input', ({ value }) => go(Number(value)));
  onInput('slice-number', 'input', ({ value }) => value !== '' && go(Number(value)));
  onInput('slice-number', 'change', (input) => {
    input.value = String(view.index[view.axis]);
  });
  byId('mesh-lines').addEventListener('change', draw);
  byId('zoom-in').addEventListener('click', () => zoomBy(1.5));
  byId('zoom-out').addEventListener('click', () => zoomBy(1 / 1.5));
  byId('zoom-fit').addEventListener('click', fit);
  byId('save-slice').addEventListener('click', savePicture);
  startPointer(canvasOf('canvas-slice'));
  byId('canvas-slice').addEventListener('keydown', moveByKey);
  new ResizeObserver(draw).observe(canvasFrame());
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', draw);
}

function resetZoom() {
  view.zoom = 1;
  view.pan = [0, 0];
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
  const last = state.mesh.dims[view.axis] - 1;
  view.index[view.axis] = Math.min(Math.max(Math.round(index) || 0, 0), last);
  load();
}

/** Requests the plane; an earlier request that is still running is ignored. */
async function load() {
  const { mesh } = state;
  byId('slices-empty').hidden = Boolean(mesh);
  /** @type {HTMLFieldSetElement} */ (byId('slices-tools')).disabled = !mesh;
  byId('canvas-slice').tabIndex = mesh ? 0 : -1;
  if (!mesh) return;
  const { axis } = view;
  const index = view.index[axis];
  const [slider, number] = [inputOf('slice-at'), inputOf('slice-number')];
  slider.max = number.max = String(mesh.dims[axis] - 1);
  slider.value = String(index);
  if (number !== document.activeElement) number.value = String(index);
  const centre = mesh.lines.origin[axis] + (index + 0.5) * mesh.lines.spacing[axis];
  slider.setAttribute('aria-valuetext', `cell ${index} of ${mesh.dims[axis]}, ${AXES[axis]} = ${short(centre)}`);
  byId('slice-where').textContent = `${AXES[axis]} = ${short(centre)}${mesh.report.unit ? ` ${mesh.report.unit}` : ''}`;
  const mine = ++request;
  try {
    const slice = await mesh.slice(axis, index, MAX_PIXELS);
    if (mine !== request) return;
    picture = { slice, mesh, axis, index, bitmap: new OffscreenCanvas(slice.width, slice.height) };
    repaint();
    draw();
  } catch (error) {
    if (mine === request) showError(error);
  }
}

function repaint() {
  picture?.bitmap.getContext('2d')?.putImageData(paint(picture.slice, { isUp: true, hidden: state.hidden }), 0, 0);
}

/** The axes of the plane, in the order x, y, z. @param {Axis} axis */
function across(axis) {
  return [0, 1, 2].filter((other) => other !== axis);
}

/**
 * Where the plane lies on the canvas, in device pixels: left, top, and pixels a sample on both axes.
 *
 * @param {HTMLCanvasElement} canvas
 * @param {Picture} picture
 */
function layout(canvas, { slice, mesh, axis }) {
  const [first, second] = across(axis);
  const size = [slice.width * slice.step * mesh.lines.spacing[first], slice.height * slice.step * mesh.lines.spacing[second]];
  const room = 0.94 * Math.min(canvas.width / size[0], canvas.height / size[1]) * view.zoom;
  let scale = [room * mesh.lines.spacing[first] * slice.step, room * mesh.lines.spacing[second] * slice.step];
  // whole pixels a cell where that changes little: all cells are drawn equally wide
  if (scale[0] === scale[1] && scale[0] >= 4) scale = scale.map(Math.floor);
  const left = Math.round((canvas.width - scale[0] * slice.width) / 2 + view.pan[0]);
  const top = Math.round((canvas.height - scale[1] * slice.height) / 2 + view.pan[1]);
  return { left, top, scale };
}

function drawNow() {
  const canvas = canvasOf('canvas-slice');
  const ratio = devicePixelRatio || 1;
  const { clientWidth, clientHeight } = canvasFrame();
  if (clientWidth === 0) return;
  canvas.width = Math.round(clientWidth * ratio);
  canvas.height = Math.round(clientHeight * ratio);
  if (!picture || picture.mesh !== state.mesh) return;
  const { slice, bitmap, axis, index } = picture;
  const { left, top, scale } = layout(canvas, picture);
  const context = canvas.getContext('2d');
  if (!context) return;
  const style = getComputedStyle(canvas);
  context.fillStyle = style.getPropertyValue('--cells-background');
  const [width, height] = [scale[0] * slice.width, scale[1] * slice.height];
  context.fillRect(left, top, width, height);
  context.imageSmoothingEnabled = false;
  context.drawImage(bitmap, left, top, width, height);
  if (inputOf('mesh-lines').checked && Math.min(...scale) >= LINE_PIXELS && slice.step === 1) {
    drawLines(context, { left, top, scale, slice }, style.getPropertyValue('--cells-line'));
  }
  context.strokeStyle = style.getPropertyValue('--cells-edge');
  context.strokeRect(left + 0.5, top + 0.5, width - 1, height - 1);
  byId('slice-note').textContent = slice.step > 1 ? `every ${slice.step}th cell is drawn` : '';
  // where the cells are on the canvas, for tests
  Object.assign(canvas.dataset, {
    axis: AXES[axis],
    index,
    left,
    top,
    scaleX: scale[0],
    scaleY: scale[1],
    width: slice.width,
    height: slice.height,
  });
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

/** Zooms about a point of the canvas, its middle by default. @param {number} factor @param {number[]} [at] */
function zoomBy(factor, at) {
  const canvas = canvasOf('canvas-slice');
  const zoom = Math.min(Math.max(view.zoom * factor, 1), 400);
  const from = at ? [at[0] - canvas.width / 2, at[1] - canvas.height / 2] : [0, 0];
  const real = zoom / view.zoom;
  view.pan = view.pan.map((pan, k) => (zoom === 1 ? 0 : from[k] + (pan - from[k]) * real));
  view.zoom = zoom;
  draw();
}

/** @param {HTMLCanvasElement} canvas */
function startPointer(canvas) {
  const at = (/** @type {MouseEvent} */ event) => [event.offsetX * devicePixelRatio, event.offsetY * devicePixelRatio];
  const turn = (/** @type {WheelEvent} */ event) => {
    event.preventDefault();
    zoomBy(2 ** (-event.deltaY / 300), at(event));
  };
  canvas.addEventListener('wheel', turn, { passive: false });
  canvas.addEventListener('pointerdown', (event) => canvas.setPointerCapture(event.pointerId));
  canvas.addEventListener('pointermove', (event) => {
    if (event.buttons & 1 && view.zoom > 1) {
      view.pan = [view.pan[0] + event.movementX * devicePixelRatio, view.pan[1] + event.movementY * devicePixelRatio];
      draw();
    }
    nameCell(canvas, at(event));
  });
  canvas.addEventListener('pointerleave', () => (byId('slice-cell').textContent = ''));
}

/** Names the cell under the pointer. @param {HTMLCanvasElement} canvas @param {number[]} at */
function nameCell(canvas, [x, y]) {
  if (!picture) return;
  const { slice, mesh, axis, index } = picture;
  const { left, top, scale } = layout(canvas, picture);
  const i = Math.floor((x - left) / scale[0]);
  const j = slice.height - 1 - Math.floor((y - top) / scale[1]);
  const isInside = i >= 0 && j >= 0 && i < slice.width && j < slice.height;
  if (!isInside) {
    byId('slice-cell').textContent = '';
    return;
  }
  const cell = [0, 0, 0];
  const [first, second] = across(axis);
  [cell[axis], cell[first], cell[second]] = [index, i * slice.step, j * slice.step];
  const flag = slice.flags[i + slice.width * j];
  const name = mesh.report.flags.find((entry) => entry.flag === flag)?.name;
  byId('slice-cell').textContent =
    `cell ${cell.join(', ')}: ${flag === 0 ? 'background' : `flag ${flag}${name ? `, ${name}` : ''}`}`;
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
  if (event.key in steps) go(Math.min(here + steps[event.key], state.mesh.dims[view.axis]));
  else if (AXES.includes(event.key)) byId(`slice-${event.key}`).click();
  else if (event.key === '+' || event.key === '=') zoomBy(1.5);
  else if (event.key === '-') zoomBy(1 / 1.5);
  else if (event.key === '0') fit();
  else return;
  event.preventDefault();
}

function savePicture() {
  if (!picture) return;
  const { axis, index } = picture;
  canvasOf('canvas-slice').toBlob((blob) => blob && save(blob, `${baseName(state.job)}-${AXES[axis]}${index}.png`), 'image/png');
}

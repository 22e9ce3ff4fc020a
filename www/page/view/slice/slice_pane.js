/** A slice: the plane of cells through the crosshair across one axis, with its tools. */
import { byId, inTurn, inputOf, oncePerFrame } from '../../elements/dom.js';
import { save } from '../../downloads/downloads.js';
import { baseName } from '../../settings/share.js';
import { showError } from '../../elements/messages.js';
import { short } from '../../text/format.js';
import { centreOf, placeAt } from '../../text/places.js';
import { state } from '../../state/state.js';
import { crosshair, moveTo } from '../crosshair.js';
import { paint } from '../flag_pixels.js';
import { Gauges } from '../gauges.js';
import { areFour, isShown, showPanes } from '../panes.js';
import { picked } from '../pick.js';
import { nameCell } from '../readout.js';
import { maskBitmap } from './slice_difference.js';
import { drawSlice } from './slice_draw.js';
import { AXES, across, flagOf, reveal, zoomBy } from './slice_layout.js';
import { startPointers } from './slice_pointers.js';

/** @typedef {import('./slice_layout.js').Axis} Axis @typedef {import('./slice_layout.js').Picture} Picture */

/** Most pixels a side that a slice is requested with: screens have no more. */
const MAX_PIXELS = 4096;
/** Pixels of the longest side of the mesh in pictures that are saved. */
const SAVED_PIXELS = 1200;

/** @typedef {import("./slice_layout.js").Pane} Pane */

/** @implements {Pane} */
export class SlicePane {
  zoom = 1;
  pan = [0, 0];
  /** @type {Picture | null} */
  picture = null;
  /** Which mesh, difference and plane was asked for last. @type {unknown[]} */
  #asked = [];

  /** @param {Axis} axis */
  constructor(axis) {
    this.axis = axis;
    const name = AXES[axis];
    this.root = byId(`pane-${name}`);
    const template = /** @type {HTMLTemplateElement} */ (byId('slice-pane'));
    this.root.append(template.content.cloneNode(true));
    const [one, other] = across(axis).map((at) => AXES[at]);
    for (const element of this.root.querySelectorAll('[data-id]'))
      element.id = `${/** @type {HTMLElement} */ (element).dataset.id}-${name}`;
    this.#of('tools').setAttribute('aria-label', `Slice ${one}${other}`);
    this.#of('name').textContent = `${one}${other}`;
    this.slider = inputOf(`at-${name}`);
    this.number = inputOf(`plane-${name}`);
    this.slider.ariaLabel = `Plane across ${name}`;
    this.number.ariaLabel = `Number of the plane across ${name}`;
    this.canvas = /** @type {HTMLCanvasElement} */ (byId(`canvas-${name}`));
    this.canvas.ariaLabel = `Slice ${one}${other}, a plane of cells across ${name}; arrow keys move it, plus and minus zoom, Shift and an arrow key move the crosshair from cell to cell, Enter inspects its cell`;
    this.gauges = new Gauges(/** @type {HTMLElement} */ (this.canvas.parentElement));
    this.draw = oncePerFrame(() => this.#draw());
    this.load = inTurn(() => this.#load());
    this.#listen();
  }

  /** @param {string} what */
  #of(what) {
    return byId(`${what}-${AXES[this.axis]}`);
  }

  #listen() {
    const on = (/** @type {string} */ what, /** @type {string} */ event, /** @type {() => void} */ act) =>
      this.#of(what).addEventListener(event, act);
    on('at', 'input', () => this.#go(Number(this.slider.value)));
    on('plane', 'input', () => this.number.value !== '' && this.#go(Number(this.number.value)));
    on('plane', 'change', () => {
      this.number.value = String(crosshair.cell[this.axis]);
    });
    on('zoom-in', 'click', () => this.#zoom(1.5));
    on('zoom-out', 'click', () => this.#zoom(1 / 1.5));
    on('zoom-fit', 'click', () => this.fit());
    on('save', 'click', () => this.#savePicture());
    on('save-view', 'click', () => this.#saveView());
    startPointers(this, this.draw);
    this.canvas.addEventListener('keydown', (event) => this.#key(event));
    new ResizeObserver(this.draw).observe(/** @type {HTMLElement} */ (this.canvas.parentElement));
  }

  /** @param {number} factor */
  #zoom(factor) {
    zoomBy(this, factor);
    this.draw();
  }

  fit() {
    zoomBy(this, 0);
    this.draw();
  }

  /** Moves the plane. @param {number} index */
  #go(index) {
    moveTo(crosshair.cell.map((at, axis) => (axis === this.axis ? Math.round(index) || 0 : at)));
  }

  /** Shows the plane of the crosshair, if the pane is seen. */
  follow() {
    const { mesh, difference } = state;
    this.#of('empty').hidden = Boolean(mesh);
    /** @type {HTMLFieldSetElement} */ (this.#of('tools')).disabled = !mesh;
    this.canvas.tabIndex = mesh ? 0 : -1;
    if (!mesh) return;
    this.#say(mesh);
    if (!isShown(/** @type {'x'} */ (AXES[this.axis]))) return;
    const asked = [mesh, difference, crosshair.cell[this.axis]];
    if (asked.some((one, at) => one !== this.#asked[at])) this.load();
    this.#asked = asked;
    if (this.picture?.mesh === mesh && crosshair.from !== this) reveal(this, this.picture, centreOf(mesh.lines, crosshair.cell));
    this.draw();
  }

  /** Writes which plane it is. @param {import('hexcast').Mesh} mesh */
  #say(mesh) {
    const { axis, slider, number } = this;
    const index = crosshair.cell[axis];
    slider.max = number.max = String(mesh.dims[axis] - 1);
    slider.value = String(index);
    if (number !== document.activeElement) number.value = String(index);
    const where = `${AXES[axis]} = ${short(placeAt(mesh.lines, axis, index + 0.5))}`;
    slider.ariaValueText = `cell ${index} of ${mesh.dims[axis]}, ${where}`;
    this.#of('where').textContent = `${where}${mesh.report.unit ? ` ${mesh.report.unit}` : ''}`;
  }

  /** Requests the plane; of all that are asked for meanwhile only the last is requested then. */
  async #load() {
    const { mesh, difference } = state;
    if (!mesh) return;
    const index = crosshair.cell[this.axis];
    try {
      const planes = [mesh, difference?.mask].map((of) => of?.slice(this.axis, index, MAX_PIXELS));
      const [slice, mask] = await Promise.all(planes);
      if (mesh !== state.mesh || !slice) return;
      const [bitmap, differs] = [new OffscreenCanvas(slice.width, slice.height), mask ? maskBitmap(mask) : null];
      this.picture = { slice, mesh, axis: this.axis, index, bitmap, differs };
      this.repaint();
      const { cell, isPicked } = crosshair;
      if (isPicked && cell[this.axis] === index) nameCell(cell, flagOf(this, cell));
    } catch (error) {
      if (mesh === state.mesh) showError(error);
    }
  }

  /** Paints the cells anew, such as in other colours. */
  repaint() {
    const { picture } = this;
    picture?.bitmap.getContext('2d')?.putImageData(paint(picture.slice, state.hidden), 0, 0);
    this.draw();
  }

  #draw() {
    const where = drawSlice(this);
    const { picture } = this;
    const notes = [
      picture && picture.slice.step > 1 ? `1 of every ${picture.slice.step} cells on each axis is drawn` : '',
      picture?.differs ? `marked cells differ from ${state.difference?.file}` : '',
    ];
    this.#of('note').textContent = notes.filter(Boolean).join(', ');
    this.gauges.showPlane(where && { axes: across(this.axis), perLength: where.perLength });
  }

  /** @param {KeyboardEvent} event */
  #key(event) {
    const { key } = event;
    if (!state.mesh || event.ctrlKey || event.metaKey || event.altKey) return;
    const here = crosshair.cell[this.axis];
    /** @type {Record<string, number>} */
    const steps = {
      ArrowLeft: -1,
      ArrowDown: -1,
      ArrowRight: 1,
      ArrowUp: 1,
      PageUp: 10,
      PageDown: -10,
      Home: -here,
      End: 2 ** 32,
    };
    if (event.shiftKey && this.#arrow(key)) this.#step(/** @type {[number, number]} */ (this.#arrow(key)));
    else if (key === 'Enter') this.#pick();
    else if (key in steps) this.#go(here + steps[key]);
    else if (AXES.includes(key)) {
      if (!areFour()) showPanes(/** @type {'x'} */ (key));
      byId(`canvas-${key}`).focus();
    } else if (key === '+' || key === '=') this.#zoom(1.5);
    else if (key === '-') this.#zoom(1 / 1.5);
    else if (key === '0') this.fit();
    else return;
    event.preventDefault();
  }

  /** The axis of the plane and the direction that an arrow key points to. @param {string} key */
  #arrow(key) {
    const [first, second] = across(this.axis);
    return { ArrowLeft: [first, -1], ArrowRight: [first, 1], ArrowDown: [second, -1], ArrowUp: [second, 1] }[key];
  }

  /** Moves the crosshair in the plane. @param {[number, number]} step axis and cells */
  #step([axis, by]) {
    moveTo(
      crosshair.cell.map((at, k) => (k === axis ? at + by : at)),
      { isPicked: true },
    );
    nameCell(crosshair.cell, flagOf(this, crosshair.cell), 'polite');
  }

  #pick() {
    moveTo(crosshair.cell, { isPicked: true });
    nameCell(crosshair.cell, flagOf(this, crosshair.cell), 'polite');
    picked(crosshair.cell);
  }

  /** Saves the whole plane with its legend, as the command draws it, in the colours of the page. */
  async #savePicture() {
    if (!this.picture) return;
    const { mesh, axis, index } = this.picture;
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
  #saveView() {
    if (!this.picture) return;
    const { axis, index } = this.picture;
    const name = `${baseName(state.job)}-${AXES[axis]}${index}-view.png`;
    this.canvas.toBlob((blob) => blob && save(blob, name), 'image/png');
  }
}

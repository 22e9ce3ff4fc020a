/**
 * The 3-D scene as the page has it: a camera, and a worker that draws. Everything is told to the worker; nothing waits for it.
 *
 * World lengths may be far from zero, so the worker draws relative to the centre of what was fitted.
 */
import { oncePerFrame } from '../elements/dom.js';
import { boxAround, matrixOf } from '../text/places.js';
import { Camera } from './camera.js';
import { startOrbit } from './orbit.js';
import { minus, plus, times, unit } from './vectors.js';

/**
 * @typedef {import('./cast/cells.js').Cut} Cut
 * @typedef {import('../text/places.js').Placing} Placing
 * @typedef {Placing & { corners: Float32Array, colour: string, isOpen: boolean }} Model open where the edges of its corners are to be drawn
 * @typedef {{ n: number, isWhole: boolean, cells: number, step: number }} Drawn a picture: its number, whether it is whole, of the cells of which
 *   mesh it is, and how many cells of that along an edge are the smallest that can be drawn
 * @typedef {{ failed: (message?: string) => void, drawn: (picture: Drawn) => void, looked: (sight: import('./camera.js').Sight) => void,
 *   pick: (x: number, y: number) => void, hover: (x: number, y: number) => void }} Listener
 * @typedef {{ cell: number[], flag: number, axis: number, step: number }} Picked a cell, and the axis of its face; `step` cells along an edge
 */

/** How long the camera flies to a place. */
const FLIGHT_SECONDS = 0.6;
/** Pixels of a CSS pixel, at most. */
const MOST_RATIO = 2;
/** From where boxes are seen at first. */
const CORNER = [1.1, -1.6, 0.9];

export class Scene {
  #frame;
  #worker;
  #camera = new Camera();
  /** Numbers of the corners that the worker has. @type {WeakMap<Float32Array, number>} */
  #sent = new WeakMap();
  #n_sent = 0;
  /** Questions that wait for an answer. @type {Map<number, (answer: any) => void>} */
  #asked = new Map();
  #n_asked = 0;
  #box = '';
  /** Meshes whose cells were told to the worker. */
  n_meshes = 0;
  /** Counts the moves of the camera: one in flight ends where another begins. */
  #moves = 0;
  /** Messages that the worker got. */
  #n_told = 0;
  /** @type {HTMLCanvasElement} */
  #canvas;
  /** @type {Listener['looked']} */
  #looked;

  /**
   * @param {HTMLCanvasElement} canvas
   * @param {Listener} listener
   */
  constructor(canvas, { failed, drawn, looked, pick, hover }) {
    this.#canvas = canvas;
    this.#looked = looked;
    this.#frame = /** @type {HTMLElement} */ (canvas.parentElement);
    const offscreen = canvas.transferControlToOffscreen();
    this.#worker = new Worker(new URL('./cast/draw_worker.js', import.meta.url), { type: 'module', name: 'picture' });
    this.#worker.addEventListener('error', () => failed());
    this.#worker.addEventListener('message', ({ data }) => {
      if (data.kind === 'failed') failed(data.message);
      else if (data.kind === 'drawn') drawn(data);
      else if (data.kind === 'rest') canvas.dataset.atRest = String(data.heard === this.#n_told);
      else this.#answer(data.id, data.answer);
    });
    this.#tell('open', { canvas: offscreen }, [offscreen]);
    this.invalidate = oncePerFrame(() => this.#look());
    startOrbit(canvas, {
      turn: (around, up) => this.turn(around, up),
      zoom: (factor, place) => this.#moved(() => this.#camera.zoom(factor, place)),
      pan: (x, y) => this.#moved(() => this.#camera.pan(x, y)),
      pick,
      hover,
    });
    new ResizeObserver(() => this.#resize()).observe(this.#frame);
    this.#resize();
  }

  /** @param {string} kind @param {object} message @param {Transferable[]} [transfer] */
  #tell(kind, message, transfer = []) {
    this.#n_told += 1;
    this.#canvas.dataset.atRest = 'false';
    this.#worker.postMessage({ kind, ...message }, transfer);
  }

  /** @param {string} kind @param {object} message @returns {Promise<any>} */
  #ask(kind, message) {
    const id = ++this.#n_asked;
    return new Promise((resolve) => {
      this.#asked.set(id, resolve);
      this.#tell(kind, { id, ...message });
    });
  }

  /** @param {number} id @param {unknown} answer */
  #answer(id, answer) {
    this.#asked.get(id)?.(answer);
    this.#asked.delete(id);
  }

  #resize() {
    const { clientWidth, clientHeight } = this.#frame;
    if (clientWidth === 0 || clientHeight === 0) return;
    const ratio = Math.min(devicePixelRatio, MOST_RATIO);
    this.#tell('size', { width: Math.round(clientWidth * ratio), height: Math.round(clientHeight * ratio), ratio });
    this.#camera.setAspect(clientWidth / clientHeight);
    this.#look();
  }

  #look() {
    const sight = this.#camera.sight();
    this.#tell('shown', { shown: { sight } });
    this.#looked(sight);
  }

  /** @param {() => void} move */
  #moved(move) {
    this.#moves += 1;
    move();
    this.invalidate();
  }

  /** Shows models. @param {Model[]} models */
  setModels(models) {
    const told = models.map(({ corners, colour, isOpen, ...placing }) => {
      const isNew = !this.#sent.has(corners);
      if (isNew) this.#sent.set(corners, ++this.#n_sent);
      const number = [1, 3, 5].map((at) => parseInt(colour.slice(at, at + 2), 16) / 255);
      return { id: this.#sent.get(corners), corners: isNew ? corners : null, colour: number, isOpen, matrix: matrixOf(placing) };
    });
    this.#tell('models', { models: told });
  }

  /** Shows the cells of a mesh; the arrays of the runs go to the worker. @param {import('hexcast').Mesh} mesh @param {import('hexcast').AllRuns} all */
  setCells({ lines, dims, columns: { axis } }, all) {
    const cells = [...dims.filter((_, other) => other !== axis), dims[axis]];
    const grid = { axis, origin: lines.origin, spacing: lines.spacing, dims, lists: lines.lists };
    this.n_meshes += 1;
    this.#tell('cells', { all, grid, cells }, [all.offsets.buffer, all.starts.buffer, all.flags.buffer]);
  }

  /** Colours of all flags as bytes red, green, blue and alpha, the last 0 for what is hidden. @param {Uint32Array} colours */
  setColours(colours) {
    this.#tell('colours', { colours });
  }

  /** Draws models that have no cells over the cells, in stripes. @param {Float32Array[]} lost their corners @param {number} cell length of a cell */
  setLost(lost, cell) {
    this.#tell('shown', { shown: { lost: lost.map((corners) => this.#sent.get(corners)), cell } });
  }

  /** Shows either the models or the cells. @param {'model' | 'cells'} what */
  show(what) {
    this.#tell('shown', { shown: { what } });
  }

  /** Draws each axis so many times longer than it is. @param {number[]} stretch */
  setStretch(stretch) {
    this.#camera.stretch = [...stretch];
    this.invalidate();
  }

  /** Draws the edges of a box of six numbers, or none. @param {number[] | null} box */
  setBox(box) {
    if (String(box) === this.#box) return;
    this.#box = String(box);
    this.#tell('overlay', { overlay: { box } });
  }

  /** Cuts away what lies beyond a plane across an axis. @param {Cut | null} cut `at` in world lengths; what lies on `side` of it goes */
  setSection(cut) {
    this.#tell('shown', { shown: { cut } });
  }

  /** The cell at a place of the canvas, in CSS pixels. @param {number} x @param {number} y @returns {Promise<Picked | null>} */
  pick(x, y) {
    const { clientWidth, clientHeight } = this.#frame;
    return this.#ask('pick', { place: [(2 * x) / clientWidth - 1, 1 - (2 * y) / clientHeight] });
  }

  /**
   * Moves the camera so that all models fill the view.
   *
   * @param {(Placing & { info: import('hexcast').FileInfo })[]} models
   * @param {number[]} [direction]
   */
  fitModels(models, direction) {
    this.fit(boxAround(models), direction);
  }

  /** What the worker draws with. */
  sight() {
    return this.#camera.sight();
  }

  /** Where somebody put the camera: its target and offset, six numbers; null where nobody did. */
  place() {
    return this.#camera.place();
  }

  /** Puts the camera to such a place. @param {number[]} place */
  put(place) {
    this.#moved(() => this.#camera.put(minus(place.slice(0, 3), this.#camera.centre), place.slice(3)));
  }

  /** From where the camera looks. */
  direction() {
    return this.#camera.offset;
  }

  /** Moves the camera so that a box of six numbers fills the view, seen from a corner or along `direction`. @param {number[]} corners */
  fit(corners, direction = CORNER) {
    this.#moved(() => this.#camera.fit(corners, direction));
  }

  /** Flies near a place, outside of what is shown. @param {number[]} place @returns {Promise<boolean>} whether it came there */
  lookAt(place) {
    const target = minus(this.#camera.drawn(place), this.#camera.centre);
    // outwards, and a little from where models are seen at first: a place in the middle has no outside
    const outwards = plus([0.22, -0.32, 0.18], unit(target));
    return this.#fly(target, times(unit(outwards), 2 * this.#camera.radius));
  }

  /**
   * Moves the camera along an arc around what it looks at; at once for people who want no motion.
   *
   * @param {number[]} target
   * @param {number[]} offset of the camera from it
   * @returns {Promise<boolean>} false where another move took over
   */
  #fly(target, offset) {
    const move = ++this.#moves;
    const camera = this.#camera;
    const [from, fromOffset] = [camera.target, camera.offset];
    const seconds = matchMedia('(prefers-reduced-motion: reduce)').matches ? 0 : FLIGHT_SECONDS;
    const start = performance.now();
    const between = (/** @type {number[]} */ a, /** @type {number[]} */ b, /** @type {number} */ share) =>
      plus(times(a, 1 - share), times(b, share));
    return new Promise((resolve) => {
      const step = () => {
        if (move !== this.#moves) return resolve(false);
        const share = seconds > 0 ? Math.min(1, (performance.now() - start) / 1000 / seconds) : 1;
        const eased = share * share * (3 - 2 * share);
        const [length] = between([Math.hypot(...fromOffset)], [Math.hypot(...offset)], eased);
        camera.put(between(from, target, eased), times(unit(between(fromOffset, offset, eased)), length));
        this.#look();
        if (share === 1) return resolve(true);
        requestAnimationFrame(step);
      };
      step();
    });
  }

  /** Marks what was found. @param {Pick<import('./cast/overlay.js').Drawn, 'places' | 'current' | 'path' | 'marked' | 'lost'>} overlay */
  mark(overlay) {
    this.#tell('overlay', { overlay });
  }

  /** A small picture of a place, in which one model is meant. @param {Omit<import('./cast/place_picture.js').Asked, 'part'>} asked @param {Float32Array | null} corners of that model @returns {Promise<ImageData | null>} */
  placePicture(asked, corners) {
    return this.#ask('place', { asked: { ...asked, part: (corners && this.#sent.get(corners)) ?? -1 } });
  }

  /** Draws lines across the box through a place, and a line between two places. @param {number[] | null} cross @param {number[][]} measured */
  point(cross, measured) {
    this.#tell('overlay', { overlay: { cross, measured } });
  }

  /** Turns by angles around z and up (radians), and moves nearer by a factor. @param {number} around @param {number} up */
  turn(around, up, nearer = 1) {
    this.#moved(() => {
      this.#camera.turn(around, up);
      if (nearer !== 1) this.#camera.zoom(nearer);
    });
  }

  /** The side of the target on which the camera is, along an axis: 1 or -1. @param {number} axis */
  sideOf(axis) {
    return this.#camera.offset[axis] < 0 ? -1 : 1;
  }

  /** The picture as it is, twice as large. @returns {Promise<Blob | null>} PNG */
  picture() {
    return this.#ask('save', {});
  }
}

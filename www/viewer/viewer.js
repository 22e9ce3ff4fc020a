/** `<hexcast-viewer src="mesh.hxc">`: the cells of a column file, drawn as on the page, without the wasm. */
import { Camera } from '../page/view/camera.js';
import { Picture } from '../page/view/cast/picture.js';
import { flagColours } from '../page/view/flag_pixels.js';
import { startOrbit } from '../page/view/orbit.js';
import { readMeshFile } from './mesh_file.js';

/** From where it is seen at first. */
const DIRECTION = [1.1, -1.6, 0.9];
/** Milliseconds after the last move until the whole picture is drawn. */
const REST_MS = 120;
/** While something moves, pictures are so much smaller. */
const MOVING_SCALE = 0.5;
/** Radians of an arrow key, and the factor of + and -. */
const [TURN, ZOOM] = [Math.PI / 24, 1.25];

export class HexcastViewer extends HTMLElement {
  static observedAttributes = ['src', 'camera', 'cut', 'hidden-flags'];

  #canvas = document.createElement('canvas');
  #said = document.createElement('p');
  #camera = new Camera();
  /** @type {Picture | null} */
  #picture = null;
  /** @type {import('./mesh_file.js').MeshFile | null} */
  #mesh = null;
  #frame = 0;
  #rest = 0;
  #asked = 0;

  constructor() {
    super();
    const style = document.createElement('style');
    style.textContent =
      ':host{display:block;position:relative;min-height:200px}canvas{position:absolute;width:100%;height:100%}p{position:absolute;margin:12px}';
    this.#said.setAttribute('role', 'status');
    this.#canvas.tabIndex = 0;
    this.#canvas.setAttribute('role', 'img');
    this.attachShadow({ mode: 'open' }).append(style, this.#canvas, this.#said);
    const move = (/** @type {() => void} */ action) => {
      action();
      this.#draw();
    };
    startOrbit(this.#canvas, {
      turn: (around, up) => move(() => this.#camera.turn(around, up)),
      zoom: (factor, place) => move(() => this.#camera.zoom(factor, place)),
      pan: (x, y) => move(() => this.#camera.pan(x, y)),
      pick: () => {},
      hover: () => {},
    });
    this.#canvas.addEventListener('keydown', (event) => {
      const way = { ArrowLeft: [-TURN, 0], ArrowRight: [TURN, 0], ArrowUp: [0, TURN], ArrowDown: [0, -TURN] }[event.key];
      const factor = { '+': ZOOM, '-': 1 / ZOOM }[event.key];
      if (way) move(() => this.#camera.turn(way[0], way[1]));
      else if (factor) move(() => this.#camera.zoom(factor));
      else if (event.key === '0' || event.key === 'Home') move(() => this.#fit());
      else return;
      event.preventDefault();
    });
    new ResizeObserver(() => this.#resize()).observe(this.#canvas);
  }

  /** @param {string} name */
  attributeChangedCallback(name) {
    if (name === 'src') this.#load();
    if (name === 'camera') this.#place();
    if (name === 'hidden-flags') this.#colour();
    this.#draw();
  }

  /** Target and offset of the eye, six numbers in world lengths. */
  get view() {
    return this.#camera.place();
  }

  async #load() {
    const [src, asked] = [this.getAttribute('src'), ++this.#asked];
    this.#mesh = null;
    this.#said.textContent = 'Loading …';
    try {
      const response = await fetch(src ?? '');
      if (!response.ok) throw new Error(`the server answered ${response.status}`);
      const mesh = await readMeshFile(new Uint8Array(await response.arrayBuffer()));
      if (asked !== this.#asked) return;
      this.#show(mesh);
      this.#said.textContent = '';
      this.#canvas.ariaLabel = `Mesh of ${mesh.grid.dims.join(' x ')} cells: arrow keys turn it, + and - zoom, 0 shows all`;
      this.dispatchEvent(new Event('load'));
    } catch (error) {
      if (asked !== this.#asked) return;
      this.#said.textContent = `${src}: ${error instanceof Error ? error.message : error}.`;
      this.dispatchEvent(new Event('error'));
    }
  }

  /** @param {import('./mesh_file.js').MeshFile} mesh */
  #show(mesh) {
    if (!this.#picture) {
      const gl = this.#canvas.getContext('webgl2', { antialias: false, depth: false });
      if (!gl) throw new Error('this browser has no WebGL2, which draws the cells');
      this.#picture = new Picture(gl);
    }
    this.#mesh = mesh;
    this.#picture.cells.set(mesh);
    this.#resize();
    this.#fit();
    this.#place();
    this.#colour();
    this.#draw();
  }

  #fit() {
    if (this.#mesh) this.#camera.fit(this.#mesh.box, DIRECTION);
  }

  #place() {
    const [x, y, z, ...offset] = numbersOf(this.getAttribute('camera'));
    if (!this.#mesh || offset.length !== 3) return;
    const { centre } = this.#camera;
    this.#camera.put([x - centre[0], y - centre[1], z - centre[2]], offset);
  }

  #colour() {
    this.#picture?.cells.setColours(flagColours(new Set(numbersOf(this.getAttribute('hidden-flags')))));
  }

  #resize() {
    const { clientWidth, clientHeight } = this.#canvas;
    if (!this.#picture || clientWidth * clientHeight === 0) return;
    const size = [clientWidth, clientHeight].map((length) => Math.round(length * devicePixelRatio));
    [this.#canvas.width, this.#canvas.height] = size;
    this.#picture.resize(size[0], size[1]);
    this.#camera.setAspect(clientWidth / clientHeight);
    this.#draw();
  }

  /** Draws a small picture in the next frame, and the whole one at rest. */
  #draw() {
    cancelAnimationFrame(this.#frame);
    clearTimeout(this.#rest);
    this.#frame = requestAnimationFrame(() => this.#paint(MOVING_SCALE));
    this.#rest = window.setTimeout(() => this.#paint(1), REST_MS);
  }

  /** @param {number} scale */
  #paint(scale) {
    const picture = this.#picture;
    if (!picture || !this.#mesh) return;
    const [, side, axis, at] = /^\s*(-?)([xyz])\s+(\S+)\s*$/.exec(this.getAttribute('cut') ?? '') ?? [];
    const cut = axis ? { axis: 'xyz'.indexOf(axis), side: side ? -1 : 1, at: Number(at) } : null;
    const shown = { what: /** @type {const} */ ('cells'), cut, lost: [], cell: 0, sight: this.#camera.sight() };
    const how = { scale, ratio: devicePixelRatio, from: 0, to: picture.rows(scale), jitter: [0, 0], isFine: scale === 1 };
    picture.draw(shown, how);
    picture.show(scale);
    this.dataset.drawn = scale === 1 ? 'whole' : 'moving';
  }
}

/** @param {string | null} text */
function numbersOf(text) {
  return (text ?? '')
    .split(/[\s,]+/)
    .filter(Boolean)
    .map(Number);
}

customElements.define('hexcast-viewer', HexcastViewer);

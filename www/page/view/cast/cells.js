/** The cells of a mesh on the graphics card, and coarser ones, which are made when they are first drawn. */
import FRAGMENT from '../../../../shaders/picture/cast.fragment.glsl?raw';
import VERTEX from '../../../../shaders/picture/cast.vertex.glsl?raw';
import { coarser, countsOf, tilesOf } from './columns.js';
import { programOf } from './gl.js';
import { depthOf } from './sight.js';
import { UniformBlock } from './uniform_block.js';

/**
 * @typedef {import('./columns.js').Columns} Columns
 * @typedef {import('./sight.js').View} View
 * @typedef {{ axis: number, origin: number[], spacing: number[] | null, dims: number[], lists: { x: number[], y: number[], z: number[] } | null }} Grid `axis` is that of w
 * @typedef {{ axis: number, side: number, at: number }} Cut what lies on `side` of a place on an axis goes
 * @typedef {{ texture: WebGLTexture | null, shift: number, rows: Record<string, number>, cells: number[] }} Level cells on the graphics card
 */

/** Cells are drawn coarser where one is smaller than so many pixels. */
const PIXELS = 1;
/** Row shift of the largest texture that is used. */
const MOST_SHIFT = 13;

export class Cells {
  #gl;
  #program;
  #block;
  /** @type {Uint32Array} */
  #colours = new Uint32Array(256);
  /** @type {Grid | null} */
  #grid = null;
  /** The columns of the mesh and coarser ones. @type {Columns[]} */
  #columns = [];
  /** Null for those that are too large for the graphics card. @type {(Level | null | undefined)[]} */
  #levels = [];
  /** Cells of the mesh along an edge of the smallest that can be drawn. */
  step = 1;
  #counts = new Float64Array(256);
  /** Texture of the pick. @type {WebGLFramebuffer | null} */
  #picked = null;

  /** @param {import('./gl.js').GL} gl */
  constructor(gl) {
    this.#gl = gl;
    this.#program = programOf(gl, VERTEX, FRAGMENT);
    this.#block = new UniformBlock(gl, this.#program, 'Frame_block_0Fragment');
    gl.useProgram(this.#program);
    gl.uniform1i(gl.getUniformLocation(this.#program, '_group_0_binding_1_fs'), 0);
  }

  /** Takes the cells of a mesh. @param {{ columns: Columns, grid: Grid } | null} cells */
  set(cells) {
    this.#free(0);
    this.#grid = cells?.grid ?? null;
    this.step = 1;
    this.#columns = cells ? [cells.columns] : [];
    if (cells) this.#counts = countsOf(cells.columns);
  }

  /** Frees the levels from one on. @param {number} first */
  #free(first) {
    for (const level of this.#levels.splice(first)) if (level) this.#gl.deleteTexture(level.texture);
    this.#columns.splice(Math.max(first, 1));
  }

  /** Colours of the flags as bytes red, green, blue and alpha, the last 0 for what is hidden. @param {Uint32Array} colours */
  setColours(colours) {
    const isSame = colours.every((colour, flag) => colour >>> 24 === this.#colours[flag] >>> 24);
    this.#colours = colours;
    // coarser cells have no hidden flags
    if (!isSame) this.#free(1);
    for (const level of this.#levels) if (level) this.#writeColours(level);
  }

  /** @param {Level} level */
  #writeColours({ texture, rows }) {
    const gl = this.#gl;
    gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, rows.colours, 256, 1, gl.RED_INTEGER, gl.UNSIGNED_INT, this.#colours);
  }

  /** Of each flag 0 where it is not seen, else how rare it is. */
  #ranks() {
    const ranks = new Uint8Array(256);
    const seen = Array.from({ length: 256 }, (_, flag) => flag).filter((flag) => flag > 0 && this.#colours[flag] >>> 24);
    seen.sort((a, b) => this.#counts[a] - this.#counts[b]);
    for (const [rank, flag] of seen.entries()) ranks[flag] = rank + 1;
    return ranks;
  }

  /** Columns of cells 2^level as long; null where there are none as coarse. @param {number} level */
  #columnsOf(level) {
    while (this.#columns.length <= level) {
      const last = this.#columns[this.#columns.length - 1];
      if (Math.max(...last.cells) === 1) return null;
      this.#columns.push(coarser(last, this.#ranks()));
    }
    return this.#columns[level];
  }

  /** The cells of a level, or of the next that the graphics card can hold, and its number. @param {number} wanted @returns {[Level, number] | null} */
  #level(wanted) {
    for (let level = wanted; level < 24; level += 1) {
      const columns = this.#columnsOf(level);
      if (!columns) return level > 0 && level === wanted ? this.#level(level - 1) : null;
      if (this.#levels[level] === undefined) this.#levels[level] = this.#upload(columns, level);
      const found = this.#levels[level];
      if (found) return [found, level];
      this.step = 2 ** (level + 1);
    }
    return null;
  }

  /** @param {Columns} columns @param {number} level @returns {Level | null} null where it is too large */
  #upload(columns, level) {
    const gl = this.#gl;
    const most = gl.getParameter(gl.MAX_TEXTURE_SIZE);
    const [tiles8, tiles64] = tilesOf(columns);
    const parts = {
      offsets: columns.offsets,
      runs: columns.runs,
      tiles8,
      tiles64,
      lines: this.#lines(level),
      colours: this.#colours,
    };
    const n = Object.values(parts).reduce((sum, { length }) => sum + length, 0);
    const shift = Math.min(Math.max(Math.ceil(Math.log2(n) / 2), 8), Math.floor(Math.log2(most)), MOST_SHIFT);
    const width = 2 ** shift;
    /** @type {Record<string, number>} */
    const rows = {};
    let height = 0;
    for (const [name, { length }] of Object.entries(parts)) {
      rows[name] = height;
      height += Math.ceil(length / width);
    }
    if (height > most) return null;
    const texture = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.texStorage2D(gl.TEXTURE_2D, 1, gl.R32UI, width, height);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
    for (const [name, numbers] of Object.entries(parts)) this.#write(numbers, rows[name], width);
    return { texture, shift, rows, cells: columns.cells };
  }

  /** @param {Uint32Array} numbers @param {number} row @param {number} width */
  #write(numbers, row, width) {
    const gl = this.#gl;
    const put = (/** @type {number} */ y, /** @type {number} */ w, /** @type {number} */ h, /** @type {number} */ from) =>
      gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, y, w, h, gl.RED_INTEGER, gl.UNSIGNED_INT, numbers, from);
    const whole = Math.floor(numbers.length / width);
    if (whole > 0) put(row, width, whole, 0);
    if (numbers.length > whole * width) put(row + whole, numbers.length - whole * width, 1, whole * width);
  }

  /** Axes of u, v and w. */
  #axes() {
    const w = /** @type {Grid} */ (this.#grid).axis;
    return [...[0, 1, 2].filter((axis) => axis !== w), w];
  }

  /** Lines of the cells of a level where these differ in size, as bits. @param {number} level */
  #lines(level) {
    const { lists, origin, dims } = /** @type {Grid} */ (this.#grid);
    if (!lists) return new Uint32Array();
    const all = this.#axes().flatMap((axis) => {
      const list = [lists.x, lists.y, lists.z][axis];
      const n = Math.ceil(dims[axis] / 2 ** level);
      return Array.from({ length: n + 1 }, (_, at) => list[Math.min(at * 2 ** level, dims[axis])] - origin[axis]);
    });
    return new Uint32Array(Float32Array.from(all).buffer);
  }

  /** The level of which a cell is a pixel or more, by the largest cells, as these must stay what they are. @param {View} view */
  #levelOf(view) {
    const { lists, spacing, origin, dims } = /** @type {Grid} */ (this.#grid);
    const sizes = lists
      ? [lists.x, lists.y, lists.z].map((list) => list.reduce((most, at, i) => (i ? Math.max(most, at - list[i - 1]) : 0), 0))
      : /** @type {number[]} */ (spacing);
    const ends = lists
      ? [lists.x, lists.y, lists.z].map((list, axis) => list[dims[axis]])
      : origin.map((at, axis) => at + dims[axis] * sizes[axis]);
    const depth = depthOf(view.sight, origin, ends);
    const pixel = (2 * view.sight.tangent * depth) / view.height;
    const most = Math.max(...sizes.map((size, axis) => size * view.sight.stretch[axis]));
    return Math.max(0, Math.floor(Math.log2((PIXELS * pixel) / most) || 0));
  }

  /** Draws the cells. @param {View} view @param {Cut | null} cut @param {boolean} isFine */
  draw(view, cut, isFine) {
    if (!this.#grid) return;
    const found = this.#level(this.#levelOf(view));
    if (!found) return;
    this.#cast(view, cut, isFine, found);
  }

  /** @param {View} view @param {Cut | null} cut @param {boolean} isFine @param {[Level, number]} level */
  #cast(view, cut, isFine, [level, number]) {
    const gl = this.#gl;
    gl.useProgram(this.#program);
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D, level.texture);
    this.#block.write(frameOf(view, cut, /** @type {Grid} */ (this.#grid), this.#axes(), level, number), { isFine });
    gl.enable(gl.DEPTH_TEST);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
  }

  /** The cell, flag and face that are seen at a place of the view from -1 to 1 each way; null where there is none. @param {View} view @param {number[]} place @param {Cut | null} cut */
  pick(view, [x, y], cut) {
    const found = this.#grid && this.#level(0);
    if (!found) return null;
    const gl = this.#gl;
    this.#picked ??= pickTarget(gl);
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.#picked);
    gl.viewport(0, 0, 1, 1);
    gl.disable(gl.SCISSOR_TEST);
    gl.clearBufferuiv(gl.COLOR, 1, [0, 0, 0, 0]);
    // the one pixel is where the jitter of half a picture of two pixels leads
    this.#cast({ ...view, jitter: [(x * view.width) / 2, (y * view.height) / 2] }, cut, false, found);
    const seen = new Uint32Array(4);
    gl.readBuffer(gl.COLOR_ATTACHMENT1);
    gl.readPixels(0, 0, 1, 1, gl.RGBA_INTEGER, gl.UNSIGNED_INT, seen);
    const [flag, face] = [seen[3] & 255, seen[3] >>> 8];
    if (flag === 0) return null;
    const cell = [0, 0, 0];
    const axes = this.#axes();
    for (const [at, axis] of axes.entries()) cell[axis] = seen[at] * 2 ** found[1];
    return { cell, flag, axis: face < 6 ? axes[face % 3] : /** @type {Cut} */ (cut).axis, step: 2 ** found[1] };
  }
}

/** @param {import('./gl.js').GL} gl */
function pickTarget(gl) {
  const target = gl.createFramebuffer();
  gl.bindFramebuffer(gl.FRAMEBUFFER, target);
  for (const [attachment, format] of [
    [gl.COLOR_ATTACHMENT0, gl.RGBA8],
    [gl.COLOR_ATTACHMENT1, gl.RGBA32UI],
  ]) {
    const buffer = gl.createRenderbuffer();
    gl.bindRenderbuffer(gl.RENDERBUFFER, buffer);
    gl.renderbufferStorage(gl.RENDERBUFFER, format, 1, 1);
    gl.framebufferRenderbuffer(gl.FRAMEBUFFER, attachment, gl.RENDERBUFFER, buffer);
  }
  gl.drawBuffers([gl.COLOR_ATTACHMENT0, gl.COLOR_ATTACHMENT1]);
  return target;
}

/** The numbers of the kernel's `Frame`. @param {View} view @param {Cut | null} cut @param {Grid} grid @param {number[]} axes @param {Level} level @param {number} number */
function frameOf(view, cut, grid, axes, level, number) {
  const { sight, directions, width, height, jitter, light } = view;
  const { stretch } = sight;
  const { origin, spacing, dims, lists } = grid;
  const of = (/** @type {ArrayLike<number>} */ numbers) => axes.map((axis) => numbers[axis]);
  // lengths of the box in one of the world
  const share = of(spacing ? spacing.map((size) => 1 / size / 2 ** number) : [1, 1, 1]);
  // a way as it is drawn leads a shorter one in the world along what is stretched
  const scaled = (/** @type {number[]} */ way, by = 1) =>
    of(way.map((at, axis) => at / stretch[axis])).map((at, axis) => at * share[axis] * by);
  const within = (/** @type {number} */ axis, /** @type {number} */ at) => (at - origin[axis]) * share[axes.indexOf(axis)];
  const high = axes.map((axis) =>
    lists ? [lists.x, lists.y, lists.z][axis][dims[axis]] - origin[axis] : dims[axis] / 2 ** number,
  );
  const low = [0, 0, 0];
  let face = 6;
  if (cut) {
    const at = axes.indexOf(cut.axis);
    face = cut.side > 0 ? at + 3 : at;
    (cut.side > 0 ? high : low)[at] = within(cut.axis, cut.at);
  }
  const eye = sight.eye.map((at, axis) => at + (sight.centre[axis] - origin[axis] * stretch[axis]));
  const { near, far, tangent } = sight;
  return {
    eye: scaled(eye),
    depth_scale: (-far * near) / (far - near),
    ahead: scaled(directions.ahead),
    depth_offset: far / (far - near),
    right: scaled(directions.right, (tangent * width) / height),
    pixels_x: width / 2,
    up: scaled(directions.up, tangent),
    pixels_y: height / 2,
    low,
    is_graded: lists ? 1 : 0,
    high,
    cut: face,
    cells: level.cells,
    row_shift: level.shift,
    light_down: of(light.down),
    light_up: of(light.up),
    jitter_x: jitter[0],
    jitter_y: jitter[1],
    offsets: level.rows.offsets,
    runs: level.rows.runs,
    tiles_8: level.rows.tiles8,
    tiles_64: level.rows.tiles64,
    lines: level.rows.lines,
    colours: level.rows.colours,
  };
}

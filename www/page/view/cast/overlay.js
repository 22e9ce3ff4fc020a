/** Lines and rings over the picture, always as wide on the screen: the box, open edges, a path, marks of places, the crosshair, what is measured. */
import { programOf } from './gl.js';
import { matrixOf } from './sight.js';

/** @typedef {{ array: WebGLVertexArrayObject | null, buffer: WebGLBuffer | null, n: number }} Lines
 * @typedef {{ ends: Float32Array, matrix: number[] }} Edges of a model, six numbers an edge; `matrix` to world lengths, by columns */
/**
 * @typedef {object} Drawn what is drawn, in world lengths and CSS pixels
 * @property {number[] | null} box six numbers
 * @property {(number[] | null)[]} places marked by rings
 * @property {number} current index of the place that is shown, -1 for none
 * @property {number[][]} marked boxes of what is meant there
 * @property {number[][]} lost boxes of what has no cells
 * @property {Edges[]} edges that are open
 * @property {number[][]} path corners of a line
 * @property {number[] | null} cross a place through which lines lead across the box
 * @property {number[][]} measured ends of a line: none, one or two
 */

/** Colours of the box, of the mark that is shown and the path, and of other marks, on light and dark and on the colours of flags. */
const BOX = [0x7a, 0x8a, 0x99];
const CURRENT = [0xe0, 0x10, 0x3c];
const OTHER = [0x7d, 0x2f, 0xb8];
/** Of open edges, and of the boxes of what is meant. */
const MEANT = [0xff, 0x3b, 0x20];
/** And of the crosshair and what is measured. */
const CROSS = [0x2f, 0x84, 0xc8];
const MEASURED = [0xb0, 0x40, 0x90];
/** Radii of the middle of a ring's stroke. */
const RADIUS = 12.5;
const OTHER_RADIUS = 10;
const SMALL_RADIUS = 4;
/** Half the width of its stroke, and of the white one below. */
const STROKE = 2.6;
const UNDER = 4.2;
/** Half the width of an open edge. */
const EDGE_WIDTH = 1.2;
/** Numbers of a line or ring: two ends, colour, and half the width or, of a ring, its radius with a minus. */
const NUMBERS = 10;

const VERTEX = `#version 300 es
uniform mat4 toView;
// CSS pixels of half the view
uniform vec2 halfView;
in vec3 from;
in vec3 to;
in vec4 look;
out vec4 drawn;
out vec2 within;
void main() {
  vec4 a = toView * vec4(from, 1.0);
  vec4 b = toView * vec4(to, 1.0);
  // what is behind the eye has no place in the picture
  float near = 1e-4 * max(abs(a.w), abs(b.w));
  if (a.w < near && b.w > near) a = mix(a, b, (near - a.w) / (b.w - a.w));
  else if (b.w < near && a.w > near) b = mix(b, a, (near - b.w) / (a.w - b.w));
  vec2 corner = vec2(float(gl_VertexID & 1), float(gl_VertexID >> 1)) * 2.0 - 1.0;
  drawn = look;
  if (look.w < 0.0) {
    within = corner * (${UNDER.toFixed(1)} + 1.0 - look.w);
    gl_Position = a + vec4(within / halfView * a.w, 0.0, 0.0);
  } else {
    vec2 way = (b.xy / b.w - a.xy / a.w) * halfView;
    vec2 along = length(way) > 1e-6 ? normalize(way) : vec2(1.0, 0.0);
    within = vec2(0.0);
    vec4 end = corner.x < 0.0 ? a : b;
    gl_Position = end + vec4((vec2(-along.y, along.x) * corner.y + along * corner.x) * look.w / halfView * end.w, 0.0, 0.0);
  }
}`;

const FRAGMENT = `#version 300 es
precision highp float;
in vec4 drawn;
in vec2 within;
out vec4 seen;
void main() {
  seen = vec4(drawn.rgb, 1.0);
  if (drawn.w < 0.0) {
    float off = abs(length(within) + drawn.w);
    if (off > ${UNDER.toFixed(1)}) discard;
    if (off > ${STROKE.toFixed(1)}) seen = vec4(1.0);
  }
}`;

export class Overlay {
  #gl;
  #program;
  #moving;
  #edges;
  /** Where the numbers of the open edges are those of. */
  #edgesOf = '';
  /** @type {Drawn} */
  #drawn = { box: null, places: [], current: -1, marked: [], lost: [], edges: [], path: [], cross: null, measured: [] };

  /** @param {import('./gl.js').GL} gl */
  constructor(gl) {
    this.#gl = gl;
    this.#program = programOf(gl, VERTEX, FRAGMENT);
    this.#moving = this.#lines();
    this.#edges = this.#lines();
  }

  /** Room for the numbers of lines. */
  #lines() {
    const gl = this.#gl;
    const [array, buffer] = [gl.createVertexArray(), gl.createBuffer()];
    gl.bindVertexArray(array);
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    for (const [name, first, n] of /** @type {[string, number, number][]} */ ([
      ['from', 0, 3],
      ['to', 3, 3],
      ['look', 6, 4],
    ])) {
      const at = gl.getAttribLocation(this.#program, name);
      gl.enableVertexAttribArray(at);
      gl.vertexAttribPointer(at, n, gl.FLOAT, false, 4 * NUMBERS, 4 * first);
      gl.vertexAttribDivisor(at, 1);
    }
    gl.bindVertexArray(null);
    return { array, buffer, n: 0 };
  }

  /** @param {Partial<Drawn>} drawn */
  set(drawn) {
    Object.assign(this.#drawn, drawn);
    if (drawn.edges) this.#edgesOf = '';
  }

  /** Draws the box behind what is before it, and all else over everything. @param {import('./sight.js').View} view @param {number} ratio pixels of a CSS pixel */
  draw(view, ratio) {
    const { box, places, current, marked, lost, path, cross, measured } = this.#drawn;
    const { centre, stretch } = view.sight;
    const near = (/** @type {number[]} */ place) => place.map((at, axis) => at * stretch[axis] - centre[axis]);
    const line = (/** @type {number[][]} */ [from, to], /** @type {number[]} */ colour, /** @type {number} */ width) => [
      ...near(from),
      ...near(to),
      ...colour.map((part) => part / 255),
      width,
    ];
    const edges = box ? edgesOf(box).flatMap((edge) => line(edge, BOX, 0.6)) : [];
    const around = (/** @type {number[][]} */ boxes, /** @type {number[]} */ colour, /** @type {number} */ width) =>
      boxes.flatMap((one) => edgesOf(one).flatMap((edge) => line(edge, colour, width)));
    const ways = path.slice(1).flatMap((to, at) => line([path[at], to], CURRENT, 1));
    // the one that is shown is over the others
    const order = [...places.keys()].filter((at) => at !== current);
    if (places[current]) order.push(current);
    const rings = order.flatMap((at) => {
      const place = places[at];
      if (!place) return [];
      return at === current ? line([place, place], CURRENT, -RADIUS) : line([place, place], OTHER, -OTHER_RADIUS);
    });
    const dots = (/** @type {number[][]} */ all, /** @type {number[]} */ colour) =>
      all.flatMap((place) => line([place, place], colour, -SMALL_RADIUS));
    const lines = cross && box ? linesThrough(cross, box).flatMap((way) => line(way, CROSS, 0.8)) : [];
    const between = measured.length === 2 ? line(measured, MEASURED, 1.2) : [];
    this.#fillEdges(view.sight);
    this.#draw(view, ratio, this.#fill(this.#moving, [...edges, ...lines]), true);
    this.#draw(view, ratio, this.#edges, false);
    const boxes = [...around(lost, OTHER, 0.8), ...around(marked, MEANT, 1.1)];
    const over = [...ways, ...rings, ...between, ...dots(measured, MEASURED), ...dots(cross ? [cross] : [], CROSS)];
    this.#draw(view, ratio, this.#fill(this.#moving, [...boxes, ...over]), false);
  }

  /** The open edges, which are too many to be written for each picture. @param {import('./sight.js').Sight} sight */
  #fillEdges({ centre, stretch }) {
    const of = JSON.stringify([centre, stretch]);
    if (of === this.#edgesOf) return;
    this.#edgesOf = of;
    const colour = [...MEANT.map((part) => part / 255), EDGE_WIDTH];
    const n_all = this.#drawn.edges.reduce((sum, { ends }) => sum + ends.length / 6, 0);
    const numbers = new Float32Array(NUMBERS * n_all);
    let at = 0;
    for (const { ends, matrix } of this.#drawn.edges) {
      for (let from = 0; from < ends.length; from += 6, at += NUMBERS) {
        for (let k = 0; k < 6; k += 1) {
          const [axis, end] = [k % 3, from + (k < 3 ? 0 : 3)];
          const world = [0, 1, 2].reduce((sum, other) => sum + matrix[axis + 4 * other] * ends[end + other], matrix[12 + axis]);
          numbers[at + k] = world * stretch[axis] - centre[axis];
        }
        numbers.set(colour, at + 6);
      }
    }
    this.#fill(this.#edges, numbers);
  }

  /** @param {Lines} lines @param {ArrayLike<number>} numbers */
  #fill(lines, numbers) {
    const gl = this.#gl;
    lines.n = numbers.length / NUMBERS;
    gl.bindBuffer(gl.ARRAY_BUFFER, lines.buffer);
    gl.bufferData(gl.ARRAY_BUFFER, Float32Array.from(numbers), gl.DYNAMIC_DRAW);
    return lines;
  }

  /** @param {import('./sight.js').View} view @param {number} ratio @param {Lines} lines @param {boolean} hasDepth */
  #draw(view, ratio, { array, n }, hasDepth) {
    if (n === 0) return;
    const gl = this.#gl;
    gl.useProgram(this.#program);
    gl.bindVertexArray(array);
    gl.uniformMatrix4fv(gl.getUniformLocation(this.#program, 'toView'), false, Float32Array.from(matrixOf(view)));
    gl.uniform2f(gl.getUniformLocation(this.#program, 'halfView'), view.width / ratio / 2, view.height / ratio / 2);
    if (hasDepth) gl.enable(gl.DEPTH_TEST);
    else gl.disable(gl.DEPTH_TEST);
    gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, n);
    gl.bindVertexArray(null);
  }
}

/** Lines along the axes through a place of a box. @param {number[]} place @param {number[]} box @returns {number[][][]} */
function linesThrough(place, box) {
  return [0, 1, 2].map((axis) => [0, 3].map((end) => place.map((at, other) => (other === axis ? box[axis + end] : at))));
}

/** The twelve edges of a box. @param {number[]} box @returns {number[][][]} */
function edgesOf(box) {
  const corner = (/** @type {number} */ at) => [0, 1, 2].map((axis) => box[axis + ((at >> axis) & 1 ? 3 : 0)]);
  return [0, 1, 2].flatMap((axis) =>
    [0, 1, 2, 3, 4, 5, 6, 7].filter((at) => !((at >> axis) & 1)).map((at) => [corner(at), corner(at | (1 << axis))]),
  );
}

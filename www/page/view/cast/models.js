/** The surfaces of models: triangles of one colour each, lit by their facets. */
import { programOf } from './gl.js';
import { AMBIENT, LAMP, matrixOf, product } from './sight.js';

/** @typedef {{ id: number, corners: Float32Array, colour: number[], matrix: number[] }} Model nine numbers a facet; `matrix` to world lengths, by columns */
/**
 * How models are drawn: which, in another colour, in stripes so many pixels apart, and as if they were nearer by a length.
 *
 * @typedef {{ has?: (id: number) => boolean, colour?: number[] | null, stripes?: number, nearer?: number }} Look
 */

const VERTEX = `#version 300 es
uniform mat4 toView;
uniform mat4 toWorld;
uniform mat4 toPicture;
uniform vec3 eye;
// length by which it is nearer to the eye than it is, for what it hides
uniform float nearer;
in vec3 corner;
out vec3 place;
void main() {
  place = (toWorld * vec4(corner, 1.0)).xyz;
  gl_Position = toView * vec4(corner, 1.0);
  vec4 near = toPicture * vec4(place + normalize(eye - place) * nearer, 1.0);
  if (nearer > 0.0) gl_Position.z = near.z / near.w * gl_Position.w;
}`;

const FRAGMENT = `#version 300 es
precision highp float;
uniform vec3 colour;
uniform vec3 lamp;
// what lies on the side of its direction goes
uniform vec4 cut;
// pixels from one stripe to the next; 0 for none
uniform float stripes;
in vec3 place;
out vec4 seen;
void main() {
  if (dot(place, cut.xyz) > cut.w) discard;
  if (stripes > 0.0 && fract((gl_FragCoord.x + gl_FragCoord.y) / stripes) > 0.4) discard;
  vec3 normal = normalize(cross(dFdx(place), dFdy(place)));
  float light = dot(normal, lamp);
  // a facet has two sides
  seen = vec4(colour * (${AMBIENT.toFixed(3)} + ${LAMP.toFixed(3)} * abs(light)), 1.0);
}`;

export class Models {
  #gl;
  #program;
  /** Corners on the graphics card. @type {Map<number, { array: WebGLVertexArrayObject | null, buffer: WebGLBuffer | null, n: number }>} */
  #held = new Map();
  /** @type {Model[]} */
  #models = [];

  /** @param {import('./gl.js').GL} gl */
  constructor(gl) {
    this.#gl = gl;
    this.#program = programOf(gl, VERTEX, FRAGMENT);
  }

  /** @param {Model[]} models */
  set(models) {
    const gl = this.#gl;
    for (const [id, { array, buffer }] of this.#held) {
      if (models.some((model) => model.id === id)) continue;
      gl.deleteVertexArray(array);
      gl.deleteBuffer(buffer);
      this.#held.delete(id);
    }
    for (const { id, corners } of models) if (!this.#held.has(id)) this.#held.set(id, this.#upload(corners));
    this.#models = models;
  }

  /** @param {Float32Array} corners */
  #upload(corners) {
    const gl = this.#gl;
    const [array, buffer] = [gl.createVertexArray(), gl.createBuffer()];
    gl.bindVertexArray(array);
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.bufferData(gl.ARRAY_BUFFER, corners, gl.STATIC_DRAW);
    const corner = gl.getAttribLocation(this.#program, 'corner');
    gl.enableVertexAttribArray(corner);
    gl.vertexAttribPointer(corner, 3, gl.FLOAT, false, 0, 0);
    gl.bindVertexArray(null);
    return { array, buffer, n: corners.length / 3 };
  }

  /** @param {import('./sight.js').View} view @param {import('./cells.js').Cut | null} cut @param {Look} look */
  draw(view, cut, { has = () => true, colour: only = null, stripes = 0, nearer = 0 } = {}) {
    const gl = this.#gl;
    gl.useProgram(this.#program);
    gl.enable(gl.DEPTH_TEST);
    const at = (/** @type {string} */ name) => gl.getUniformLocation(this.#program, name);
    gl.uniform3fv(at('lamp'), view.light.lamp);
    const { centre, stretch } = view.sight;
    const side = cut ? [0, 1, 2].map((axis) => (axis === cut.axis ? cut.side : 0)) : [0, 0, 0];
    gl.uniform4f(at('cut'), side[0], side[1], side[2], cut ? cut.side * (cut.at * stretch[cut.axis] - centre[cut.axis]) : 1);
    const toView = matrixOf(view);
    gl.uniformMatrix4fv(at('toPicture'), false, Float32Array.from(toView));
    gl.uniform3fv(at('eye'), view.sight.eye);
    gl.uniform1f(at('stripes'), stripes);
    gl.uniform1f(at('nearer'), nearer);
    for (const { id, colour, matrix } of this.#models) {
      const held = this.#held.get(id);
      if (!held || !has(id)) continue;
      // the centre of the world is that of the view: lengths there may be far from zero
      const toWorld = matrix.map(
        (number, place) => (stretch[place % 4] ?? 1) * number - (place >= 12 ? (centre[place - 12] ?? 0) : 0),
      );
      gl.uniformMatrix4fv(at('toWorld'), false, Float32Array.from(toWorld));
      gl.uniformMatrix4fv(at('toView'), false, Float32Array.from(product(toView, toWorld)));
      gl.uniform3fv(at('colour'), only ?? colour);
      gl.bindVertexArray(held.array);
      gl.drawArrays(gl.TRIANGLES, 0, held.n);
    }
    gl.bindVertexArray(null);
  }
}

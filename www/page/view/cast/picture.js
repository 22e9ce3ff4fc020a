/** Draws the whole picture, or a part of it, at full size or a smaller one, and puts it on the canvas. */
import { Cells } from './cells.js';
import { canvasOf, programOf } from './gl.js';
import { Models } from './models.js';
import { Overlay } from './overlay.js';
import { viewOf } from './sight.js';

/**
 * @typedef {object} Shown
 * @property {'model' | 'cells'} what
 * @property {import('./cells.js').Cut | null} cut
 * @property {number[]} lost numbers of the models that have no cells, which are drawn in stripes
 * @property {number} cell length of a cell
 * @property {import('../camera.js').Sight} sight
 */

/** CSS pixels from one stripe to the next. */
const STRIPES = 7;

const COPY_VERTEX = `#version 300 es
out vec2 at;
void main() {
  at = vec2(float(gl_VertexID & 1), float(gl_VertexID >> 1)) * 2.0;
  gl_Position = vec4(at * 2.0 - 1.0, 0.0, 1.0);
}`;

const COPY_FRAGMENT = `#version 300 es
precision highp float;
uniform highp sampler2D picture;
uniform vec2 used;
in vec2 at;
out vec4 seen;
void main() {
  seen = texture(picture, at * used);
}`;

export class Picture {
  #gl;
  #copy;
  /** A pass is drawn here. @type {ReturnType<typeof canvasOf> | null} */
  #pass = null;
  /** The passes so far, of which this is the mean. @type {ReturnType<typeof canvasOf> | null} */
  #mean = null;

  /** @param {import('./gl.js').GL} gl */
  constructor(gl) {
    this.#gl = gl;
    this.#copy = programOf(gl, COPY_VERTEX, COPY_FRAGMENT);
    this.cells = new Cells(gl);
    this.models = new Models(gl);
    this.overlay = new Overlay(gl);
  }

  /** @param {number} width @param {number} height */
  resize(width, height) {
    this.#pass?.free();
    this.#mean?.free();
    this.#pass = canvasOf(this.#gl, width, height, true);
    this.#mean = canvasOf(this.#gl, width, height, false);
  }

  /**
   * Draws into the pass: rows from `from` to before `to` of a picture that is `scale` times as large.
   *
   * @param {Shown} shown
   * @param {{ scale: number, ratio: number, from: number, to: number, jitter: number[], isFine: boolean }} how
   */
  draw({ what, cut, sight, lost, cell }, { scale, ratio, from, to, jitter, isFine }) {
    const gl = this.#gl;
    if (!this.#pass) return;
    const [width, height] = this.#size(scale);
    const view = viewOf(sight, width, height, jitter);
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.#pass.target);
    gl.viewport(0, 0, width, height);
    gl.enable(gl.SCISSOR_TEST);
    gl.scissor(0, from, width, to - from);
    gl.disable(gl.BLEND);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    if (what === 'cells') {
      this.cells.draw(view, cut, isFine);
      const stripes = STRIPES * ratio * scale;
      if (lost.length > 0) this.models.draw(view, cut, { has: (id) => lost.includes(id), stripes, nearer: 1.5 * cell });
    } else this.models.draw(view, cut);
    this.overlay.draw(view, ratio * scale);
    gl.disable(gl.SCISSOR_TEST);
  }

  /** @param {number} scale */
  #size(scale) {
    const { width, height } = /** @type {ReturnType<typeof canvasOf>} */ (this.#pass);
    return [width, height].map((length) => Math.max(1, Math.round(length * scale)));
  }

  /** Rows of the picture at a scale. @param {number} scale */
  rows(scale) {
    return this.#pass ? this.#size(scale)[1] : 0;
  }

  /** Puts the pass on the canvas. @param {number} scale */
  show(scale) {
    if (!this.#pass) return;
    const [width, height] = this.#size(scale);
    this.#put(null, this.#pass, [width / this.#pass.width, height / this.#pass.height], 1);
  }

  /** Adds the pass, number `n` from 0 on, to the mean. @param {number} n */
  addToMean(n) {
    if (this.#pass && this.#mean) this.#put(this.#mean, this.#pass, [1, 1], 1 / (n + 1));
  }

  /** Puts the mean on the canvas. */
  showMean() {
    if (this.#mean) this.#put(null, this.#mean, [1, 1], 1);
  }

  /** @param {{ target: WebGLFramebuffer | null } | null} on @param {ReturnType<typeof canvasOf>} of @param {number[]} used @param {number} share */
  #put(on, { texture, width, height }, used, share) {
    const gl = this.#gl;
    gl.bindFramebuffer(gl.FRAMEBUFFER, on?.target ?? null);
    gl.viewport(0, 0, width, height);
    gl.disable(gl.DEPTH_TEST);
    if (share < 1) gl.enable(gl.BLEND);
    gl.blendColor(0, 0, 0, share);
    gl.blendFunc(gl.CONSTANT_ALPHA, gl.ONE_MINUS_CONSTANT_ALPHA);
    gl.useProgram(this.#copy);
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.uniform2f(gl.getUniformLocation(this.#copy, 'used'), used[0], used[1]);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    gl.disable(gl.BLEND);
  }

  /** What is seen at a place of the view from -1 to 1 each way. @param {Shown} shown @param {number[]} place */
  pick({ what, cut, sight }, place) {
    if (!this.#pass || what !== 'cells') return null;
    const [width, height] = this.#size(1);
    return this.cells.pick(viewOf(sight, width, height), place, cut);
  }
}

/** Small pictures of places: the part that is meant in its colour, seen through the others, which are grey, with the boxes and edges that are meant. */
import { canvasOf } from './gl.js';
import { Overlay } from './overlay.js';
import { viewOf } from './sight.js';

/** Pixels of a CSS pixel of the lines. */
const RATIO = 2;
const GREY = [0.66, 0.69, 0.73];

/**
 * @typedef {object} Asked
 * @property {import('../camera.js').Sight} sight
 * @property {number} width of the picture, in pixels
 * @property {number} height
 * @property {number} part number of the corners of the part that is meant; -1 for none
 * @property {Partial<import('./overlay.js').Drawn>} overlay
 */

export class PlacePictures {
  #gl;
  #models;
  #overlay;

  /** @param {import('./gl.js').GL} gl @param {import('./models.js').Models} models */
  constructor(gl, models) {
    this.#gl = gl;
    this.#models = models;
    this.#overlay = new Overlay(gl);
  }

  /** @param {Asked} asked @param {import('./overlay.js').Edges[]} edges @returns {ImageData} rows downwards */
  draw({ sight, width, height, part, overlay }, edges) {
    const gl = this.#gl;
    const target = canvasOf(gl, width, height, true);
    const view = viewOf(sight, width, height);
    gl.bindFramebuffer(gl.FRAMEBUFFER, target.target);
    gl.viewport(0, 0, width, height);
    gl.disable(gl.SCISSOR_TEST);
    gl.disable(gl.BLEND);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    this.#models.draw(view, null, part < 0 ? {} : { has: (id) => id !== part, colour: GREY });
    gl.clear(gl.DEPTH_BUFFER_BIT);
    this.#models.draw(view, null, { has: (id) => id === part });
    this.#overlay.set({ ...overlay, edges });
    this.#overlay.draw(view, RATIO);
    const image = new ImageData(width, height);
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, image.data);
    target.free();
    // rows of WebGL are upwards
    const rows = image.data.slice();
    for (let row = 0; row < height; row += 1)
      image.data.set(rows.subarray(4 * width * row, 4 * width * (row + 1)), 4 * width * (height - 1 - row));
    return image;
  }
}

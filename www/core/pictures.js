/** What is drawn of a mesh, out of the wasm: arrays that belong to the caller; and what differs between two. */
import { inSteps } from './steps.js';

/**
 * What is asked of a picture, once it is checked.
 *
 * @typedef {{ size: number | undefined, flags: Uint8Array, colours: Uint32Array, maxBytes: number }} Look
 * @typedef {{ axes: Uint8Array, places: string, hasLines: boolean }} SlicesAsked
 * @typedef {{ direction: Float64Array | undefined, cells: Uint32Array | undefined }} ViewAsked
 * @typedef {{ look: Look, slices?: SlicesAsked, view?: ViewAsked }} Asked
 */

/**
 * A plane of cells.
 *
 * @param {import('../hexcast_wasm.js').WebMesh} mesh
 * @param {number} axis
 * @param {number} index
 * @param {number} maxPixels
 */
export function sliceOf(mesh, axis, index, maxPixels) {
  const bytes = mesh.slice(axis, index, maxPixels);
  const [width, height, step] = new Uint32Array(bytes.slice(0, 12).buffer);
  return { width, height, step, flags: bytes.slice(12) };
}

/**
 * The stair-step surface.
 *
 * @param {import('../hexcast_wasm.js').WebMesh} mesh
 * @param {number} maxQuads
 */
export function skinOf(mesh, maxQuads) {
  const skin = mesh.skin(maxQuads);
  const part = (/** @type {number} */ at) => ({ positions: skin.positions(at), indices: skin.indices(at) });
  const parts = Array.from(skin.flags(), (flag, at) => ({ flag, ...part(at) }));
  const step = skin.step();
  skin.free();
  return { step, parts };
}

/**
 * Draws a picture in steps: slices, or a view.
 *
 * @param {import('./core.js').Glue} glue
 * @param {import('../hexcast_wasm.js').WebMesh} mesh
 * @param {Asked} asked
 * @param {import('../protocol/call.js').State} state
 * @returns {Promise<Uint8Array<ArrayBuffer>>} the file, PNG
 */
export function pictureIn(glue, mesh, { look, slices, view }, state) {
  const how = new glue.WebLook(look.size, look.flags, look.colours, look.maxBytes);
  const work = slices
    ? mesh.drawSlices(slices.axes, slices.places, slices.hasLines, how)
    : mesh.drawView(view?.direction, view?.cells, how);
  return inSteps(work, state);
}

/**
 * Compares in steps.
 *
 * @param {import('../hexcast_wasm.js').WebMesh} one
 * @param {import('../hexcast_wasm.js').WebMesh} other
 * @param {number} maxBytes
 * @param {import('../protocol/call.js').State} state
 * @returns {Promise<{ facts: Omit<import('../hexcast.js').Difference, 'mask'>, mask: import('../hexcast_wasm.js').WebMesh }>}
 */
export async function comparedIn(one, other, maxBytes, state) {
  const [facts, mask] = await inSteps(one.differenceFrom(other, maxBytes), state);
  return { facts: JSON.parse(facts), mask };
}

/** What is drawn of a mesh, out of the wasm: arrays that belong to the caller. */

/**
 * A plane of cells.
 *
 * @param {import('./hexcast_wasm.js').WebMesh} mesh
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
 * @param {import('./hexcast_wasm.js').WebMesh} mesh
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

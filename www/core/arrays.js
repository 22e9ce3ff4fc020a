/** What was measured beside the cells, out of the wasm: typed arrays that belong to the caller. */

/** @type {Record<string, (buffer: ArrayBuffer) => unknown>} by NumPy's names of the types */
const KINDS = {
  '|u1': (buffer) => new Uint8Array(buffer),
  '|i1': (buffer) => new Int8Array(buffer),
  '<i2': (buffer) => new Int16Array(buffer),
  '<i4': (buffer) => new Int32Array(buffer),
  '<u4': (buffer) => new Uint32Array(buffer),
  '<f4': (buffer) => new Float32Array(buffer),
  '<f8': (buffer) => new Float64Array(buffer),
  // indices of cells are below 2^53
  '<u8': (buffer) => Float64Array.from(new BigUint64Array(buffer), Number),
};

/** @typedef {'links' | 'fractions' | 'staggered' | 'conformal' | 'tensors' | 'distance'} Measured */

/**
 * The arrays of what was measured, by their names.
 *
 * @param {import('../hexcast_wasm.js').WebMesh} mesh
 * @param {Measured} of
 * @returns {Record<string, any>}
 */
export function arraysOf(mesh, of) {
  /** @type {{ name: string, kind: string }[]} */
  const described = JSON.parse(mesh.arraysOf(of));
  return Object.fromEntries(
    described.map(({ name, kind }, index) => [name, KINDS[kind](/** @type {ArrayBuffer} */ (mesh.arrayOf(of, index).buffer))]),
  );
}

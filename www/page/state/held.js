/** Meshes that are in use, such as by a file that is written: one that another has replaced goes once nobody uses it. */

/** @typedef {import('hexcast').Mesh} Mesh */

/** How many use a mesh, and whether it was replaced. @type {WeakMap<Mesh, { n: number, isReplaced: boolean }>} */
const held = new WeakMap();

/**
 * Uses a mesh until an action ends.
 *
 * @template T
 * @param {Mesh} mesh
 * @param {() => Promise<T>} act
 * @returns {Promise<T>}
 */
export async function holding(mesh, act) {
  const use = held.get(mesh) ?? { n: 0, isReplaced: false };
  held.set(mesh, use);
  use.n += 1;
  try {
    return await act();
  } finally {
    use.n -= 1;
    if (use.n === 0 && use.isReplaced) mesh.dispose();
  }
}

/** Frees a mesh that another replaces, now or once nobody uses it. @param {Mesh | null} mesh */
export function release(mesh) {
  const use = mesh && held.get(mesh);
  if (use && use.n > 0) use.isReplaced = true;
  else mesh?.dispose();
}

/** What the core tells of a mesh that is made, and while it is made. */

/**
 * The facts of a mesh that go to the caller with it.
 *
 * @param {import('../hexcast_wasm.js').WebMesh} mesh
 * @param {string} adapterName the browser's name of the GPU
 */
export function factsOf(mesh, adapterName) {
  const [runs, bytes] = mesh.columnFacts();
  /** @type {Record<string, number | undefined>} */
  const sizes = {};
  const ofCells = ['vti', 'vtr', 'npy'].flatMap((ending) => [`fractions.${ending}`, `distance.${ending}`]);
  for (const format of ['vti', 'vtr', 'npy', 'raw', 'hxc', 'nrrd', 'links', ...ofCells]) sizes[format] = mesh.size(format, false);
  for (const format of ['npy', 'raw']) sizes[`${format}-bits`] = mesh.size(format, true);
  /** @type {import('../hexcast.js').Report} */
  const report = JSON.parse(mesh.report());
  // browsers give the wasm no name
  if (report.adapter === '') report.adapter = adapterName;
  return { report, axis: /** @type {0 | 1 | 2} */ (mesh.rayAxis()), runs, bytes, sizes };
}

/** Tells a listener of rays that are done, and of all. @param {import('../protocol/call.js').Listener} progress */
export function onRays(progress) {
  return (/** @type {number} */ done, /** @type {number} */ total) => progress({ stage: 'mesh', done, total });
}

/** What each format is and can hold. Made by `npm run options` of docs/formats.json. */

/** @typedef {import('../hexcast.js').FormatFacts} Facts */

/**
 * @param {Facts['kind']} kind @param {string} type @param {boolean} compresses @param {boolean} ascii @param {boolean} unit
 * @param {Facts['spacing']} spacing @returns {Facts}
 */
const row = (kind, type, compresses, ascii, unit, spacing) => Object.freeze({ kind, type, compresses, ascii, unit, spacing });

/** @type {typeof import('../hexcast.js').formats} */
export const FORMATS = Object.freeze({
  vti: row('cells', 'application/vnd.vtk.vti+xml', true, false, false, 'equal'),
  vtr: row('cells', 'application/vnd.vtk.vtr+xml', true, false, false, 'any'),
  npy: row('cells', 'application/octet-stream', false, false, false, 'any'),
  npz: row('cells', 'application/octet-stream', true, false, false, 'any'),
  raw: row('cells', 'application/octet-stream', false, false, false, 'any'),
  hxc: row('cells', 'application/octet-stream', true, false, false, 'any'),
  zarr: row('cells', 'application/zip', true, false, false, 'any'),
  'links.npz': row('measured', 'application/octet-stream', true, false, false, 'any'),
  'links.h5': row('measured', 'application/x-hdf5', true, false, false, 'any'),
  links: row('measured', 'application/octet-stream', false, false, false, 'any'),
  'staggered.npz': row('measured', 'application/octet-stream', true, false, false, 'any'),
  'fractions.npz': row('measured', 'application/octet-stream', true, false, false, 'any'),
  'fractions.vti': row('measured', 'application/vnd.vtk.vti+xml', true, false, false, 'equal'),
  'fractions.vtr': row('measured', 'application/vnd.vtk.vtr+xml', true, false, false, 'any'),
  'fractions.npy': row('measured', 'application/octet-stream', false, false, false, 'any'),
  'fractions.zarr': row('measured', 'application/zip', true, false, false, 'any'),
  foam: row('export', 'application/zip', true, true, true, 'any'),
  inp: row('export', 'application/octet-stream', false, false, true, 'any'),
  msh: row('export', 'application/octet-stream', false, true, false, 'any'),
  xdmf: row('export', 'application/zip', true, false, false, 'any'),
  'csx.xml': row('export', 'application/xml', false, false, true, 'any'),
  in: row('export', 'application/zip', true, false, true, 'equal'),
  'geometry.xml': row('export', 'application/xml', false, false, true, 'equal'),
  nrrd: row('export', 'application/octet-stream', true, false, false, 'equal'),
  vox: row('export', 'application/octet-stream', false, false, false, 'equal'),
  binvox: row('export', 'application/octet-stream', false, false, false, 'cubes'),
});

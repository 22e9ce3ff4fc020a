/** What each format is and can hold. Made by `npm run options` of docs/formats.json. */

/** @typedef {import('../hexcast.js').FormatFacts} Facts */

/**
 * @param {Facts['kind']} kind @param {string} type @param {boolean} compresses @param {boolean} ascii @param {boolean} unit
 * @param {Facts['spacing']} spacing @param {Pick<Facts, 'program' | 'about' | 'file'>} [of] another program @returns {Facts}
 */
const row = (kind, type, compresses, ascii, unit, spacing, of) =>
  Object.freeze({ kind, type, compresses, ascii, unit, spacing, ...of });

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
  'conformal.npz': row('measured', 'application/octet-stream', true, false, false, 'any'),
  'distance.npz': row('measured', 'application/octet-stream', true, false, false, 'any'),
  'distance.vti': row('measured', 'application/vnd.vtk.vti+xml', true, false, false, 'equal'),
  'distance.vtr': row('measured', 'application/vnd.vtk.vtr+xml', true, false, false, 'any'),
  'distance.npy': row('measured', 'application/octet-stream', false, false, false, 'any'),
  'distance.h5': row('measured', 'application/x-hdf5', true, false, false, 'any'),
  'distance.zarr': row('measured', 'application/zip', true, false, false, 'any'),
  'tensors.npz': row('measured', 'application/octet-stream', true, false, false, 'any'),
  'fractions.npz': row('measured', 'application/octet-stream', true, false, false, 'any'),
  'fractions.vti': row('measured', 'application/vnd.vtk.vti+xml', true, false, false, 'equal'),
  'fractions.vtr': row('measured', 'application/vnd.vtk.vtr+xml', true, false, false, 'any'),
  'fractions.npy': row('measured', 'application/octet-stream', false, false, false, 'any'),
  'fractions.zarr': row('measured', 'application/zip', true, false, false, 'any'),
  foam: row('export', 'application/zip', true, true, true, 'any', {
    program: 'OpenFOAM',
    about: 'a polyMesh',
    file: 'NAME.foam.zip',
  }),
  eb: row('export', 'application/zip', true, false, false, 'equal', {
    program: 'AMReX',
    about: 'exact cut cells for incflo, PeleC, MFIX-Exa',
    file: 'NAME.eb.zip',
  }),
  inp: row('export', 'application/octet-stream', false, false, true, 'any', {
    program: 'Abaqus, CalculiX',
    about: 'bricks, sets, surfaces',
    file: 'NAME.inp',
  }),
  msh: row('export', 'application/octet-stream', false, true, false, 'any', {
    program: 'Gmsh',
    about: 'hexahedra, MSH 4.1',
    file: 'NAME.msh',
  }),
  xdmf: row('export', 'application/zip', true, false, false, 'any', {
    program: 'XDMF',
    about: 'hexahedra for ParaView, meshio and dolfinx',
    file: 'NAME.xdmf.zip',
  }),
  'csx.xml': row('export', 'application/xml', false, false, true, 'any', {
    program: 'openEMS',
    about: 'lines, materials and boxes',
    file: 'NAME.csx.xml',
  }),
  in: row('export', 'application/zip', true, false, true, 'equal', {
    program: 'gprMax 4',
    about: 'an array of materials',
    file: 'NAME.in.zip',
  }),
  'geometry.xml': row('export', 'application/xml', false, false, true, 'equal', {
    program: 'OpenMC',
    about: 'a lattice',
    file: 'geometry.xml',
  }),
  nrrd: row('export', 'application/octet-stream', true, false, false, 'equal', {
    program: 'NRRD',
    about: 'an image for 3D Slicer and ITK',
    file: 'NAME.nrrd',
  }),
  vox: row('export', 'application/octet-stream', false, false, false, 'equal', {
    program: 'MagicaVoxel',
    about: 'coloured cubes, to look at',
    file: 'NAME.vox',
  }),
  glb: row('export', 'application/octet-stream', false, false, false, 'any', {
    program: 'glTF',
    about: 'closed surfaces of cells, with names and colours',
    file: 'NAME.glb',
  }),
  stl: row('export', 'application/octet-stream', false, true, false, 'any', {
    program: 'STL',
    about: 'closed surfaces of cells',
    file: 'NAME.stl',
  }),
  binvox: row('export', 'application/octet-stream', false, false, false, 'cubes', {
    program: 'binvox',
    about: 'a cube of bits, to look at',
    file: 'NAME.binvox',
  }),
});

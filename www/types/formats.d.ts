/** Names of formats. Made by `npm run options` of docs/formats.json. */

/** Files of the flags. */
export type CellsFormat = 'vti' | 'vtr' | 'npy' | 'npz' | 'raw' | 'hxc' | 'zarr';
/** Files of what a job asked for besides. */
export type MeasuredFormat =
  | 'links.npz'
  | 'links.h5'
  | 'links'
  | 'staggered.npz'
  | 'conformal.npz'
  | 'distance.npz'
  | 'distance.vti'
  | 'distance.vtr'
  | 'distance.npy'
  | 'distance.h5'
  | 'distance.zarr'
  | 'tensors.npz'
  | 'fractions.npz'
  | 'fractions.vti'
  | 'fractions.vtr'
  | 'fractions.npy'
  | 'fractions.zarr';
/** Files of other programs. */
export type ProgramFormat =
  | 'foam'
  | 'eb'
  | 'inp'
  | 'msh'
  | 'xdmf'
  | 'csx.xml'
  | 'in'
  | 'geometry.xml'
  | 'nrrd'
  | 'vox'
  | 'glb'
  | 'stl'
  | 'binvox';

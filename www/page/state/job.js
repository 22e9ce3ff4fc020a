/** The job that the page's fields ask for, in the form of the public interface. */
import { DEFAULTS, state } from './state.js';

/**
 * @typedef {import('hexcast').Job} Job
 * @typedef {Omit<import('hexcast').GeometryJob, 'source'> & { source: import('./state.js').Surface, file: string }} SurfaceJob
 * @typedef {'name' | 'flag' | 'priority' | 'fill' | 'split' | 'scale' | 'rotate' | 'about' | 'translate' | 'material' | SizingKey} GeometryKey
 * @typedef {'max_size' | 'min_cells' | 'metal'} SizingKey keys of geometries that only graded lines use
 */

/** Geometry keys in the order in which they are written, with the value that is left out. @type {[GeometryKey, unknown][]} */
export const GEOMETRY_KEYS = [
  ['name', null],
  ['flag', null],
  ['priority', 0],
  ['fill', null],
  ['split', false],
  ['scale', null],
  ['rotate', null],
  ['about', null],
  ['translate', null],
  ['material', null],
  ['max_size', null],
  ['min_cells', null],
  ['metal', false],
];

/** @type {readonly SizingKey[]} */
export const SIZING_KEYS = ['max_size', 'min_cells', 'metal'];

/** The job with its surfaces as sources: that of the page, or of other settings and geometries. @param {Pick<import('./state.js').State, 'settings' | 'geometries'>} of */
export function currentJob({ settings, geometries } = state) {
  /** @type {Omit<Job, 'geometries'> & { geometries: SurfaceJob[] }} */
  const job = { geometries: geometries.map((geometry) => geometryJob(geometry, settings.sizing)) };
  // listed lines are the domain
  if (settings.sizing === 'lines') job.lines = listed(settings.lines);
  else {
    if (settings.domain) job.domain = settings.domain;
    if (hasPadding(settings.padding))
      job.padding = settings.padding_by === 'cells' ? { cells: settings.padding } : { length: settings.padding };
  }
  Object.assign(job, sizing(settings));
  if (settings.rule !== 'parity') job.rule = settings.rule;
  if (settings.open !== 'winding') job.open = settings.open;
  if (settings.fill !== 'centre') job.fill = settings.fill;
  if (settings.close_gaps > 0) job.close_gaps = settings.close_gaps;
  if (settings.certify) job.certify = true;
  if (settings.certify && settings.thin_cells !== DEFAULTS.thin_cells) job.thin_cells = settings.thin_cells;
  Object.assign(job, measured(settings));
  if (settings.axis !== 'auto') job.axis = settings.axis;
  if (settings.unit) job.unit = settings.unit;
  if (settings.background) job.background = { material: settings.background };
  return job;
}

/** @param {import('./state.js').Geometry} geometry @param {import('./state.js').Settings['sizing']} sizing */
function geometryJob(geometry, sizing) {
  /** @type {SurfaceJob} */
  const job = { source: geometry.surface, file: geometry.source.name };
  for (const [key, unsaid] of GEOMETRY_KEYS) {
    const value = geometry[key];
    // solids have the names that they have in the file
    if (key === 'name' && geometry.split) continue;
    // a job without graded lines refuses them
    if (SIZING_KEYS.some((one) => one === key) && sizing !== 'graded') continue;
    // a job refuses a centre of what does not rotate
    if (key === 'about' && !geometry.rotate) continue;
    if (value !== unsaid && value !== null && value !== undefined) Object.assign(job, { [key]: value });
  }
  return job;
}

/** @param {import('./state.js').Lists | null} lines */
function listed(lines) {
  return lines ? { x: lines.x, y: lines.y, z: lines.z } : undefined;
}

/** One of the other five ways to say how fine. @param {import('./state.js').Settings} settings @returns {Partial<Job>} */
function sizing({ sizing, cells, dims, cell_size, ...more }) {
  if (sizing === 'lines') return {};
  if (sizing === 'graded') return { graded: graded(more) };
  if (sizing === 'dims') return { dims: dims ?? undefined };
  if (sizing === 'cell_size' || sizing === 'max_cell_size') return { [sizing]: cell_size };
  return { cells };
}

/** What is not by default. @param {Pick<import('./state.js').Settings, 'graded' | 'min_size' | 'growth' | 'absorbing'>} settings */
function graded({ graded, min_size, growth, absorbing }) {
  /** @type {import('hexcast').GradedJob} */
  const job = { max_size: graded ?? 1 };
  if (min_size !== null) job.min_size = min_size;
  if (growth !== DEFAULTS.growth) job.growth = growth;
  if (String(absorbing) !== '0') job.absorbing = absorbing;
  return job;
}

/** What is measured beside the cells. @param {import('./state.js').Settings} settings @returns {Partial<Job>} */
function measured({
  links,
  stencil,
  fluid,
  fractions,
  fraction_rays: rays,
  fraction_faces: faces,
  fraction_surfaces: surfaces,
  fraction_edges: edges,
  fraction_centroids: centroids,
  staggered,
  conformal,
  distance,
  tensors,
  cut_cells,
  cut_fluid,
}) {
  /** @type {import('hexcast').FractionsJob} */
  const method = rays === 0 ? { ...(edges && { edges }), ...(centroids && { centroids }) } : { rays };
  return {
    ...(links ? { links: { stencil, ...(String(fluid) === '0' ? {} : { fluid }) } } : {}),
    ...(fractions ? { fractions: { ...method, faces, surfaces } } : {}),
    ...(staggered ? { staggered } : {}),
    ...(conformal ? { conformal: {} } : {}),
    ...(distance ? { distance: {} } : {}),
    ...(tensors ? { tensors: {} } : {}),
    ...(cut_cells ? { cut_cells: { ...(cut_fluid === null ? {} : { fluid: cut_fluid }), boundary: true } } : {}),
  };
}

/**
 * Everything that the cells of a job depend on; of surfaces, the hash of their bytes.
 *
 * @param {import('./state.js').ShownJob} job
 */
export function keyOfCells({ geometries, ...rest }) {
  return JSON.stringify([
    rest,
    geometries.map(({ source, name: _, file: _file, ...settings }) => ({ ...settings, blake3: source?.info.blake3 })),
  ]);
}

/** The same without what only files say: the unit, and what parts are made of. @param {import('./state.js').ShownJob & { unit?: unknown, background?: unknown }} job */
export function keyWithoutFacts({ unit: _, background: _background, geometries, ...rest }) {
  return keyOfCells({ ...rest, geometries: geometries.map((geometry) => ({ ...geometry, material: undefined })) });
}

/** @param {number | number[]} padding */
function hasPadding(padding) {
  return [padding].flat().some((number) => number !== 0);
}

/** The job of the mesh while all its surfaces are on the page; facets are named in them. */
export function jobOfMesh() {
  const job = /** @type {Job | null} */ (state.job);
  const isHere = (/** @type {{ source?: unknown }} */ { source }) => state.geometries.some(({ surface }) => surface === source);
  return state.mesh && job?.geometries.every(isHere) ? job : null;
}

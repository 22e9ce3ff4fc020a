/** Which meshes are made without a click: those that take a moment, and that nobody cancelled. */
import { wrongField } from '../settings/wrong_fields.js';
import { keyOfCells, keyWithoutFacts } from '../state/job.js';
import { state } from '../state/state.js';

/** More cells, facets or seconds are made by a click, which says what they cost. */
const MOST = { cells: 1e8, facets: 2e6, seconds: 3 };

/** Whether the page meshes by itself what the estimate is of. */
export function isLive() {
  const { live, estimate, mesher, geometries } = state;
  if (!live || !mesher || !estimate?.result || wrongField() !== null) return false;
  return isQuick(estimate.result, geometries);
}

/** Whether a mesh of these geometries takes a moment. @param {import('hexcast').Estimate} estimate @param {import('../state/state.js').Geometry[]} geometries */
export function isQuick({ cells, seconds }, geometries) {
  const n_facets = geometries.reduce((sum, { info }) => sum + info.facets, 0);
  return cells <= MOST.cells && n_facets <= MOST.facets && (seconds ?? 0) <= MOST.seconds;
}

/** Whether the mesh that is shown is of this job. @param {import('../state/state.js').ShownJob} job */
export function isShown(job) {
  const made = state.job;
  return state.mesh !== null && made !== null && hasSources(made) && keyOfCells(made) === keyOfCells(job);
}

/**
 * Whether the mesh of a job has the cells that are shown, and only files say otherwise what lengths are, or what parts are made of:
 * who answered that for a file is not asked for a mesh, too.
 *
 * @param {import('../state/state.js').ShownJob} job
 */
export function isSaidOtherwise(job) {
  const made = state.mesh && state.job && hasSources(state.job) ? state.job : null;
  return made !== null && wrongField() === null && !isShown(job) && keyWithoutFacts(made) === keyWithoutFacts(job);
}

/** A mesh from a column file has no source whose settings could be compared. @param {import('../state/state.js').ShownJob} job */
export function hasSources({ geometries }) {
  return geometries.every(({ source }) => source);
}

/** Whether a mesh of this job was cancelled, or failed, with this mesher, or gave way to a file of columns. @param {import('../state/state.js').ShownJob} job */
function isLeft(job) {
  return state.left?.mesher === state.mesher && state.left?.key === keyOfCells(job);
}

/** Whether the mesh of the estimate is to be made now. An estimate of some of the files was made while others were read. */
export function isWanted() {
  const job = state.estimate?.job;
  const { geometries } = state;
  const hasAll =
    job?.geometries.length === geometries.length && job.geometries.every(({ source }, at) => source === geometries[at].surface);
  return hasAll && (isLive() || isSaidOtherwise(job)) && !isShown(job) && !isLeft(job);
}

/** Whether the mesh of these fields is shown, or comes without a click. @param {import('../state/state.js').ShownJob} job */
export function comesByItself(job) {
  return (isLive() && isShown(job)) || ((isLive() || isSaidOtherwise(job)) && !isLeft(job));
}

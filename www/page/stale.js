/** The notice that the mesh was made with other settings than those in the fields. */
import { buttonOf, byId } from './dom.js';
import { currentJob } from './job.js';
import { on, state } from './state.js';

/** Compares the job of the mesh with that of the fields whenever either changes. */
export function startStale() {
  byId('mesh-again').addEventListener('click', () => byId('run').click());
  on(['settings', 'geometries', 'mesh', 'phase', 'fields', 'estimate'], show);
}

function show() {
  const { job } = state;
  const isStale = state.mesh !== null && job !== null && isComparable(job) && keyOf(job) !== keyOf(currentJob());
  byId('stale').hidden = !isStale;
  document.body.classList.toggle('stale', isStale);
  buttonOf('mesh-again').disabled = buttonOf('run').disabled;
}

/** A mesh from a column file has no source whose settings could be compared. @param {import('./state.js').ShownJob} job */
function isComparable(job) {
  return job.geometries.every(({ source }) => source);
}

/**
 * Everything that the cells and the files depend on; of surfaces, the hash of their bytes.
 *
 * @param {import('./state.js').ShownJob} job
 */
function keyOf({ geometries, ...rest }) {
  return JSON.stringify([rest, geometries.map(({ source, ...settings }) => ({ ...settings, sha256: source?.info.sha256 }))]);
}

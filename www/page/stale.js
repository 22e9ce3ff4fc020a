/** Says so where what is shown was made with other settings than those in the fields. */
import { byId } from './dom.js';
import { currentJob } from './job.js';
import { on, state } from './state.js';

/** Compares the job of the mesh with that of the fields whenever either changes. */
export function startStale() {
  byId('mesh-again').addEventListener('click', () => byId('run').click());
  on(['settings', 'geometries', 'mesh', 'phase', 'fields', 'estimate'], show);
}

function show() {
  const isStale = Boolean(state.mesh) && isComparable(state.job) && keyOf(state.job) !== keyOf(currentJob());
  byId('stale').hidden = !isStale;
  document.body.classList.toggle('stale', isStale);
  byId('mesh-again').disabled = byId('run').disabled;
}

/** A mesh from a column file was made elsewhere: no field speaks of it. */
function isComparable(job) {
  return job.geometries.every(({ source }) => source);
}

/** Everything that the cells and the files follow from; of surfaces, the hash of their bytes. */
function keyOf({ geometries, ...rest }) {
  return JSON.stringify([rest, geometries.map(({ source, ...settings }) => ({ ...settings, sha256: source.info.sha256 }))]);
}

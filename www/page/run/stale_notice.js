/** The notice that the mesh was made with other settings than those in the fields. */
import { buttonOf, byId } from '../elements/dom.js';
import { currentJob } from '../state/job.js';
import { on, state } from '../state/state.js';

/** Compares the job of the mesh with that of the fields whenever either changes. */
export function startStale() {
  byId('mesh-again').addEventListener('click', () => byId('run').click());
  on(['settings', 'geometries', 'mesh', 'phase', 'fields', 'estimate'], show);
}

function show() {
  const { job } = state;
  // a mesh from a column file has no source whose settings could be compared
  const made = state.mesh && job?.geometries.every(({ source }) => source) ? job : null;
  const isStale = made !== null && keyOf(made) !== keyOf(currentJob());
  const isRenamed = made !== null && !isStale && namesOf(made) !== namesOf(currentJob());
  byId('stale').hidden = !isStale && !isRenamed;
  byId('stale-text').textContent = isStale
    ? 'Made with other settings: pictures, numbers and files are those of the last mesh.'
    : 'The cells are right; the files of this mesh have the former names.';
  document.body.classList.toggle('stale', isStale);
  buttonOf('mesh-again').disabled = buttonOf('run').disabled;
}

/** @param {import('../state/state.js').ShownJob} job */
function namesOf({ geometries }) {
  return JSON.stringify(geometries.map(({ name }) => name));
}

/**
 * Everything that the cells depend on; of surfaces, the hash of their bytes.
 *
 * @param {import('../state/state.js').ShownJob} job
 */
function keyOf({ geometries, ...rest }) {
  return JSON.stringify([
    rest,
    geometries.map(({ source, name: _, file: _file, ...settings }) => ({ ...settings, blake3: source?.info.blake3 })),
  ]);
}

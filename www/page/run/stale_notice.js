/** The notice that the mesh was made with other settings than those in the fields. */
import { buttonOf, byId } from '../elements/dom.js';
import { currentJob } from '../state/job.js';
import { on, state } from '../state/state.js';
import { comesByItself, hasSources, isShown } from './live_rule.js';

/** Compares the job of the mesh with that of the fields whenever either changes. */
export function startStale() {
  byId('mesh-again').addEventListener('click', () => byId('run').click());
  on(['settings', 'geometries', 'mesh', 'phase', 'fields', 'estimate', 'live'], show);
}

function show() {
  const { job } = state;
  const made = state.mesh && job && hasSources(job) ? job : null;
  const isOther = made !== null && !isShown(currentJob());
  const isStale = isOther && !comesByItself(currentJob());
  const isRenamed = made !== null && !isOther && namesOf(made) !== namesOf(currentJob());
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

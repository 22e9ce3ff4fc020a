/** Meshes whatever changes, as long as that takes a moment: one mesh after another, each of the last estimate; what came between is left out. */
import { byId, inputOf, onInput, pause } from '../elements/dom.js';
import { change, on, state } from '../state/state.js';
import { cellsAreDrawn } from '../view/view3d.js';
import { coarser, startCoarse, takePace, untilRest } from './coarse.js';
import { isShown, isWanted } from './live_rule.js';
import { makeMesh } from './run.js';

/** The key of the choice in the browser's storage: it is the user's, and no part of the job. */
const CHOICE = 'hexcast-live';
/** Milliseconds without another mesh after which a screen reader hears of the last. */
const QUIET = 500;
/** Milliseconds between two looks at whether the slider moves. */
const STEP = 30;

let isRunning = false;
/** The job with coarser cells that is meshed, or was meshed last, while the slider moves. @type {import('./coarse.js').Job | null} */
let coarse = null;
/** @type {ReturnType<typeof setTimeout> | undefined} */
let speaking;

/** Follows estimates, and connects the choice. */
export function startLive() {
  change('live', { live: readChoice() });
  inputOf('live').checked = state.live;
  onInput('live', 'change', ({ checked }) => {
    keepChoice(checked);
    change('live', { live: checked });
  });
  startCoarse();
  on('mesh', showWhetherCoarse);
  on(['estimate', 'phase', 'live'], follow);
}

async function follow() {
  if (isRunning) return;
  isRunning = true;
  clearTimeout(speaking);
  try {
    while (state.phase === 'idle' && isWanted()) {
      const { job, result } = /** @type {import('../state/state.js').Estimated} */ (state.estimate);
      coarse = result ? coarser(job, result.dims) : null;
      if (coarse && isShown(coarse)) {
        await pause(Math.min(untilRest(), STEP));
        continue;
      }
      const [start, wanted] = [performance.now(), coarse ?? job];
      // who ended it goes on first
      if (!(await makeMesh('updating', wanted, coarse ? null : (result ?? null)))) return;
      // it may have failed
      if (state.mesh && state.job === wanted) takePace(coarse !== null, state.mesh.dims, performance.now() - start);
      // a picture that nobody has seen is not replaced
      await cellsAreDrawn();
    }
  } finally {
    isRunning = false;
  }
  speaking = setTimeout(speak, QUIET);
}

/** Cells that are coarse because the slider moves are not those that somebody wants to have in a file. */
function showWhetherCoarse() {
  const isCoarse = coarse !== null && state.job === coarse;
  byId('leave').inert = isCoarse;
  document.body.toggleAttribute('data-coarse', isCoarse);
}

/** What was said of the last mesh, aloud. */
function speak() {
  const status = byId('status');
  status.ariaLive = 'polite';
  status.replaceChildren(...(status.textContent ? [status.textContent] : []));
}

function readChoice() {
  try {
    return localStorage.getItem(CHOICE) !== 'off';
  } catch {
    // the user forbids storage
    return true;
  }
}

/** @param {boolean} isLive */
function keepChoice(isLive) {
  try {
    if (isLive) localStorage.removeItem(CHOICE);
    else localStorage.setItem(CHOICE, 'off');
  } catch {
    // it holds for this visit
  }
}

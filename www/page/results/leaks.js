/** Leaks: two points, typed or picked in a slice, the path between them or that there is none. */
import { buttonOf, byId, inputOf, make } from '../elements/dom.js';
import { showFinding } from './findings.js';
import { count, measure, numbersOf } from '../text/format.js';
import { showError } from '../elements/messages.js';
import { centreOf, placeText } from '../text/places.js';
import { isShown, showPanes } from '../view/panes.js';
import { pickNext } from '../view/pick.js';
import { jobOfMesh } from '../state/job.js';
import { change, on, state } from '../state/state.js';

/** @typedef {import('hexcast').Leak} Leak @typedef {import('../state/state.js').Triple} Triple */

/** The ends of the path, as the fields are named. */
const ENDS = /** @type {const} */ (['from', 'to']);

/** Connects the fields. */
export function startLeaks() {
  byId('leak-form').addEventListener('submit', (event) => {
    event.preventDefault();
    find();
  });
  for (const end of ENDS) byId(`leak-pick-${end}`).addEventListener('click', () => pick(end));
  for (const id of ['leak-from', 'leak-to', 'leak-flags']) inputOf(id).addEventListener('input', () => isRight(id));
  on('mesh', () => byId('leak-answer').replaceChildren());
}

/** Lets a cell be picked as an end. @param {'from' | 'to'} end */
function pick(end) {
  const axis = /** @type {const} */ (['z', 'y', 'x']).find(isShown) ?? 'z';
  if (!isShown(axis)) showPanes(axis);
  byId(`canvas-${axis}`).focus();
  const what = `Click the cell where paths ${end === 'from' ? 'begin' : 'end'}, or Enter at the crosshair`;
  pickNext((cell) => {
    const { mesh } = state;
    if (!mesh) return;
    inputOf(`leak-${end}`).value = placeText(centreOf(mesh.lines, cell), mesh.lines);
    isRight(`leak-${end}`);
    buttonOf(`leak-pick-${end}`).focus();
  }, what);
}

/** Whether a field holds what it must; it says what else. @param {string} id */
function isRight(id) {
  const input = inputOf(id);
  const numbers = numbersOf(input.value);
  const isFlag = (/** @type {number} */ flag) => Number.isInteger(flag) && flag >= 0 && flag <= 255;
  const right = id === 'leak-flags' ? numbers?.every(isFlag) : numbers?.length === 3;
  input.setCustomValidity(right ? '' : id === 'leak-flags' ? 'these are flags from 0 to 255' : 'this is a point: x, y and z');
  return right;
}

async function find() {
  const { mesh } = state;
  const isWrong = ['leak-from', 'leak-to', 'leak-flags'].find((id) => !isRight(id));
  if (!mesh || isWrong) return isWrong && inputOf(isWrong).reportValidity();
  const [from, to] = ENDS.map((end) => /** @type {Triple} */ (numbersOf(inputOf(`leak-${end}`).value)));
  const flags = numbersOf(inputOf('leak-flags').value) ?? [];
  const job = jobOfMesh();
  const answer = byId('leak-answer');
  answer.replaceChildren('Looking …');
  buttonOf('leak-find').disabled = true;
  try {
    const leak = await mesh.leak({ from, to, flags, ...(job ? { job } : {}) });
    if (mesh !== state.mesh) return undefined;
    change('leak', { leak });
    answer.replaceChildren(...inWords(leak).map((text) => make('span', {}, `${text} `)));
    if (leak.narrowest) showFinding('leak');
  } catch (error) {
    answer.replaceChildren();
    showError(error);
  } finally {
    buttonOf('leak-find').disabled = false;
  }
  return undefined;
}

/** @param {Leak} leak */
function inWords({ is_tight, flags, from, to, path, narrowest, unit }) {
  const through = `flag${flags.length === 1 ? '' : 's'} ${flags.join(', ')}`;
  const between = `leads from cell ${from.cell.join(', ')} to cell ${to.cell.join(', ')} through ${through}.`;
  if (is_tight || !path)
    return [
      `No path ${between}`,
      `${count(from.n_cells)} cells are reached from the first point, ${count(to.n_cells)} from the second.`,
    ];
  const facts = `A path of ${count(path.steps)} steps, ${measure(path.length, unit)} long, ${between}`;
  return narrowest ? [facts] : [facts, 'A cube of 64 cells passes: no place on its way is narrow.'];
}

/** Lines of the user's own: a file of lists, as `hexcast mesh --lines` reads it. */
import { byId } from '../elements/dom.js';
import { set, state } from '../state/state.js';

/** @typedef {import('../state/state.js').Lists} Lists */

/** Name of the file that a link has lines of, until it is opened. @type {string | null} */
let expected = null;

/** Connects the button that removes them. */
export function startLines() {
  byId('remove-lines').addEventListener('click', () => set({ sizing: 'cells', lines: null }));
}

/** Takes the lines of a file. @param {File} file */
export async function takeLines(file) {
  const lines = listsOf(await file.text());
  expectLines(null);
  set({ sizing: 'lines', lines: { file: file.name, ...lines }, domain: null });
}

/** Three lists of numbers; whether lines ascend, and are not too many, the estimate says. @param {string} text @returns {Omit<Lists, 'file'>} */
function listsOf(text) {
  const form = { hint: 'write {"x": [0, 0.5, 2], "y": [...], "z": [...]}: the lines of each axis, ascending' };
  let lines;
  try {
    lines = JSON.parse(text);
  } catch (error) {
    throw Object.assign(new Error(`this is not JSON: ${/** @type {Error} */ (error).message}`), form);
  }
  for (const axis of ['x', 'y', 'z']) {
    const list = lines?.[axis];
    if (!Array.isArray(list)) throw Object.assign(new Error(`these are no lines: there is no list "${axis}"`), form);
    const at = list.findIndex((line) => typeof line !== 'number');
    if (at >= 0) throw Object.assign(new Error(`line ${at} of "${axis}" is ${JSON.stringify(list[at])}, not a number`), form);
  }
  const { x, y, z, ...more } = lines;
  const [other] = Object.keys(more);
  if (other !== undefined) throw Object.assign(new Error(`the lines have a key "${other}" besides x, y and z`), form);
  return { x, y, z };
}

/** Remembers the file of a link, or forgets it. @param {string | null} file */
export function expectLines(file) {
  expected = file;
}

/** The file of lines that a link has to name: the one in use, or the one that is waited for. */
export function linesFile() {
  const { sizing, lines } = state.settings;
  return sizing === 'lines' ? (lines?.file ?? null) : expected;
}

/** The file of lines that is waited for. */
export function waitedLines() {
  return expected;
}

/** Writes which lines are used. */
export function showLines() {
  const { sizing, lines } = state.settings;
  const isListed = sizing === 'lines' && lines !== null;
  byId('lines-given').hidden = !isListed;
  byId('remove-lines').hidden = !isListed;
  byId('domain-choice').hidden = isListed;
  if (lines)
    byId('lines-given').textContent = `${lines.file}: ${[lines.x, lines.y, lines.z].map((list) => list.length).join(', ')} lines`;
}

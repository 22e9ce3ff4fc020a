/** The parts that are selected in the list: what is set for one of them is set for all. Ctrl or Shift and a click, or the keys, select them. */
import { byId } from '../elements/dom.js';
import { change, flagsOf, on, state } from '../state/state.js';

/** @typedef {import('../state/state.js').Geometry} Geometry */

/** What several parts may share; a name, a place and the solids of a file are of one. @type {readonly string[]} */
const SHARED = ['flag', 'priority', 'fill', 'material', 'max_size', 'min_cells', 'metal'];

/** Their ids. @type {Set<number>} */
let selected = new Set();
/** Where a range begins. @type {number | undefined} */
let anchor;

/** Connects the list and the line above it. */
export function startSelected() {
  const list = byId('geometries');
  // before the fields of a row take them
  for (const event of /** @type {const} */ (['mousedown', 'click'])) list.addEventListener(event, takeClick, true);
  list.addEventListener('keydown', takeKey);
  byId('selected-show').addEventListener('click', () => setSeen(true));
  byId('selected-hide').addEventListener('click', () => setSeen(false));
  byId('selected-none').addEventListener('click', () => {
    const last = selected.values().next().value;
    select([]);
    handleOf(last)?.focus();
  });
  on(['mesh', 'geometries'], showSelected);
}

/** The geometries that an edit of one changes. @param {number} id @param {Partial<Geometry>} patch @returns {Set<number>} */
export function editedWith(id, patch) {
  return selected.has(id) && Object.keys(patch).every((key) => SHARED.includes(key)) ? selected : new Set([id]);
}

/** Marks the rows, and says how many there are where that changed. */
export function showSelected() {
  selected = new Set(state.geometries.map(({ id }) => id).filter((id) => selected.has(id)));
  for (const { id } of state.geometries) {
    const handle = handleOf(id);
    if (handle) handle.ariaPressed = String(selected.has(id));
  }
  const n = selected.size;
  byId('selected').hidden = n < 2;
  for (const id of ['selected-show', 'selected-hide']) byId(id).hidden = !state.mesh;
  const text = n < 2 ? '' : `${n} parts are selected: what is set for one is set for all.`;
  if (byId('selected-count').textContent === text) return;
  byId('selected-count').textContent = text;
  byId('status').textContent = text || 'At most one part is selected.';
}

/** @param {number | undefined} id @returns {HTMLElement | null} */
function handleOf(id) {
  return document.querySelector(`.geometry[data-id="${id}"] .handle`);
}

/** @param {Iterable<number>} ids */
function select(ids) {
  selected = new Set(ids);
  showSelected();
}

/** All from the anchor to a part. @param {number} id */
function selectTo(id) {
  const ids = state.geometries.map((geometry) => geometry.id);
  const [from, to] = [Math.max(0, ids.indexOf(anchor ?? id)), ids.indexOf(id)];
  select(ids.slice(Math.min(from, to), Math.max(from, to) + 1));
}

/** @param {MouseEvent} event */
function takeClick(event) {
  const target = /** @type {HTMLElement} */ (event.target);
  const row = target.closest('.geometry > .row:first-child');
  const isAdded = event.ctrlKey || event.metaKey;
  const isKey = isAdded || event.shiftKey;
  if (!row || !(isKey || (event.type === 'click' && target.closest('.handle')))) return;
  event.preventDefault();
  event.stopPropagation();
  if (event.type === 'mousedown') return;
  const id = Number(/** @type {HTMLElement} */ (row.parentElement).dataset.id);
  handleOf(id)?.focus();
  if (event.shiftKey) return selectTo(id);
  anchor = id;
  select(selected.has(id) ? [...selected].filter((one) => one !== id) : [...selected, id]);
}

/** Arrow keys go from row to row, with Shift they select; Ctrl+A selects all, Escape none. @param {KeyboardEvent} event */
function takeKey(event) {
  const target = /** @type {HTMLElement} */ (event.target);
  if (!target.matches('.handle') || event.altKey) return;
  const ids = state.geometries.map(({ id }) => id);
  const at = ids.indexOf(Number(/** @type {HTMLElement} */ (target.closest('.geometry')).dataset.id));
  const by = { ArrowUp: -1, ArrowDown: 1 }[event.key];
  if (by) {
    const next = ids[at + by];
    if (event.shiftKey && selected.size === 0) anchor = ids[at];
    if (next !== undefined) handleOf(next)?.focus();
    if (next !== undefined && event.shiftKey) selectTo(next);
  } else if (event.key.toLowerCase() === 'a' && (event.ctrlKey || event.metaKey)) select(ids);
  else if (event.key === 'Escape' && selected.size > 0) select([]);
  else return;
  event.preventDefault();
}

/** Shows or hides the cells of all. @param {boolean} isSeen */
function setSeen(isSeen) {
  const hidden = new Set(state.hidden);
  for (const geometry of state.geometries) {
    if (selected.has(geometry.id)) for (const flag of flagsOf(geometry)) isSeen ? hidden.delete(flag) : hidden.add(flag);
  }
  change('legend', { hidden });
}

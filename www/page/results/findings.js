/** The list of what the mesh found: a line each, with a button that flies there; previous and next go from one to the other. */
import { buttonOf, byId, make } from '../elements/dom.js';
import { findingsOf } from './finding_texts.js';
import { change, on, state } from '../state/state.js';
import { showPlace } from '../view/crosshair.js';
import { isShown, showPanes } from '../view/panes.js';
import { lookAt } from '../view/view3d.js';

/** Connects the list. */
export function startFindings() {
  on('mesh', () => change('leak', { leak: null }));
  on('leak', () => change('findings', { findings: collected(), finding: -1 }));
  on('findings', show);
  byId('finding-previous').addEventListener('click', () => step(-1));
  byId('finding-next').addEventListener('click', () => step(1));
  byId('findings-count').addEventListener('click', goToList);
}

function collected() {
  return state.mesh ? findingsOf(state.mesh.report, state.leak) : [];
}

function show() {
  const { findings } = state;
  byId('findings').hidden = findings.length === 0;
  byId('findings-count').hidden = findings.length === 0;
  byId('findings-count').textContent = `${findings.length} finding${findings.length === 1 ? '' : 's'}`;
  byId('finding-list').replaceChildren(...findings.map(line));
  for (const id of ['finding-previous', 'finding-next']) buttonOf(id).disabled = findings.every(({ place }) => !place);
  byId('finding-at').textContent = '';
}

/** The remedies of all findings of a kind that are the same with other parts. @param {import('../state/state.js').Finding['kind']} kind @param {import('../state/state.js').Remedy} remedy */
function together(kind, { label, key }) {
  const all = state.findings.filter((finding) => finding.kind === kind).flatMap(({ remedies }) => remedies);
  const alike = all.filter((remedy) => key !== undefined && remedy.label === label);
  return alike.filter((remedy, at) => alike.findIndex((other) => other.key === remedy.key) === at);
}

/** Shows the list, which may be below the picture, and goes on from there by key. */
function goToList() {
  byId('findings').scrollIntoView({ block: 'nearest' });
  byId('finding-list').focus({ preventScroll: true });
}

/** @param {import('../state/state.js').Finding} finding @param {number} index */
function line({ kind, subject, text, place, remedies }, index) {
  const item = make('li', { 'data-kind': kind }, make('p', {}, text));
  const button = (/** @type {string} */ label, /** @type {() => void} */ click) =>
    make(
      'button',
      { type: 'button', className: 'small', 'aria-label': `${label}: ${subject}, finding ${index + 1}`, on: { click } },
      label,
    );
  const row = make('div', { className: 'row' });
  if (place) row.append(button('Show the place', () => showIn3d(index)));
  for (const remedy of remedies) {
    row.append(button(remedy.label, remedy.act));
    const all = together(kind, remedy);
    if (all.length > 1 && all[0] === remedy)
      row.append(button(`${remedy.label}: all ${all.length}`, () => all.forEach(({ act }) => act())));
  }
  if (row.childElementCount > 0) item.append(row);
  return item;
}

/** @param {number} index */
function showIn3d(index) {
  if (!isShown('3d')) showPanes('3d');
  fly(index);
}

/** Goes to the next finding that has a place, around the ends, in the view that is shown. @param {1 | -1} by */
function step(by) {
  const { findings } = state;
  let at = state.finding < 0 && by < 0 ? 0 : state.finding;
  do at = (at + by + findings.length) % findings.length;
  while (!findings[at].place);
  fly(at);
}

/** Shows the first finding of a kind in the view that is shown. @param {import('../state/state.js').Finding['kind']} kind */
export function showFinding(kind) {
  fly(state.findings.findIndex((finding) => finding.kind === kind));
}

/** Moves all panes to a finding, marks it and says it. @param {number} index */
function fly(index) {
  const { place, text } = state.findings[index] ?? {};
  if (!place) return;
  state.finding = index;
  for (const [at, item] of [...byId('finding-list').children].entries()) {
    at === index ? item.setAttribute('aria-current', 'true') : item.removeAttribute('aria-current');
  }
  byId('finding-at').textContent = `${index + 1} of ${state.findings.length}: ${text}`;
  lookAt(place);
  showPlace(place);
}

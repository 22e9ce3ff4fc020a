/** The problems of a mesh: a card each, with a picture of the place, which leads there, what it means, and offers of what helps. */
import { buttonOf, byId, make } from '../elements/dom.js';
import { findingsOf } from './finding_texts.js';
import { previewOn, startPreviews, take } from './offer_preview.js';
import { pictureOf } from './place_pictures.js';
import { togetherOf } from './remedies.js';
import { change, on, state } from '../state/state.js';
import { showPlace } from '../view/crosshair.js';
import { isShown, showPanes } from '../view/panes.js';
import { lookAt } from '../view/view3d.js';

/** @typedef {import('../state/state.js').Finding} Finding @typedef {import('../state/state.js').Remedy} Remedy */

/** What was done last of what was offered, until something else is edited. */
let done = '';
let isActing = false;

/** Connects the list. */
export function startFindings() {
  on('mesh', () => change('leak', { leak: null }));
  on('leak', () => change('findings', { findings: collected(), finding: -1 }));
  on('findings', show);
  startPreviews();
  on(['settings', 'geometries'], () => {
    if (!isActing && done) say('');
  });
  byId('finding-previous').addEventListener('click', () => step(-1));
  byId('finding-next').addEventListener('click', () => step(1));
  byId('findings-count').addEventListener('click', goToList);
  byId('finding-undo').addEventListener('click', () => byId('undo').click());
}

function collected() {
  return state.mesh ? findingsOf(state.mesh.report, state.leak) : [];
}

function show() {
  const { findings } = state;
  byId('findings').hidden = findings.length === 0 && !done;
  const counter = buttonOf('findings-count');
  counter.hidden = !state.mesh;
  counter.disabled = findings.length === 0;
  counter.textContent =
    findings.length === 0 ? 'No problems found' : `${findings.length} problem${findings.length === 1 ? '' : 's'}`;
  byId('finding-list').replaceChildren(...findings.map(card));
  for (const id of ['finding-previous', 'finding-next']) {
    buttonOf(id).disabled = findings.every(({ place }) => !place);
    byId(id).hidden = findings.length === 0;
  }
  byId('finding-at').textContent = '';
}

/** Says what was done, with a button that undoes it. @param {string} what */
function say(what) {
  done = what;
  byId('finding-done').textContent = what && `Done: ${what}.`;
  byId('finding-undo').hidden = !what;
  byId('findings').hidden = state.findings.length === 0 && !what;
}

/** Shows the list, which may be below the picture, and goes on from there by key. */
function goToList() {
  byId('findings').scrollIntoView({ block: 'nearest' });
  byId('finding-list').focus({ preventScroll: true });
}

/** The remedy of a finding, and where others of its kind have the same, one for all. @param {Finding} finding @param {Remedy} remedy @returns {Remedy[]} */
function offersOf({ kind }, remedy) {
  const { label, changes } = remedy;
  const alike = state.findings
    .filter((other) => other.kind === kind)
    .flatMap(({ remedies }) => remedies.filter((other) => other.label === label));
  const all = alike.flatMap((other) => other.changes ?? []);
  if (!changes || all.length < 2) return [remedy];
  const together = togetherOf(`${label}: all ${all.length}`, all);
  const isOne = all.every((other) => JSON.stringify(other) === JSON.stringify(changes));
  // a setting that helps all helps none alone
  if (isOne && changes.entries.length === 0) return [together];
  return alike[0] === remedy ? [remedy, together] : [remedy];
}

/** @param {Finding} finding @param {number} index */
function card(finding, index) {
  const { kind, subject, title, text, place, remedies } = finding;
  const named = (/** @type {string} */ label) => `${label}: ${subject}, problem ${index + 1}`;
  const offers = remedies
    .flatMap((remedy) => offersOf(finding, remedy))
    .map((remedy) => {
      const click = () => act(remedy);
      const button = make(
        'button',
        { type: 'button', className: 'small', 'aria-label': named(remedy.label), on: { click } },
        remedy.label,
      );
      if (remedy.changes) previewOn(button, remedy.changes);
      return button;
    });
  const picture =
    place &&
    make(
      'button',
      { type: 'button', className: 'shot', 'aria-label': named('Show the place'), on: { click: () => showIn3d(index) } },
      'Show the place',
    );
  if (picture) pictureOf(picture, finding);
  return make(
    'li',
    { 'data-kind': kind },
    ...(picture ? [picture] : []),
    make('div', {}, make('h4', {}, title), make('p', {}, text)),
    ...(offers.length > 0 ? [make('div', { className: 'row' }, ...offers)] : []),
  );
}

/** @param {Remedy} remedy */
function act({ label, act }) {
  isActing = true;
  say(label);
  take(act);
  isActing = false;
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

/** Shows the first finding of a kind in the view that is shown. @param {Finding['kind']} kind */
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

/** What an offer would change, while it is pointed at or has the focus: its mesh is drawn where that takes a moment, else it is only said. */
import { byId } from '../elements/dom.js';
import { count, duration, roughly } from '../text/format.js';
import { sentence } from '../elements/messages.js';
import { many } from '../text/places.js';
import { findingsOf } from './finding_texts.js';
import { changed } from './remedies.js';
import { isQuick, isShown } from '../run/live_rule.js';
import { release } from '../state/held.js';
import { currentJob, keyOfCells } from '../state/job.js';
import { change, on, state } from '../state/state.js';
import { endPreview, runsOf, showPreview } from '../view/view3d.js';

/** @typedef {import('../state/state.js').Changes} Changes @typedef {import('hexcast').Report} Report */

/** Milliseconds that an offer is pointed at before its mesh is made. */
const PATIENCE = 150;
/** Parts whose cells are named. */
const MOST_NAMED = 3;
/** Fields of settings that have another name. @type {Record<string, string>} */
const FIELDS = { min_size: 'graded-least', growth: 'graded-growth', dims: 'dims-x' };

/** What is shown now. @type {{ button: HTMLElement, stop: AbortController, made: { mesh: import('hexcast').Mesh, job: ReturnType<typeof currentJob> } | null } | null} */
let shown = null;

/** Ends a preview that is no longer of what is on the page. */
export function startPreviews() {
  on(['settings', 'geometries', 'phase', 'mesh'], end);
}

/** Shows what an offer changes while its button is pointed at or has the focus. @param {HTMLElement} button @param {Changes} changes */
export function previewOn(button, changes) {
  /** @type {ReturnType<typeof setTimeout> | undefined} */
  let timer;
  const begin = () => {
    clearTimeout(timer);
    timer = setTimeout(() => shown?.button !== button && preview(button, changes), PATIENCE);
  };
  const leave = () => {
    clearTimeout(timer);
    if (shown?.button === button) end();
  };
  for (const event of ['pointerenter', 'focus']) button.addEventListener(event, begin);
  for (const event of ['pointerleave', 'blur']) button.addEventListener(event, leave);
}

/** Does what is offered: the mesh of its preview becomes that of the page, if it is there. @param {() => void} act */
export function take(act) {
  const made = shown?.made ?? null;
  if (shown) shown.made = null;
  act();
  if (made && keyOfCells(made.job) === keyOfCells(currentJob())) {
    release(state.mesh);
    byId('status').textContent = `Meshed ${count(made.mesh.report.cells)} cells.`;
    change('mesh', { ...made, runs: null, expected: null, left: null });
  } else made?.mesh.dispose();
}

function end() {
  if (!shown) return;
  const { stop, made } = shown;
  shown = null;
  stop.abort();
  byId('offer-said').textContent = '';
  made?.mesh.dispose();
  endPreview();
}

/** @param {HTMLElement} button @param {Changes} changes */
async function preview(button, changes) {
  end();
  const { mesher, mesh, phase } = state;
  if (!mesher || !mesh || phase !== 'idle' || !button.isConnected) return;
  const mine = { button, stop: new AbortController(), made: /** @type {NonNullable<typeof shown>['made']} */ (null) };
  shown = mine;
  const { signal } = mine.stop;
  const said = byId('offer-said');
  const after = changed(changes);
  const job = currentJob(after);
  try {
    const estimate = await mesher.estimate(job, { signal });
    if (shown !== mine) return;
    said.textContent = [wordsOf(changes), costOf(estimate, mesh.report)].filter(Boolean).join(' ');
    // the mesh in view is that of the fields, so that nothing but the offer differs
    if (!state.live || !isQuick(estimate, after.geometries) || !isShown(currentJob())) return;
    const made = await mesher.mesh(job, { signal });
    if (shown !== mine) return made.dispose();
    mine.made = { mesh: made, job };
    said.textContent = differenceOf(mesh.report, made.report);
    const runs = await runsOf(made);
    if (shown === mine && runs) showPreview(made, runs);
  } catch (error) {
    if (shown === mine) said.textContent = sentence(/** @type {Error} */ (error).message);
  }
}

/** The fields and parts that change. @param {Changes} changes */
function wordsOf({ settings, entries }) {
  const ofFields = Object.entries(settings).flatMap(([key, value]) => {
    const field = document.getElementById(FIELDS[key] ?? key.replaceAll('_', '-'));
    const box = field?.closest('label, fieldset');
    if (!box) return [];
    const name = box.querySelector('legend, span')?.textContent ?? box.firstChild?.textContent ?? key;
    const choice = field instanceof HTMLSelectElement && [...field.options].find((option) => option.value === value);
    const text = choice
      ? choice.text
      : [value]
          .flat()
          .map((one) => (typeof one === 'number' ? roughly(one) : String(one)))
          .join(', ');
    return [`${name.trim()}: ${text}.`];
  });
  const ofParts = entries.map(({ index, keys }) => {
    const source = state.job?.geometries[index]?.source;
    const name = state.geometries.find(({ surface }) => surface === source)?.name ?? 'a part';
    const what = Object.entries(keys ?? {}).map(([key, value]) => {
      const choice = key === 'fill' && document.querySelector(`#fill [value=${value}]`);
      return choice ? choice.textContent : `${key.replaceAll('_', ' ')} ${value}`;
    });
    return keys ? `${name}: ${what.join(', ')}.` : `Without ${name}.`;
  });
  return [...ofFields, ...ofParts].join(' ');
}

/** What the mesh costs, where it has other cells. @param {import('hexcast').Estimate} estimate @param {Report} now */
function costOf({ cells, seconds }, now) {
  if (cells === now.cells) return '';
  return `${roughly(cells)} cells instead of ${roughly(now.cells)}${seconds === null ? '' : `, about ${duration(seconds)}`}.`;
}

/** Problems that are left, and the parts whose cells differ most. @param {Report} now @param {Report} then */
function differenceOf(now, then) {
  const [before, after] = [now, then].map((report) => findingsOf(report, null).length);
  const problems = before === after ? '' : `${after === 0 ? 'No problem' : many(after, 'problem')} instead of ${before}. `;
  const cellsOf = (/** @type {string} */ name) => now.flags.find((flag) => flag.name === name)?.cells ?? 0;
  const parts = then.flags
    .map(({ name, cells }) => ({ name, cells, was: cellsOf(name) }))
    .filter(({ cells, was }) => cells !== was);
  const off = ({ cells = 0, was = 0 }) => Math.abs(Math.log((cells + 1) / (was + 1)));
  parts.sort((one, other) => off(other) - off(one));
  if (parts.length === 0) return `${problems}The same cells.`;
  const named = parts.slice(0, MOST_NAMED).map(({ name, cells, was }) => `${name} ${roughly(cells)} (now ${roughly(was)})`);
  const more = parts.length - named.length;
  return `${problems}Cells: ${named.join(', ')}${more > 0 ? ` and ${many(more, 'other part')}` : ''}.`;
}

/** What the mesh found about geometries that are not closed: a line each, with a button that shows where. */
import { byId, make } from './dom.js';
import { count, roughly, short } from './format.js';
import { select } from './tabs.js';
import { on, state } from './state.js';
import { lookAt } from './view3d.js';

/** @typedef {import('hexcast').OpenReport} OpenReport @typedef {import('hexcast').Report} Report */

/** Connects the list. */
export function startFindings() {
  on('mesh', show);
}

function show() {
  const report = state.mesh?.report;
  // a column file does not hold them
  const lines = report?.open?.map((open) => line(open, report)) ?? [];
  byId('result-open').replaceChildren(...lines);
  byId('result-open').hidden = lines.length === 0;
}

/** @param {OpenReport} open @param {Report} report */
function line(open, report) {
  const showPlace = () => {
    select('3d');
    lookAt(open.longest_at);
  };
  const button = make(
    'button',
    { type: 'button', className: 'small', 'aria-label': `Show the edge of ${open.geometry}`, on: { click: showPlace } },
    'Show the edge',
  );
  return make('li', { 'data-geometry': open.geometry }, make('p', {}, text(open, report)), button);
}

/** @param {OpenReport} open @param {Report} report */
function text({ geometry, policy, open_edges: edges, holes, longest_at: at, doubtful_cells: doubtful }, { cells, spacing }) {
  const place = at.map((number, axis) => short(Number(number.toFixed(decimals(spacing[axis]))))).join(', ');
  const facts = `${geometry} is not closed: ${many(edges, 'open edge')} in ${many(holes, 'loop')}, the longest edge at ${place}.`;
  if (doubtful === 0) return `${facts} No cell was doubtful.`;
  const decided = policy === 'vote' ? 'most of their even rays' : 'the winding number';
  const share = `${count(doubtful)} of ${roughly(cells)} cells ${doubtful === 1 ? 'was' : 'were'} doubtful`;
  return `${facts} ${share}: ${decided} decided.`;
}

/** Decimals down to a thousandth of a cell. @param {number} size */
function decimals(size) {
  return Math.min(Math.max(Math.ceil(3 - Math.log10(size)), 0), 100);
}

/** @param {number} n @param {string} what */
function many(n, what) {
  return `${count(n)} ${what}${n === 1 ? '' : 's'}`;
}

/** The warnings of a report without those that findings stand for. @param {Report} report */
export function otherWarnings({ warnings, open }) {
  const starts = (open ?? []).map(({ geometry }) => `geometry "${geometry}" is not closed`);
  return warnings.filter((warning) => !starts.some((start) => warning.startsWith(start)));
}

/** The inspector: what the mesh has of one cell, of its neighbours, and of the column that it lies in. */
import { byId, make } from '../elements/dom.js';
import { showError } from '../elements/messages.js';
import { nameOf } from '../text/cell_facts.js';
import { cellSize } from '../text/format.js';
import { centreOf, endText, lengthOf, placeAt, placeText } from '../text/places.js';
import { colourOf, on, state } from '../state/state.js';
import { crosshair } from './crosshair.js';

/** Rows of the column that are shown on both sides of the cell. */
const ROWS = 40;

/** Connects the panel: while it is open it follows the crosshair. */
export function startInspector() {
  byId('inspector-close').addEventListener('click', close);
  // beside the panes where there is room, else over or below them
  const narrow = matchMedia('(max-width: 1180px)');
  const place = () => (narrow.matches ? byId('view').append(byId('cards')) : byId('results').before(byId('cards')));
  narrow.addEventListener('change', place);
  place();
  byId('inspector').addEventListener('keydown', (event) => {
    if (event.key !== 'Escape') return;
    event.preventDefault();
    close();
  });
  on(['crosshair', 'mesh', 'colours'], () => {
    if (!state.mesh) byId('inspector').hidden = true;
    else if (!byId('inspector').hidden) inspect(crosshair.cell);
  });
}

/** Hides the panel, and goes back to the pane. */
function close() {
  byId('inspector').hidden = true;
  const pane = [...document.querySelectorAll('.pane:not([hidden]) canvas')].find(
    (canvas) => canvas instanceof HTMLElement && canvas.tabIndex === 0,
  );
  if (pane instanceof HTMLElement) pane.focus({ preventScroll: true });
}

/** Counts what is asked for: only the last is shown. */
let asked = 0;

/** Opens the panel with a cell. @param {number[]} cell */
export async function inspect(cell) {
  const { mesh } = state;
  if (!mesh) return;
  const mine = ++asked;
  byId('inspector').hidden = false;
  try {
    const { axis } = mesh.columns;
    const [i, j] = cell.filter((_, other) => other !== axis);
    const low = cell.map((at) => Math.max(at - 1, 0));
    const high = cell.map((at, other) => Math.min(at + 2, mesh.dims[other]));
    const triple = (/** @type {number[]} */ of) => /** @type {[number, number, number]} */ (of);
    const [runs, box] = await Promise.all([mesh.columns.ray(i, j), mesh.box(triple(low), triple(high))]);
    if (mine !== asked || mesh !== state.mesh) return;
    const size = high.map((end, other) => end - low[other]);
    const flagAt = (/** @type {number[]} */ at) => {
      const [x, y, z] = at.map((index, other) => index - low[other]);
      return box.flags[x + size[0] * (y + size[1] * z)];
    };
    show(mesh, cell, flagAt, runs);
  } catch (error) {
    if (mine === asked && mesh === state.mesh) showError(error);
  }
}

/** @param {import('hexcast').Mesh} mesh @param {number[]} cell @param {(cell: number[]) => number} flagAt @param {import('hexcast').Runs} runs */
function show(mesh, cell, flagAt, runs) {
  const { lines, report, columns } = mesh;
  const of = report.unit ? ` ${report.unit}` : '';
  const sizes = cell.map((at, axis) => lengthOf(lines, axis, at));
  const fact = (/** @type {string} */ term, /** @type {Node | string} */ value) => [make('dt', {}, term), make('dd', {}, value)];
  byId('inspector-facts').replaceChildren(
    ...fact('Index', cell.join(', ')),
    ...fact('Centre', `${placeText(centreOf(lines, cell), lines)}${of}`),
    ...fact('Size', cellSize(sizes, report.unit)),
    ...fact('Flag', named(report, flagAt(cell))),
  );
  byId('inspector-beside').replaceChildren(
    ...[0, 1, 2].map((axis) => {
      const [below, above] = [-1, 1].map((by) => make('td', {}, neighbour(mesh, cell, axis, by, flagAt)));
      return make('tr', {}, make('th', { scope: 'row' }, 'xyz'[axis]), below, above);
    }),
  );
  byId('inspector-column').textContent = `Column along ${'xyz'[columns.axis]}, as the rays went`;
  byId('inspector-places').textContent = `Places${report.unit ? ` in ${report.unit}` : ''}`;
  byId('inspector-runs').replaceChildren(...rows(mesh, cell[columns.axis], runs));
}

/** @param {import('hexcast').Mesh} mesh @param {number[]} cell @param {number} axis @param {number} by @param {(cell: number[]) => number} flagAt */
function neighbour({ dims, report }, cell, axis, by, flagAt) {
  const next = cell.map((at, other) => (other === axis ? at + by : at));
  const isThere = next[axis] >= 0 && next[axis] < dims[axis];
  return isThere ? named(report, flagAt(next)) : 'outside';
}

/** A flag with its colour and name. @param {import('hexcast').Report} report @param {number} flag */
function named(report, flag) {
  if (flag === 0) return make('span', {}, 'background');
  const swatch = make('span', { className: 'swatch' });
  swatch.style.background = colourOf(flag);
  return make('span', {}, swatch, nameOf(report, flag));
}

/**
 * A row a run of the column, those that are nearest to a cell.
 *
 * @param {import('hexcast').Mesh} mesh
 * @param {number} at the cell of the column
 * @param {import('hexcast').Runs} runs
 */
function rows({ lines, dims, columns: { axis }, report }, at, { starts, flags }) {
  const all = [...starts].map((start, run) => ({ start, flag: flags[run], end: starts[run + 1] ?? dims[axis] }));
  // before the first run is the background
  if (all.length === 0 || all[0].start > 0) all.unshift({ start: 0, flag: 0, end: all[0]?.start ?? dims[axis] });
  const here = all.findIndex(({ end }) => at < end);
  const shown = all.slice(Math.max(0, here - ROWS), here + ROWS + 1);
  const place = (/** @type {number} */ line) =>
    endText(placeAt(lines, axis, line), lengthOf(lines, axis, Math.min(line, dims[axis] - 1)));
  return shown.map((run) => {
    const { start, flag, end } = run;
    const cells = make('td', { className: 'number' }, end - start === 1 ? String(start) : `${start} to ${end - 1}`);
    const from = make('td', { className: 'number' }, `${place(start)} to ${place(end)}`);
    return make(
      'tr',
      run === all[here] ? { 'aria-current': 'true' } : {},
      make('th', { scope: 'row' }, named(report, flag)),
      cells,
      from,
    );
  });
}

/** The form: linked sizes, domain and padding, rule, open surfaces, fill, axis, unit, backend. */
import { byId, inputOf, onInput, put, selectOf } from '../elements/dom.js';
import { cellSize, readNumbers, writeNumbers } from '../text/format.js';
import { placeAt } from '../text/places.js';
import { largestCell, showGraded, startGraded } from './graded.js';
import { showLines, startLines } from './lines.js';
import { showMeasured, startMeasured } from './measured.js';
import { on, set, state } from '../state/state.js';

/** @typedef {import('../state/state.js').Triple} Triple @typedef {import('../state/state.js').Box} Box */

/** Largest number that a job can hold; no mesh of that size fits. */
const MAX_CELLS = 2 ** 32 - 1;
const DIMS = ['dims-x', 'dims-y', 'dims-z'];
const DOMAIN = ['x0', 'y0', 'z0', 'x1', 'y1', 'z1'].map((name) => `domain-${name}`);

/** Connects the fields, both ways. */
export function startSettings() {
  onInput('cells', 'input', (input) => {
    if (isNumberOfCells(input)) set({ sizing: 'cells', cells: numberOfCells(input) });
  });
  onInput('cell-size', 'input', readCellSize);
  onInput('fit-lines', 'change', ({ checked }) => {
    set({ sizing: checked ? 'max_cell_size' : 'cell_size', cell_size: [state.settings.cell_size ?? largestCell()].flat()[0] });
  });
  for (const id of DIMS) onInput(id, 'input', readDims);
  for (const id of DOMAIN) onInput(id, 'input', readDomain);
  onInput('domain-given', 'change', ({ checked }) => {
    // the box of the estimate has its padding
    set(checked ? { domain: domainOf(state.estimate?.result), padding: 0 } : { domain: null });
  });
  onInput('padding', 'input', readPadding);
  byId('padding-by').addEventListener('change', readPadding);
  for (const key of /** @type {const} */ (['rule', 'open', 'fill', 'axis', 'unit', 'backend'])) {
    const select = selectOf(key);
    select.addEventListener('change', () => set({ [key]: select.value }));
  }
  onInput('close-gaps', 'input', (input) => {
    // openings of no cell are none, and one cell is no opening
    const isRight = input.value === '' || input.value === '0' || (isNumberOfCells(input) && Number(input.value) > 1);
    input.setCustomValidity(isRight ? '' : 'this is 0, or a whole number from 2 on');
    if (isRight && input.value !== '') set({ close_gaps: numberOfCells(input) });
  });
  onInput('certify', 'change', ({ checked }) => set({ certify: checked }));
  onInput('thin-cells', 'input', (input) => {
    if (isNumberOfCells(input)) set({ thin_cells: numberOfCells(input) });
  });
  startGraded();
  startLines();
  startMeasured();
  const form = byId('settings');
  form.addEventListener('submit', (event) => event.preventDefault());
  // a field that was left empty shows its value again
  form.addEventListener('focusout', ({ target }) => {
    if (target instanceof HTMLInputElement && target.value === '' && target.validity.valid) setTimeout(show);
  });
  on(['settings', 'estimate', 'geometries'], show);
  show();
}

/** Whether a field holds a number of cells; how many fit, the estimate says. @param {HTMLInputElement} input */
function isNumberOfCells(input) {
  const value = Number(input.value);
  const isRight = input.value !== '' && value > 0 && Number.isInteger(value);
  input.setCustomValidity(isRight || input.value === '' ? '' : 'this is a whole number from 1 on');
  return isRight;
}

/** @param {HTMLInputElement} input */
function numberOfCells(input) {
  return Math.min(Number(input.value), MAX_CELLS);
}

/** @param {HTMLInputElement} input */
function readCellSize(input) {
  const value = readNumbers(input.value);
  const isRight = value !== null && value !== undefined && [value].flat().every((size) => size > 0);
  input.setCustomValidity(
    isRight || value === null ? '' : 'this is a length greater than 0, such as 0.5, or three, separated by spaces',
  );
  if (!isRight) return;
  const fits = inputOf('fit-lines').checked && !Array.isArray(value);
  set({ sizing: fits ? 'max_cell_size' : 'cell_size', cell_size: value });
}

function readDims() {
  const inputs = DIMS.map(inputOf);
  if (inputs.every(isNumberOfCells)) set({ sizing: 'dims', dims: /** @type {Triple} */ (inputs.map(numberOfCells)) });
}

function readDomain() {
  const inputs = DOMAIN.map(inputOf);
  if (inputs.every((input) => input.value !== '' && Number.isFinite(Number(input.value)))) {
    set({ domain: /** @type {Box} */ (inputs.map((input) => Number(input.value))) });
  }
}

function readPadding() {
  const by = selectOf('padding-by').value === 'length' ? 'length' : 'cells';
  const input = inputOf('padding');
  const value = readNumbers(input.value) ?? (input.value.trim() === '' ? 0 : undefined);
  const isRight = value !== undefined && [value].flat().every((room) => room >= 0 && (by === 'length' || Number.isInteger(room)));
  input.setCustomValidity(
    isRight ? '' : `this is ${by === 'cells' ? 'a whole number of cells' : 'a length'} from 0, or three, separated by spaces`,
  );
  if (isRight) set({ padding: value, padding_by: by });
}

/** The box that an estimate meshes. @param {import('../text/places.js').Lines} [estimate] @returns {Box} */
export function domainOf(estimate) {
  if (!estimate) return [0, 0, 0, 1, 1, 1];
  const { origin, dims } = estimate;
  return /** @type {Box} */ ([...origin, ...dims.map((n, axis) => Number(placeAt(estimate, axis, n).toPrecision(12)))]);
}

/** Writes all fields but the one being typed in; those that were not set follow the estimate. */
function show() {
  const { settings } = state;
  const result = state.estimate?.result;
  const dims = settings.sizing === 'dims' ? settings.dims : result?.dims;
  put('cells', settings.sizing === 'cells' ? settings.cells : dims ? Math.max(...dims) : '');
  const isSize = settings.sizing === 'cell_size' || settings.sizing === 'max_cell_size';
  put(
    'cell-size',
    isSize ? writeNumbers(settings.cell_size) : result?.spacing ? cellSize(result.spacing).replaceAll(' × ', ' ') : '',
  );
  DIMS.forEach((id, axis) => put(id, dims?.[axis] ?? ''));
  inputOf('fit-lines').checked = settings.sizing === 'max_cell_size';
  /** @type {Record<string, string>} */
  const leads = { cells: 'cells', dims: 'dims', cell_size: 'cell-size', max_cell_size: 'cell-size' };
  const leading = leads[settings.sizing];
  const sizes = /** @type {NodeListOf<HTMLElement>} */ (document.querySelectorAll('[data-size]'));
  for (const field of sizes) field.classList.toggle('leads', field.dataset.size === leading);
  showGraded();
  showLines();
  showMeasured();
  inputOf('domain-given').checked = settings.domain !== null;
  byId('domain-fields').hidden = settings.domain === null;
  DOMAIN.forEach((id, at) => {
    inputOf(id).required = settings.domain !== null;
    put(id, settings.domain?.[at] ?? '');
  });
  put('close-gaps', settings.close_gaps);
  inputOf('certify').checked = settings.certify;
  byId('thin-cells-field').hidden = !settings.certify;
  put('thin-cells', settings.thin_cells);
  put('padding', writeNumbers(settings.padding));
  for (const key of /** @type {const} */ (['rule', 'open', 'fill', 'axis', 'unit', 'backend', 'padding_by']))
    putChoice(selectOf(key.replace('_', '-')), settings[key]);
  for (const unit of document.querySelectorAll('.unit')) unit.textContent = settings.unit;
}

/** A unit of a link may be none of the list. @param {HTMLSelectElement} select @param {string} value */
function putChoice(select, value) {
  if (![...select.options].some((option) => option.value === value)) select.append(new Option(value));
  select.value = value;
}

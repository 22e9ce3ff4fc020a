/** Several sizes of cells compared: a table for each flag, a chart, both to be saved; a size is taken over by its button. */
import { convergeChart } from './converge_chart.js';
import { buttonOf, byId, inputOf, make } from '../elements/dom.js';
import { save } from '../downloads/downloads.js';
import { bytes, count, duration, numbersOf } from '../text/format.js';
import { SIZING_KEYS, currentJob } from '../state/job.js';
import { showError } from '../elements/messages.js';
import { baseName } from '../settings/share.js';
import { on, set, state } from '../state/state.js';
import { task } from '../elements/tasks.js';

/** @typedef {import('hexcast').Level} Level */

/** Keys of a job that choose its cells, or need them: here they follow from the sizes. */
const CHOSEN = /** @type {const} */ ([
  'cells',
  'dims',
  'cell_size',
  'max_cell_size',
  'graded',
  'lines',
  'certify',
  'links',
  'fractions',
  'staggered',
  'conformal',
  'distance',
  'tensors',
  'cut_cells',
]);

/** What was found last. @type {Level[]} */
let levels = [];
/** Numbers of cells that it was asked for: padding adds to these. @type {number[]} */
let asked = [];

/** Connects the fields. */
export function startConverge() {
  byId('converge-form').addEventListener('submit', (event) => {
    event.preventDefault();
    compare();
  });
  inputOf('converge-sizes').addEventListener('input', readSizes);
  on(['mesher', 'geometries', 'phase'], () => {
    buttonOf('converge-run').disabled = !state.mesher || state.geometries.length === 0 || state.phase === 'meshing';
  });
  on('geometries', () => (byId('converge-result').hidden = true));
  byId('converge-svg').addEventListener('click', () => saveText(convergeChart(levels).outerHTML, 'svg', 'image/svg+xml'));
  byId('converge-json').addEventListener('click', () =>
    saveText(`${JSON.stringify(levels, null, 2)}\n`, 'json', 'application/json'),
  );
}

/** @param {string} text @param {string} extension @param {string} type */
function saveText(text, extension, type) {
  save(new Blob([text], { type }), `${baseName(currentJob())}-sizes.${extension}`);
}

/** The numbers of cells in the field; null where these are none. */
function readSizes() {
  const input = inputOf('converge-sizes');
  const numbers = numbersOf(input.value);
  const isRight = numbers && numbers.length > 0 && numbers.every((size) => Number.isInteger(size) && size > 0 && size < 2 ** 18);
  input.setCustomValidity(isRight ? '' : 'these are whole numbers from 1 on, separated by spaces');
  return isRight ? [...new Set(numbers)].sort((one, other) => one - other) : null;
}

async function compare() {
  const { mesher } = state;
  const sizes = readSizes();
  if (!sizes) return inputOf('converge-sizes').reportValidity();
  if (!mesher || state.geometries.length === 0) return undefined;
  const job = currentJob();
  for (const key of CHOSEN) delete job[key];
  for (const geometry of job.geometries) for (const key of SIZING_KEYS) delete geometry[key];
  const run = buttonOf('converge-run');
  run.disabled = true;
  try {
    asked = sizes;
    levels = await task('Comparing cell sizes', (options) => mesher.converge(job, { sizes, ...options }));
    byId('converge-tables').replaceChildren(...levels[0].flags.map((_, index) => table(index)));
    byId('converge-chart').replaceChildren(convergeChart(levels));
    byId('converge-result').hidden = false;
  } catch (error) {
    if (!(error instanceof DOMException && error.name === 'AbortError')) showError(error);
  } finally {
    run.disabled = false;
  }
  return undefined;
}

/** The levels of a flag. @param {number} index */
function table(index) {
  const { flag, name } = levels[0].flags[index];
  const head = ['Cells', 'Volume', 'Area', 'Time', '.hxc'].map((title, at) =>
    make('th', { scope: 'col', className: at > 0 ? 'number' : '' }, title),
  );
  const rows = levels.map(({ flags, seconds, column_bytes: columns }, at) => {
    const { volume_error: volume, area_error: area } = flags[index];
    const size = asked[at];
    const take = make(
      'button',
      { type: 'button', className: 'small', title: 'Take this size', on: { click: () => set({ sizing: 'cells', cells: size }) } },
      count(size),
    );
    const cells = [percent(volume), percent(area), duration(seconds), bytes(columns)];
    return make('tr', {}, make('td', {}, take), ...cells.map((text) => make('td', { className: 'number' }, text)));
  });
  return make(
    'table',
    { className: 'levels', 'data-flag': flag },
    make('caption', {}, `Flag ${flag}, ${name}: errors`),
    make('thead', {}, make('tr', {}, ...head)),
    make('tbody', {}, ...rows),
  );
}

/** @param {number | null} error */
function percent(error) {
  return error === null ? '–' : `${error < 0 ? '−' : '+'}${Number((100 * Math.abs(error)).toPrecision(2))} %`;
}

/** The slider: how fine cells are, for whichever of the sizes was set. */
import { byId, inputOf, onInput } from '../elements/dom.js';
import { count, short } from '../text/format.js';
import { set, on, state } from '../state/state.js';
import { boxAround } from '../text/places.js';

/** Steps of the slider that double the number of cells along an axis. */
const STEPS = 8;

/** Connects the slider. */
export function startFineness() {
  onInput('fineness', 'input', ({ value }) => take(Math.round(2 ** (Number(value) / STEPS))));
  on(['settings', 'estimate', 'geometries'], show);
  show();
}

/** Sets the size that leads, so that there are so many cells along the longest axis. @param {number} n */
function take(n) {
  const { sizing } = state.settings;
  if (sizing === 'cells' || sizing === 'dims') return set({ sizing: 'cells', cells: n });
  const size = Number((longest() / n).toPrecision(4));
  return set(sizing === 'graded' ? { graded: size } : { cell_size: size });
}

/** The longest side of the box, without its padding; cells of a size may reach beyond it. */
function longest() {
  const [x0, y0, z0, x1, y1, z1] = state.settings.domain ?? boxAround(state.geometries);
  return Math.max(x1 - x0, y1 - y0, z1 - z0);
}

/** The number of cells along the longest axis that the fields ask for; null where nobody knows yet. */
function asked() {
  const { sizing, cells, dims, cell_size: size, graded } = state.settings;
  if (sizing === 'cells') return cells;
  if (sizing === 'dims' && dims) return Math.max(...dims);
  const largest = Math.max(...[(sizing === 'graded' ? graded : size) ?? 0].flat());
  return state.geometries.length > 0 && largest > 0 ? longest() / largest : null;
}

function show() {
  const slider = inputOf('fineness');
  byId('fineness-field').hidden = state.geometries.length === 0 || state.settings.sizing === 'lines';
  const n = asked();
  if (n === null) return;
  // what is dragged leads
  if (slider !== document.activeElement) slider.value = String(Math.round(STEPS * Math.log2(n)));
  const size = state.estimate?.result?.spacing?.[0];
  const length = size ? `, ${short(size)}${state.settings.unit ? ` ${state.settings.unit}` : ''}` : '';
  slider.setAttribute('aria-valuetext', `${count(Math.round(n))} cells along the longest axis${length}`);
  byId('fineness-value').textContent = `${count(Math.round(n))} cells`;
}

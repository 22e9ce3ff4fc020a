/** The fields of what is measured beside the cells: links, fractions of cells, a staggered grid, edges and faces outside metal, permittivity, distances, cut cells. */
import { byId, inputOf, onInput, put, selectOf } from '../elements/dom.js';
import { flagsOf } from '../text/format.js';
import { MEASURED, set, state } from '../state/state.js';

/** @param {string} key */
const id = (key) => key.replace('_', '-');

/** Connects the fields. */
export function startMeasured() {
  for (const key of MEASURED) onInput(id(key), 'change', ({ checked }) => set({ [key]: checked }));
  const stencil = selectOf('stencil');
  stencil.addEventListener('change', () =>
    set({ stencil: /** @type {import('../state/state.js').Settings['stencil']} */ (stencil.value) }),
  );
  onInput('fluid', 'input', (input) => {
    const flags = flagsOf(input.value);
    input.setCustomValidity(flags ? '' : 'these are flags from 0 to 255, separated by spaces');
    if (flags) set({ fluid: flags });
  });
  onInput('cut-fluid', 'change', (input) => {
    if (input.reportValidity()) set({ cut_fluid: input.value === '' ? null : Number(input.value) });
  });
  const rays = selectOf('fraction-rays');
  rays.addEventListener('change', () => set({ fraction_rays: Number(rays.value) }));
}

/** Writes the fields. */
export function showMeasured() {
  const { settings } = state;
  for (const key of MEASURED) inputOf(id(key)).checked = settings[key];
  byId('links-fields').hidden = !settings.links;
  byId('fractions-fields').hidden = !settings.fractions;
  byId('exact-fields').hidden = settings.fraction_rays !== 0;
  byId('cut-fields').hidden = !settings.cut_cells;
  put('cut-fluid', settings.cut_fluid === null ? '' : String(settings.cut_fluid));
  selectOf('stencil').value = settings.stencil;
  put('fluid', settings.fluid.join(' '));
  selectOf('fraction-rays').value = String(settings.fraction_rays);
}

/** The solids of a file as geometries of their own. */
import { make } from '../elements/dom.js';
import { flagsOf, freeFlag, state } from '../state/state.js';

/** @typedef {import('../state/state.js').Geometry} Geometry @typedef {(id: number, patch: Partial<Geometry>) => void} Edit changes keys of a geometry */

/** A choice only where every solid is closed, or it was made already. @param {Geometry} geometry @param {number} n_closed @param {Edit} edit */
export function splitBox({ id, split, info }, n_closed, edit) {
  const n_solids = info.solids.length;
  if (!split && n_closed < n_solids) {
    return make(
      'p',
      { className: 'note' },
      `${n_solids} solids, of which ${n_closed === 0 ? 'none' : n_closed} ${n_closed > 1 ? 'are' : 'is'} closed: they are meshed as one geometry`,
    );
  }
  const box = make('input', {
    type: 'checkbox',
    className: 'split',
    checked: split,
    on: { change: ({ target }) => splitSolids(id, target, edit) },
  });
  return make(
    'label',
    { className: 'check' },
    box,
    `Each of the ${n_solids} solids is a geometry, with its own name and the next flag`,
  );
}

/**
 * Makes every solid a geometry, or all of them one again; flags that other geometries have are not used twice.
 *
 * @param {number} id
 * @param {HTMLInputElement} box
 * @param {Edit} edit
 */
function splitSolids(id, box, edit) {
  const geometry = state.geometries.find((geometry) => geometry.id === id);
  if (!geometry) return;
  const others = new Set(state.geometries.filter((other) => other !== geometry).flatMap(flagsOf));
  const wanted = flagsOf({ ...geometry, split: box.checked });
  const isFree = wanted[wanted.length - 1] <= 255 && !wanted.slice(1).some((flag) => others.has(flag));
  const flag = isFree ? geometry.flag : freeFlag(wanted.length, geometry);
  const [flagInput, nameInput] = ['.flag', '.name'].map(
    (name) => /** @type {HTMLInputElement} */ (box.closest('.geometry')?.querySelector(name)),
  );
  flagInput.value = String(flag);
  nameInput.disabled = box.checked;
  edit(id, { split: box.checked, flag });
}

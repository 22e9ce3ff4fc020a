/** The fields of a geometry that say which cells it has along its surface, and how lines are generated around it; these are shown where the job generates lines. */
import { byId, make } from '../elements/dom.js';
import { readNumbers, writeNumbers } from '../text/format.js';

/** @typedef {import('../state/state.js').Geometry} Geometry */

/** @param {Geometry} geometry @param {(id: number, patch: Partial<Geometry>) => void} edit */
export function fillField({ id, name, fill }, edit) {
  const ofAll = /** @type {HTMLSelectElement} */ (byId('fill')).options;
  const choices = [{ value: '', text: 'as for all parts' }, ...ofAll];
  const options = choices.map(({ value, text }) => make('option', { value, selected: value === (fill ?? '') }, text));
  const select = make(
    'select',
    {
      className: 'fill',
      'aria-label': `Cells of ${name}`,
      on: { change: ({ target }) => edit(id, { fill: /** @type {Geometry['fill']} */ (target.value || null) }) },
    },
    ...options,
  );
  return make('label', { className: 'field' }, 'Which cells it has', select);
}

/** @param {Geometry} geometry @param {(id: number, patch: Partial<Geometry>) => void} edit */
export function sizingFields({ id, name, max_size, min_cells, metal }, edit) {
  const most = make('input', {
    type: 'text',
    className: 'max-size',
    value: writeNumbers(max_size),
    placeholder: 'any',
    inputMode: 'decimal',
    'aria-label': `Largest cell across ${name}`,
    on: {
      input: ({ target }) => {
        const value = readNumbers(target.value);
        const isRight = value === null || (typeof value === 'number' && value > 0);
        target.setCustomValidity(isRight ? '' : 'must be a length greater than 0');
        if (isRight) edit(id, { max_size: value });
      },
    },
  });
  const fewest = make('input', {
    type: 'number',
    className: 'min-cells',
    min: 1,
    step: 1,
    value: min_cells ?? '',
    placeholder: 'any',
    'aria-label': `Fewest cells across ${name}`,
    on: {
      input: ({ target }) => {
        if (target.checkValidity()) edit(id, { min_cells: target.value === '' ? null : Number(target.value) });
      },
    },
  });
  const thirds = make('input', {
    type: 'checkbox',
    className: 'metal',
    checked: metal,
    on: { change: ({ target }) => edit(id, { metal: target.checked }) },
  });
  return make(
    'div',
    { className: 'graded-only' },
    make('div', { className: 'row fields' }, make('label', {}, 'Largest cell', most), make('label', {}, 'Fewest cells', fewest)),
    make('label', { className: 'check' }, thirds, 'Metal: lines a third of a cell inside its edges'),
  );
}

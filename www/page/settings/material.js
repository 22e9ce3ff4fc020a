/** What a geometry is made of, as text: `eps_r=2.2 sigma=0.01`, or `pec`. Only files for solvers need it. */
import { byId, make } from '../elements/dom.js';
import { on, set, state } from '../state/state.js';

/**
 * @typedef {import('hexcast').Material} Material
 * @typedef {import('../state/state.js').Geometry} Geometry
 */

const NUMBERS = ['eps_r', 'mu_r', 'sigma', 'density', 'E', 'nu'];

/** Reads a material: null where there is none, undefined where the text is wrong. @param {string} text @returns {Material | null | undefined} */
export function readMaterial(text) {
  const pairs = text.split(/[\s,;]+/).filter((word) => word !== '');
  if (pairs.length === 0) return null;
  /** @type {Record<string, number | true>} */
  const material = {};
  for (const pair of pairs) {
    const [key, value, ...more] = pair.split('=');
    const number = Number(value || NaN);
    if (pair === 'pec') material.pec = true;
    else if (NUMBERS.includes(key) && Number.isFinite(number) && more.length === 0) material[key] = number;
    else return undefined;
  }
  return material;
}

/** What `readMaterial` reads back. @param {Material | null} material */
export function writeMaterial(material) {
  return Object.entries(material ?? {})
    .map(([key, value]) => (key === 'pec' ? key : `${key}=${value}`))
    .join(' ');
}

/** @param {Geometry} geometry @param {(id: number, patch: Partial<Geometry>) => void} edit */
export function materialField({ id, name, material }, edit) {
  const { field } = fieldOf(`Material of ${name}`, material, (material) => edit(id, { material }));
  return make(
    'details',
    {},
    make('summary', {}, 'Material'),
    make('label', { className: 'field' }, 'Written to files for solvers, in SI units', field),
  );
}

/** The field of the background, which there is once. */
export function startBackground() {
  const { field, show } = fieldOf('Material of the background', null, (background) => set({ background }));
  field.id = 'background';
  byId('background-label').append(field);
  on(['settings', 'geometries'], () => {
    byId('background-of').hidden = state.geometries.length === 0;
    if (field !== document.activeElement) show(state.settings.background);
  });
}

/**
 * A field for a material, and what writes one into it.
 *
 * @param {string} label @param {Material | null} material @param {(material: Material | null) => void} edit
 */
export function fieldOf(label, material, edit) {
  const field = make('input', {
    type: 'text',
    className: 'material',
    value: writeMaterial(material),
    placeholder: 'eps_r=2.2 sigma=0.01, or pec',
    title: `${NUMBERS.join(', ')} and a number each, or pec: a perfect electric conductor`,
    'aria-label': label,
    spellcheck: 'false',
    on: {
      input: ({ target }) => {
        const value = readMaterial(target.value);
        target.setCustomValidity(value === undefined ? `such as eps_r=2.2 sigma=0.01; keys: ${NUMBERS.join(', ')}, pec` : '');
        if (value !== undefined) edit(value);
      },
    },
  });
  const show = (/** @type {Material | null} */ material) => {
    field.value = writeMaterial(material);
    field.setCustomValidity('');
  };
  return { field, show };
}

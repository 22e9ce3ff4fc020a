/** One table of what parts are made of, a row a part, from lists of usual materials. */
import { byId, make } from '../elements/dom.js';
import { fieldOf, writeMaterial } from '../settings/material.js';
import { change, colourOf, state } from '../state/state.js';

/** @typedef {import('hexcast').Material} Material @typedef {import('../state/state.js').Geometry} Geometry */

/** What solvers of fields and of solids want to know, and usual materials in SI units. @type {Record<'field' | 'solid', { keys: string[], usual: Record<string, Material> }>} */
const KINDS = {
  field: {
    keys: ['pec', 'eps_r', 'mu_r', 'sigma'],
    usual: {
      'Metal (PEC)': { pec: true },
      Copper: { sigma: 5.8e7 },
      Aluminium: { sigma: 3.77e7 },
      'Vacuum, air': { eps_r: 1 },
      'FR-4': { eps_r: 4.4 },
      PTFE: { eps_r: 2.1 },
      Plastic: { eps_r: 2.8 },
      Glass: { eps_r: 5.5 },
      Alumina: { eps_r: 9.8 },
      Silicon: { eps_r: 11.7 },
      Water: { eps_r: 78.4 },
    },
  },
  solid: {
    keys: ['E', 'nu', 'density'],
    usual: {
      Steel: { E: 2.1e11, nu: 0.3, density: 7850 },
      Aluminium: { E: 7e10, nu: 0.33, density: 2700 },
      Copper: { E: 1.2e11, nu: 0.34, density: 8960 },
      Concrete: { E: 3e10, nu: 0.2, density: 2400 },
      Plastic: { E: 2.3e9, nu: 0.35, density: 1050 },
    },
  },
};
const OTHER = 'other';

export class Materials {
  /** What is drawn: the kind and the parts. */
  #drawn = '';
  /** What writes into each row what its part is made of. @type {((geometry: Geometry) => void)[]} */
  #rows = [];

  /** Shows the table; returns how many parts have none of what solvers of this kind need. @param {'field' | 'solid'} kind */
  show(kind) {
    const { geometries } = state;
    const key = JSON.stringify([kind, geometries.map(({ id, name, flag }) => [id, name, colourOf(flag)])]);
    if (key !== this.#drawn) {
      this.#drawn = key;
      const rows = geometries.map((geometry) => row(geometry, kind));
      this.#rows = rows.map(({ write }) => write);
      const all = choice('All without one', kind, (material) => {
        all.value = '';
        give(idsWithout(kind), material, kind);
      });
      const head = make('tr', { id: 'materials-all' }, make('th', { scope: 'row' }, 'All without one'), make('td', {}, all));
      byId('materials')
        .querySelector('tbody')
        ?.replaceChildren(head, ...rows.map(({ element }) => element));
    }
    for (const [at, write] of this.#rows.entries()) write(geometries[at]);
    const n_without = idsWithout(kind).length;
    byId('materials-all').hidden = n_without < 2;
    return n_without;
  }
}

/** @param {'field' | 'solid'} kind */
function idsWithout(kind) {
  return state.geometries.filter(({ material }) => textOf(material, kind) === '').map(({ id }) => id);
}

/** A row of a part: its usual materials, and a field for any other. @param {Geometry} geometry @param {'field' | 'solid'} kind */
function row({ id, name, flag }, kind) {
  const label = `What ${name} is made of`;
  const { field, show } = fieldOf(`Numbers of ${name}`, null, (material) => give([id], material, kind));
  const list = choice(label, kind, (material) => {
    field.hidden = list.value !== OTHER;
    if (list.value === OTHER) field.focus();
    else give([id], material, kind);
  });
  list.append(make('option', { value: OTHER }, 'other …'));
  field.hidden = true;
  const swatch = make('span', { className: 'swatch' });
  swatch.style.background = colourOf(flag);
  const element = make('tr', {}, make('th', { scope: 'row' }, swatch, name ?? ''), make('td', {}, list, field));
  const write = (/** @type {Geometry} */ { material }) => {
    if (field === document.activeElement || (list.value === OTHER && material === null)) return;
    const text = textOf(material, kind);
    list.value = text;
    if (list.value !== text) list.value = OTHER;
    field.hidden = list.value !== OTHER;
    if (!field.hidden) show(material);
  };
  return { element, write };
}

/** A list of usual materials, whose values are their texts. @param {string} label @param {'field' | 'solid'} kind @param {(material: Material | null) => void} chosen */
function choice(label, kind, chosen) {
  const usual = Object.entries(KINDS[kind].usual);
  return make(
    'select',
    {
      'aria-label': label,
      on: { change: ({ target }) => chosen(usual.find(([, material]) => textOf(material, kind) === target.value)?.[1] ?? null) },
    },
    make('option', { value: '' }, 'choose'),
    ...usual.map(([name, material]) => {
      const text = textOf(material, kind);
      return make('option', { value: text }, kind === 'field' && text !== 'pec' ? `${name}, ${text}` : name);
    }),
  );
}

/** What a material says to solvers of a kind. @param {Material | null} material @param {'field' | 'solid'} kind */
function textOf(material, kind) {
  const { keys } = KINDS[kind];
  return writeMaterial(/** @type {Material} */ (only(material, (key) => keys.includes(key))));
}

/** @param {Material | null} material @param {(key: string) => boolean} isWanted */
function only(material, isWanted) {
  return Object.fromEntries(Object.entries(material ?? {}).filter(([key]) => isWanted(key)));
}

/** Parts are made of this; what solvers of the other kind know of them stays. @param {number[]} ids @param {Material | null} material @param {'field' | 'solid'} kind */
function give(ids, material, kind) {
  const { keys } = KINDS[kind];
  const geometries = state.geometries.map((geometry) => {
    if (!ids.includes(geometry.id)) return geometry;
    const made = { ...only(geometry.material, (key) => !keys.includes(key)), ...material };
    return { ...geometry, material: Object.keys(made).length > 0 ? made : null };
  });
  change('geometries', { geometries, revision: state.revision + 1 });
}

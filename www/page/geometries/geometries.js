/** The list of geometries: facts and settings of each. */
import { byId, make } from '../elements/dom.js';
import { deviationText } from './cad.js';
import { removeGeometry } from './files.js';
import { fillField, sizingFields } from './sizing.js';
import { count, measure, readNumbers, times, writeNumbers } from '../text/format.js';
import { materialField, startBackground } from '../settings/material.js';
import { sentence } from '../elements/messages.js';
import { endText, placedBox } from '../text/places.js';
import { editedWith, showSelected, startSelected } from './selected.js';
import { handle, moveByKey, startOrder } from './order.js';
import { change, colourOf, flagsOf, on, placeKey, state } from '../state/state.js';
import { splitBox } from './solids.js';
import { checkAgain, isLeftUnchecked } from './surfaces.js';

/** @typedef {import('../state/state.js').Geometry} Geometry */

/** @type {['scale' | 'rotate' | 'about' | 'translate', string, string][]} */
const TRANSFORMS = [
  ['scale', 'Scale', 'one factor, or one an axis'],
  ['rotate', 'Rotate', 'degrees about x, then y, then z'],
  ['about', 'Rotate about', 'the point that stays where it is, once scaled'],
  ['translate', 'Move', 'along x, y, z'],
];

/** Numbers of cells in a row, as 37.2K. */
const SHORT = new Intl.NumberFormat('en', { notation: 'compact', maximumSignificantDigits: 3 });
/** So many parts have their details open. */
const FEW = 2;

/** Parts whose details somebody opened or closed. @type {Map<number, boolean>} */
const opened = new Map();

/** Keeps the list up to date; it is redrawn only when geometries are added or removed, so that typing is not disturbed. */
export function startGeometries() {
  let drawn = '';
  startOrder();
  startSelected();
  startBackground();
  on('mesh', showCells);
  on(['geometries', 'settings', 'colours'], (topic) => {
    const key = `${state.geometries.map(({ id }) => id)} ${state.revision} ${state.settings.unit}`;
    if (key !== drawn) byId('geometries').replaceChildren(...state.geometries.map(card));
    drawn = key;
    if (topic !== 'settings') for (const geometry of state.geometries) showColour(geometry);
    for (const geometry of state.geometries) showFacts(geometry);
    document.body.classList.toggle('has-model', state.geometries.length > 0);
    document.body.classList.toggle('has-many', state.geometries.length > FEW);
    showCells();
    showSelected();
  });
}

/** Changes keys of a geometry, and of all that are selected with it. @param {number} id @param {Partial<Geometry>} patch */
function edit(id, patch) {
  const ids = editedWith(id, patch);
  const geometries = state.geometries.map((geometry) => (ids.has(geometry.id) ? { ...geometry, ...patch } : geometry));
  // somebody may be typing in a field of the one
  for (const geometry of geometries) {
    const isOther = geometry.id !== id && ids.has(geometry.id);
    if (isOther) document.querySelector(`.geometry[data-id="${geometry.id}"]`)?.replaceWith(card(geometry));
  }
  change('geometries', { geometries });
}

/** @param {Geometry} geometry */
function showColour(geometry) {
  const input = document.getElementById(`colour-${geometry.id}`);
  if (input instanceof HTMLInputElement) input.value = colourOf(geometry.flag);
}

/** Writes the facts anew where the geometry was placed otherwise. @param {Geometry} geometry */
function showFacts(geometry) {
  const element = byId(`facts-${geometry.id}`);
  const { info, corners } = geometry;
  const key = JSON.stringify([
    placeKey(geometry),
    info.closed_parity,
    corners?.length,
    geometry.cad?.deviation,
    isLeftUnchecked(geometry),
  ]);
  if (element.dataset.key === key) return;
  element.dataset.key = key;
  element.replaceChildren(...facts(geometry));
  element.closest('.geometry')?.classList.toggle('doubtful', info.closed_parity !== undefined && !isClosed(info));
}

/** @param {Geometry} geometry */
function card(geometry) {
  const { id, info, name } = geometry;
  const colour = make('input', {
    type: 'color',
    id: `colour-${id}`,
    value: colourOf(geometry.flag),
    'aria-label': `Colour of ${name}`,
    on: { input: ({ target }) => recolour(id, target.value) },
  });
  const nameField = make('input', {
    type: 'text',
    className: 'name',
    value: name,
    disabled: geometry.split,
    maxLength: 64,
    'aria-label': `Name of ${info.file}`,
    on: { input: ({ target }) => edit(id, { name: target.value.replace(/[,:]/g, ' ').trim() || null }) },
  });
  const remove = make(
    'button',
    { type: 'button', className: 'icon', 'aria-label': `Remove ${name}`, on: { click: () => removeGeometry(id) } },
    '×',
  );
  const details = make(
    'div',
    { className: 'drawer', id: `drawer-${id}`, hidden: !isOpen(id) },
    make('div', { id: `facts-${id}` }),
    make(
      'div',
      { className: 'row fields' },
      whole(geometry, 'flag', 'Flag', 1, 255),
      whole(geometry, 'priority', 'Priority', -1000, 1000),
    ),
    fillField(geometry, edit),
    sizingFields(geometry, edit),
    ...(info.solids.length > 1 && info.closed_solids !== undefined ? [splitBox(geometry, info.closed_solids, edit)] : []),
    make(
      'details',
      {},
      make('summary', {}, 'Scale, rotate, move'),
      ...TRANSFORMS.map((transform) => placeField(geometry, ...transform)),
    ),
    materialField(geometry, edit),
  );
  const cells = make('span', { className: 'number of-part', id: `cells-${id}` });
  return make(
    'li',
    { className: 'geometry', 'data-file': info.file, 'data-id': id, on: { keydown: (event) => moveByKey(event, id) } },
    make('div', { className: 'row' }, handle(geometry), colour, nameField, cells, opener(geometry, details), remove),
    details,
  );
}

/** Whether the details of a part are open: those of one or two of the user's parts are, unless somebody closed them. @param {number} id */
function isOpen(id) {
  return opened.get(id) ?? (state.geometries.length <= FEW && !state.isArrival);
}

/** The button that opens and closes the details of a part. @param {Geometry} geometry @param {HTMLElement} details */
function opener({ id, name }, details) {
  const button = make(
    'button',
    {
      type: 'button',
      className: 'icon opener',
      'aria-label': `Details of ${name}`,
      'aria-controls': details.id,
      'aria-expanded': String(isOpen(id)),
    },
    '▾',
  );
  button.addEventListener('click', () => {
    opened.set(id, details.hidden);
    details.hidden = !details.hidden;
    button.ariaExpanded = String(!details.hidden);
  });
  return button;
}

/** Writes the cells of each part of the last mesh, where the mesh is of these parts: none is a warning. */
function showCells() {
  const { mesh, job, geometries } = state;
  for (const geometry of geometries) {
    const element = document.getElementById(`cells-${geometry.id}`);
    if (!element) continue;
    const isOf = job?.geometries.some(({ source }) => source === geometry.surface);
    const flags = new Set(flagsOf(geometry));
    const entries = isOf ? (mesh?.report.flags.filter(({ flag }) => flags.has(flag)) ?? []) : [];
    const n_cells = entries.reduce((sum, { cells }) => sum + cells, 0);
    element.textContent = entries.length > 0 ? SHORT.format(n_cells) : '';
    element.title = entries.length > 0 ? `${count(n_cells)} cells of the last mesh` : '';
    element.classList.toggle('bad', entries.length > 0 && n_cells === 0);
  }
}

/** @param {number} id @param {string} colour */
function recolour(id, colour) {
  const ids = editedWith(id, {});
  for (const geometry of state.geometries) if (ids.has(geometry.id)) state.colours.set(geometry.flag, colour);
  change('colours');
}

/** Facets, box as it is placed, closed or not, volume, and the warnings of the reader. @param {Geometry} geometry */
function facts(geometry) {
  const { info, corners, ...placing } = geometry;
  const { unit } = state.settings;
  const [low, high] = placedBox(info.bounding_box, placing);
  const factors = [placing.scale ?? 1, placing.scale ?? 1, placing.scale ?? 1].flat();
  const size = high.map((end, axis) => end - low[axis]);
  const list = make('dl', { className: 'facts' });
  const fact = (/** @type {string} */ term, /** @type {string} */ value, properties = {}) =>
    list.append(make('dt', {}, term), make('dd', properties, value));
  const n_drawn = (corners?.length ?? 0) / 9;
  const drawn = n_drawn === 0 ? 'not drawn' : `drawn with ${count(n_drawn)}`;
  fact('Facets', n_drawn === info.facets ? count(info.facets) : `${count(info.facets)}, ${drawn}`);
  if (placing.cad) fact('Triangles', deviationText(placing.cad));
  fact('Size', `${times(size)}${unit ? ` ${unit}` : ''}`);
  // so many digits that the ends can be told apart
  const ends = (/** @type {number[]} */ corner) => corner.map((at, axis) => endText(at, size[axis])).join(', ');
  fact('From', ends(low));
  fact('To', ends(high));
  // the volume of an open surface depends on the origin
  fact('Volume', `${isClosed(info) ? '' : 'about '}${measure(info.volume * factors[0] * factors[1] * factors[2], unit, 3)}`);
  fact('Surface', closedness(info), { className: isClosed(info) ? 'good' : 'warn' });
  /** @type {HTMLElement[]} */
  const parts = [list];
  if (isLeftUnchecked(geometry)) {
    const again = { type: 'button', className: 'small', on: { click: () => checkAgain(geometry) } };
    parts.push(make('button', again, 'Check the edges'));
  }
  if (info.warnings.length > 0) {
    parts.push(make('ul', { className: 'warnings' }, ...info.warnings.map((warning) => make('li', {}, sentence(warning)))));
  }
  return parts;
}

/** @param {Geometry['info']} info */
function isClosed(info) {
  return Boolean(info.closed_parity && info.closed_oriented);
}

/** @param {Geometry['info']} info */
function closedness(info) {
  if (info.closed_parity === undefined) return 'edges not checked yet';
  if (isClosed(info)) return (info.shells ?? 1) > 1 ? `closed, ${count(info.shells ?? 1)} shells` : 'closed';
  if (info.closed_parity)
    return `closed, but ${info.flipped_edges ? edges(info.flipped_edges, 'flipped') : 'facets face both ways'}: inside is where the number of crossings is odd`;
  return `not closed: ${info.open_edges ? edges(info.open_edges, 'open') : 'odd numbers of facets meet'}`;
}

/** @param {number} n @param {string} what */
function edges(n, what) {
  return `${count(n)} ${what} edge${n === 1 ? '' : 's'}`;
}

/** @param {Geometry} geometry @param {'flag' | 'priority'} key @param {string} label @param {number} min @param {number} max */
function whole(geometry, key, label, min, max) {
  const input = make('input', {
    type: 'number',
    min,
    max,
    step: 1,
    required: true,
    value: geometry[key],
    className: key,
    'aria-label': `${label} of ${geometry.name}`,
    on: {
      input: ({ target }) => {
        if (target.value !== '' && target.checkValidity()) edit(geometry.id, { [key]: Number(target.value) });
      },
    },
  });
  return make('label', {}, label, input);
}

/** @param {Geometry} geometry @param {'scale' | 'rotate' | 'about' | 'translate'} key @param {string} label @param {string} hint */
function placeField(geometry, key, label, hint) {
  const input = make('input', {
    type: 'text',
    className: key,
    value: writeNumbers(geometry[key]),
    placeholder: key === 'scale' ? '1' : '0 0 0',
    title: hint,
    'aria-label': `${label} ${geometry.name}: ${hint}`,
    'data-name': key === 'scale' ? `Scale of ${geometry.name}` : null,
    inputMode: 'text',
    on: {
      input: ({ target }) => {
        const value = readNumbers(target.value);
        const isRight = value === null || Array.isArray(value) || (value !== undefined && key === 'scale');
        const isZero = key === 'scale' && [value].flat().includes(0);
        target.setCustomValidity(isZero ? 'must not be 0' : isRight ? '' : 'numbers, separated by spaces');
        if (isRight && !isZero) edit(geometry.id, { [key]: value });
      },
    },
  });
  return make('label', { className: 'field' }, label, input);
}

/**
 * What the page knows, in one place. Modules read it freely and change it through `change(topic, patch)`; `on(topics, listener)`
 * hears of it. Topics: mesher, geometries, settings, fields, estimate, phase, mesh, colours, legend.
 */

/** What is asked for where the user says nothing: the defaults of the job. */
export const DEFAULTS = Object.freeze({
  /** Which of the linked fields was set: cells, dims, cell_size or max_cell_size. */
  sizing: 'cells',
  cells: 128,
  dims: null,
  cell_size: null,
  /** Six numbers, or null for the box around all geometries. */
  domain: null,
  /** One number or three. */
  padding: 0,
  padding_by: 'cells',
  rule: 'parity',
  axis: 'auto',
  unit: '',
  backend: 'auto',
});

export const state = {
  /** The Mesher, null while it starts. */
  mesher: null,
  /** `{id, source, sample, surface, info, corners, name, flag, priority, scale, rotate, translate, split}` in meshing order. */
  geometries: [],
  settings: { ...DEFAULTS },
  /** `{result, room}` or `{error, room}` of the last estimate; null without geometries. */
  estimate: null,
  /** starting, idle, reading, meshing or failed. */
  phase: 'starting',
  mesh: null,
  /** The job that made the mesh, and its skin once that is there. */
  job: null,
  skin: null,
  /** The estimate of that job; null where there was none. */
  expected: null,
  /** Colours that the user chose, by flag. */
  colours: new Map(),
  /** Flags that are switched off in the legend. */
  hidden: new Set(),
};

const listeners = [];

/** Hears of topics. */
export function on(topics, listener) {
  listeners.push({ topics: new Set([].concat(topics)), listener });
}

/** Changes the state and tells who listens. */
export function change(topic, patch = {}) {
  Object.assign(state, patch);
  for (const { topics, listener } of listeners) if (topics.has(topic)) listener(topic);
}

/** Changes settings. */
export function set(patch) {
  change('settings', { settings: { ...state.settings, ...patch } });
}

/** Apart in hue and lightness, also for the colour-blind (after Okabe and Ito), on light and on dark. */
const PALETTE = ['#d98324', '#3a8fc9', '#2f9e77', '#c9599a', '#8a6fd1', '#b8a51e', '#d1584a', '#5d7f99', '#7d9b3c', '#a9744f'];

/** Colour of a flag as #rrggbb. */
export function colourOf(flag) {
  return state.colours.get(flag) ?? PALETTE[(flag - 1) % PALETTE.length];
}

/** Red, green and blue of a colour, 0 to 255. */
export function rgb(colour) {
  return [1, 3, 5].map((at) => parseInt(colour.slice(at, at + 2), 16));
}

/** The smallest flag that, with as many after it as asked for, no geometry but `except` has. */
export function freeFlag(n_flags = 1, except = null) {
  const taken = new Set(state.geometries.filter((geometry) => geometry !== except).flatMap(flagsOf));
  for (let flag = 1; flag + n_flags <= 256; flag += 1) if (!range(flag, n_flags).some((one) => taken.has(one))) return flag;
  return 256 - n_flags;
}

/** The flags of a geometry: one, or with `split` one a solid from its first on. */
export function flagsOf({ flag, split, info }) {
  return range(flag, split ? info.solids.length : 1);
}

function range(first, n) {
  return Array.from({ length: n }, (_, at) => first + at);
}

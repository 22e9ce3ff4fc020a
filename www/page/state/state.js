/**
 * The state of the page. Modules read it freely and change it through `change(topic, patch)`, which calls the listeners of the topic;
 * `on(topics, listener)` adds a listener.
 */
import { PALETTE } from './palette.js';

/**
 * @typedef {import('hexcast').Mesher} Mesher
 * @typedef {import('hexcast').Mesh} Mesh
 * @typedef {import('hexcast').Job} Job
 * @typedef {import('hexcast').FileInfo} FileInfo
 * @typedef {import('hexcast').Surface<FileInfo>} Surface
 * @typedef {[number, number, number]} Triple
 * @typedef {[number, number, number, number, number, number]} Box
 */

/** @typedef {{ file: string, x: number[], y: number[], z: number[] }} Lists the lines of a file */

/**
 * What the fields hold.
 *
 * @typedef {object} Settings
 * @property {'cells' | 'dims' | 'cell_size' | 'max_cell_size' | 'graded' | 'lines'} sizing which of the linked fields was set, or that cells differ in size
 * @property {number} cells
 * @property {Triple | null} dims
 * @property {number | Triple | null} cell_size
 * @property {number | Triple | null} graded largest size of a cell where cells differ in size
 * @property {number | null} min_size smallest size there; null for a thousandth of the largest
 * @property {number} growth most times by which a cell is larger than its neighbour there
 * @property {number | Triple} absorbing cells added at the ends there
 * @property {Lists | null} lines those of the user's own
 * @property {Box | null} domain null for the box around all geometries
 * @property {number | Triple} padding
 * @property {'cells' | 'length'} padding_by
 * @property {'parity' | 'nonzero'} rule
 * @property {'winding' | 'vote' | 'error' | 'parity'} open how cells are decided where a surface is not closed
 * @property {'centre' | 'conservative' | 'separating'} fill which cells along surfaces geometries have as well
 * @property {number} close_gaps openings narrower than so many cells are closed; 0 for none
 * @property {boolean} certify whether thin walls and overlaps are looked for
 * @property {number} thin_cells walls of fewer cells are thin
 * @property {boolean} links whether links to surfaces are measured
 * @property {'D3Q7' | 'D3Q15' | 'D3Q19' | 'D3Q27'} stencil of these links
 * @property {number[]} fluid flags of the cells in which they begin
 * @property {boolean} fractions whether fractions of cells are measured
 * @property {number} fraction_rays rays of a cell along each of two axes; 0 to measure exactly
 * @property {boolean} fraction_faces whether those of faces are, too
 * @property {boolean} fraction_surfaces whether surfaces within cells are, too
 * @property {boolean} fraction_edges whether edges are, where cells are measured exactly
 * @property {boolean} fraction_centroids whether centres of parts of cells are, too
 * @property {boolean} staggered whether the points of a staggered grid get flags
 * @property {boolean} conformal whether edges and faces outside metal are measured
 * @property {boolean} distance whether cells get signed distances
 * @property {boolean} tensors whether permittivity is smoothed at the points of E
 * @property {boolean} cut_cells whether the cells of one flag are cut at its surface
 * @property {number | null} cut_fluid that flag; null for that of the geometries
 * @property {'auto' | 'x' | 'y' | 'z'} axis
 * @property {string} unit
 * @property {import('hexcast').Material | null} background what the background is made of
 * @property {import('hexcast').BackendChoice} backend
 */

/**
 * A geometry on the page.
 *
 * @typedef {object} Geometry
 * @property {number} id
 * @property {File} source
 * @property {string | null} sample that it is of
 * @property {Surface} surface
 * @property {FileInfo & Partial<import('hexcast').SurfaceInfo>} info without what edges tell until these were looked at
 * @property {Float32Array | null} corners what is drawn: of a surface with many facets fewer ones, and none until they are there
 * @property {import('../geometries/cad.js').Converted | null} cad what a file of CAD was converted to; null for other files
 * @property {string | null} name
 * @property {number} flag
 * @property {number} priority
 * @property {Settings['fill'] | null} fill which cells along its surface it has as well; null for those that all parts have
 * @property {number | Triple | null} scale
 * @property {Triple | null} rotate
 * @property {Triple | null} about the point about which it rotates
 * @property {Triple | null} translate
 * @property {boolean} split
 * @property {number | null} max_size where lines are graded, largest size of a cell across it
 * @property {number | null} min_cells and fewest cells across it
 * @property {boolean} metal and whether lines lie beside its edges
 * @property {import('hexcast').Material | null} material what it is made of
 */

/** @typedef {{ settings: Partial<Settings>, entries: { index: number, keys: { [key: string]: unknown } | null }[] }} Changes of settings, and of entries of the job by their indices; null for one that is left out */
/** @typedef {{ label: string, act: () => void, changes?: Changes }} Remedy a button with what helps, and what that changes, where it is settings of the page */

/**
 * A card of the list of problems.
 *
 * @typedef {object} Finding
 * @property {import('hexcast').FindingCode | 'overlap' | 'leak'} kind
 * @property {string} subject whose place is shown, for the button
 * @property {string} title in a few words
 * @property {string} text a sentence or more
 * @property {number[] | null} place in world lengths; null where it has none in the mesh
 * @property {number[][]} boxes where it is, of six numbers each, the least coordinates first
 * @property {number | null} flag of the part that it is about
 * @property {Remedy[]} remedies what helps
 */

/**
 * @typedef {object} State
 * @property {Mesher | null} mesher null while it starts
 * @property {Geometry[]} geometries in meshing order
 * @property {boolean} isArrival whether they are the sample that the page took by itself
 * @property {number} revision changes where geometries were changed by other means than their fields
 * @property {Geometry[] | null} patches open geometries that are one closed surface together
 * @property {Settings} settings
 * @property {Estimated | null} estimate the last; null without geometries
 * @property {'starting' | 'idle' | 'reading' | 'meshing' | 'updating' | 'failed'} phase updating while the page meshes without a click
 * @property {boolean} live whether it does so where that takes a moment
 * @property {{ key: string, mesher: Mesher | null } | null} left the job that it does not mesh without a click: its last mesh was cancelled, failed, or a file took its place
 * @property {Mesh | null} mesh
 * @property {ShownJob | null} job that made the mesh
 * @property {Promise<import('hexcast').AllRuns> | null} runs of the mesh, for the 3-D view, which takes them
 * @property {import('hexcast').Estimate | null} expected the estimate of that job; null where there was none
 * @property {Finding[]} findings of the mesh
 * @property {number} finding index of the one that is shown, -1 for none
 * @property {import('hexcast').Leak | null} leak that was looked for in the mesh
 * @property {(import('hexcast').Difference & { file: string }) | null} difference of the mesh and that of a file
 * @property {Map<number, string>} colours that the user chose, by flag
 * @property {Set<number>} hidden flags that are switched off in the legend
 *
 * @typedef {{ job: ReturnType<typeof import('./job.js').currentJob>, result?: import('hexcast').Estimate, error?: import('hexcast').HexcastError, freeBytes: number }} Estimated
 * @typedef {{ geometries: { file?: string, name?: string, source?: Surface }[] }} ShownJob as much of a job as is shown
 * @typedef {'mesher' | 'geometries' | 'patches' | 'settings' | 'fields' | 'estimate' | 'phase' | 'live' | 'mesh' | 'leak' | 'difference' | 'findings' | 'colours' | 'legend' | 'look' | 'panes' | 'crosshair' | 'stretch' | 'measure'} Topic
 */

/** Settings that ask for what is measured: switches of the page, of which a link has those that are on. */
export const MEASURED = /** @type {const} */ ([
  'links',
  'fractions',
  'fraction_faces',
  'fraction_surfaces',
  'fraction_edges',
  'fraction_centroids',
  'staggered',
  'conformal',
  'distance',
  'tensors',
  'cut_cells',
]);

/** The defaults of the job. @type {Readonly<Settings>} */
export const DEFAULTS = Object.freeze({
  sizing: 'cells',
  cells: 128,
  dims: null,
  cell_size: null,
  graded: null,
  min_size: null,
  growth: 1.3,
  absorbing: 0,
  lines: null,
  domain: null,
  padding: 0,
  padding_by: 'cells',
  rule: 'parity',
  open: 'winding',
  fill: 'centre',
  close_gaps: 0,
  certify: false,
  thin_cells: 2,
  links: false,
  stencil: 'D3Q19',
  fluid: [0],
  fractions: false,
  fraction_rays: 0,
  fraction_faces: false,
  fraction_surfaces: false,
  fraction_edges: false,
  fraction_centroids: false,
  staggered: false,
  conformal: false,
  distance: false,
  tensors: false,
  cut_cells: false,
  cut_fluid: null,
  axis: 'auto',
  unit: '',
  background: null,
  backend: 'auto',
});

/** What a geometry has that nobody set. */
export const PLAIN = Object.freeze({
  priority: 0,
  fill: null,
  scale: null,
  rotate: null,
  about: null,
  translate: null,
  split: false,
  max_size: null,
  min_cells: null,
  metal: false,
  material: null,
});

/** @type {State} */
export const state = {
  mesher: null,
  geometries: [],
  isArrival: false,
  revision: 0,
  patches: null,
  settings: { ...DEFAULTS },
  estimate: null,
  phase: 'starting',
  live: true,
  left: null,
  mesh: null,
  job: null,
  runs: null,
  expected: null,
  findings: [],
  finding: -1,
  leak: null,
  difference: null,
  colours: new Map(),
  hidden: new Set(),
};

/** @type {{ topics: Set<Topic>, listener: (topic: Topic) => void }[]} */
const listeners = [];

/** Adds a listener to topics. @param {Topic | Topic[]} topics @param {(topic: Topic) => void} listener */
export function on(topics, listener) {
  listeners.push({ topics: new Set([topics].flat()), listener });
}

/** Changes the state and calls the listeners. @param {Topic} topic @param {Partial<State>} [patch] */
export function change(topic, patch = {}) {
  Object.assign(state, patch);
  for (const { topics, listener } of listeners) if (topics.has(topic)) listener(topic);
}

/** Changes settings. @param {Partial<Settings>} patch */
export function set(patch) {
  change('settings', { settings: { ...state.settings, ...patch } });
}

/** Colour of a flag as #rrggbb: one of the palette, after its end darker and lighter in turn. @param {number} flag */
export function colourOf(flag) {
  const own = state.colours.get(flag);
  if (own) return own;
  const turn = Math.floor((flag - 1) / PALETTE.length);
  const colour = PALETTE[(flag - 1) % PALETTE.length];
  const [to, share] = [turn % 2 ? 0 : 255, 0.13 * Math.ceil(turn / 2)];
  const parts = rgb(colour).map((part) => Math.round(part + (to - part) * share));
  return `#${parts.map((part) => part.toString(16).padStart(2, '0')).join('')}`;
}

/** Red, green and blue of a colour, 0 to 255. @param {string} colour */
export function rgb(colour) {
  return [1, 3, 5].map((at) => parseInt(colour.slice(at, at + 2), 16));
}

/** Whether two geometries are the same surface at the same place. @param {Geometry} one @param {Geometry} other */
export function isSame(one, other) {
  return one.info.blake3 === other.info.blake3 && placeKey(one) === placeKey(other);
}

/** Where a geometry is placed, to be compared. @param {Geometry} geometry */
export function placeKey({ scale, rotate, about, translate }) {
  return JSON.stringify([scale, rotate, about, translate]);
}

/** The smallest flag that, with as many after it as asked for, no geometry but `except` has. @param {Geometry | null} except */
export function freeFlag(n_flags = 1, except = null) {
  const taken = new Set(state.geometries.filter((geometry) => geometry !== except).flatMap(flagsOf));
  for (let flag = 1; flag + n_flags <= 256; flag += 1) if (!range(flag, n_flags).some((one) => taken.has(one))) return flag;
  return 256 - n_flags;
}

/**
 * The flags of a geometry: one, or with `split` one a solid from its first on.
 *
 * @param {{ flag: number, split: boolean, info: FileInfo }} geometry
 */
export function flagsOf({ flag, split, info }) {
  return range(flag, split ? info.solids.length : 1);
}

/** @param {number} first @param {number} n */
function range(first, n) {
  return Array.from({ length: n }, (_, at) => first + at);
}

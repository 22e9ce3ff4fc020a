/** Remedies of findings: their patches of the job, as changes of the fields and the geometries of the page. */
import { removeGeometry } from '../geometries/files.js';
import { change, set, state } from '../state/state.js';

/** @typedef {import('../state/state.js').Settings} Settings @typedef {import('../state/state.js').Changes} Changes @typedef {{ [key: string]: unknown }} Patch */

/** Keys of jobs that fields have by the same names. */
const FIELDS = ['rule', 'open', 'fill', 'close_gaps', 'certify', 'thin_cells', 'staggered', 'unit'];
/** Sizes of cells: one of them leads. */
const SIZES = /** @type {const} */ (['cells', 'dims', 'cell_size']);
/** Those of generated lines. */
const GRADED_FIELDS = ['min_size', 'growth'];
/** Keys of geometries that their fields have by the same names. */
const GEOMETRY_FIELDS = ['flag', 'priority', 'fill', 'scale', 'max_size', 'min_cells'];

/** Those remedies of a finding that the page has fields for. @param {import('hexcast').Finding} finding @returns {import('../state/state.js').Remedy[]} */
export function remediesOf({ remedies }) {
  return remedies.flatMap(({ label, patch }) => {
    const changes = changesOf(patch);
    return changes ? [remedyOf(label, changes)] : [];
  });
}

/** @param {string} label @param {Changes} changes @returns {import('../state/state.js').Remedy} */
export function remedyOf(label, changes) {
  return { label, act: () => apply(changes), changes };
}

/** The same remedy of several findings as one. @param {string} label @param {Changes[]} all */
export function togetherOf(label, all) {
  /** @type {Partial<Settings>} */
  const settings = Object.assign({}, ...all.map(({ settings }) => settings));
  // the smallest of what each needs
  if (settings.min_size) settings.min_size = Math.min(...all.map((one) => one.settings.min_size ?? Infinity));
  return remedyOf(label, { settings, entries: all.flatMap(({ entries }) => entries) });
}

/**
 * What a patch changes: settings, and entries of the job by their indices; null for one that is left out. Null where the page lacks a field.
 *
 * @param {Patch} patch
 * @returns {Changes | null}
 */
function changesOf({ graded, geometries, ...fields }) {
  const ofGraded = /** @type {Patch} */ (graded ?? {});
  const entries = Object.entries(/** @type {{ [index: string]: Patch | null }} */ (geometries ?? {})).map(([index, keys]) => {
    // what is said of all geometries need not be said of one
    const own = keys && Object.entries(keys).filter(([key, value]) => fields[key] !== value);
    return { index: Number(index), keys: own && Object.fromEntries(own) };
  });
  const isKnown =
    hasOnly(fields, [...FIELDS, ...SIZES]) &&
    hasOnly(ofGraded, GRADED_FIELDS) &&
    entries.every(({ keys }) => hasOnly(keys ?? {}, GEOMETRY_FIELDS));
  const size = SIZES.find((key) => key in fields);
  const settings = /** @type {Partial<Settings>} */ ({ ...fields, ...(size ? { sizing: size } : {}), ...ofGraded });
  const changed = entries.filter(({ keys }) => !keys || Object.keys(keys).length > 0);
  return isKnown ? { settings, entries: changed } : null;
}

/** @param {Patch} patch @param {string[]} known */
function hasOnly(patch, known) {
  return Object.keys(patch).every((key) => known.includes(key));
}

/** The settings and geometries of the page once they are changed. @param {Changes} changes */
export function changed({ settings, entries }) {
  let { geometries } = state;
  for (const { index, keys } of entries) {
    // the geometries of the page may be others than those of the mesh by now
    const source = state.job?.geometries[index]?.source;
    geometries = geometries.flatMap((geometry) => {
      if (geometry.surface !== source) return [geometry];
      return keys ? [{ ...geometry, ...keys }] : [];
    });
  }
  return { settings: { ...state.settings, ...settings }, geometries };
}

/** @param {Changes} changes */
function apply(changes) {
  const { geometries } = changed(changes);
  const gone = state.geometries.filter(({ id }) => !geometries.some((other) => other.id === id));
  for (const { id } of gone) removeGeometry(id);
  if (changes.entries.some(({ keys }) => keys)) change('geometries', { geometries, revision: state.revision + 1 });
  if (Object.keys(changes.settings).length > 0) set(changes.settings);
}

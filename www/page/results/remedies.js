/** Remedies of findings as buttons: their patches of the job, applied to the fields and the geometries of the page. */
import { removeGeometry } from '../geometries/files.js';
import { change, set, state } from '../state/state.js';

/** @typedef {import('../state/state.js').Settings} Settings @typedef {{ [key: string]: unknown }} Patch */

/** Keys of jobs that fields have by the same names. */
const FIELDS = ['rule', 'open', 'fill', 'close_gaps', 'certify', 'thin_cells', 'staggered', 'unit'];
/** Sizes of cells: one of them leads. */
const SIZES = /** @type {const} */ (['cells', 'dims', 'cell_size']);
/** Those of generated lines. */
const GRADED_FIELDS = ['min_size', 'growth'];
/** Keys of geometries that their fields have by the same names. */
const GEOMETRY_FIELDS = ['flag', 'priority', 'scale', 'max_size', 'min_cells'];

/** Those remedies of a finding that the page has fields for. @param {import('hexcast').Finding} finding @returns {import('../state/state.js').Remedy[]} */
export function remediesOf({ remedies }) {
  return remedies.flatMap(({ label, patch }) => {
    const changes = changesOf(patch);
    return changes ? [{ label, act: () => apply(changes), key: JSON.stringify(changes) }] : [];
  });
}

/**
 * What a patch changes: settings, and entries of the job by their indices; null for one that is left out. Null where the page lacks a field.
 *
 * @param {Patch} patch
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

/** @param {NonNullable<ReturnType<typeof changesOf>>} changes */
function apply({ settings, entries }) {
  for (const { index, keys } of entries) {
    // the geometries of the page may be others than those of the mesh by now
    const source = state.job?.geometries[index]?.source;
    const mine = state.geometries.find(({ surface }) => surface === source);
    if (!mine) continue;
    if (!keys) removeGeometry(mine.id);
    else {
      const geometries = state.geometries.map((geometry) => (geometry === mine ? { ...geometry, ...keys } : geometry));
      change('geometries', { geometries, revision: state.revision + 1 });
    }
  }
  if (Object.keys(settings).length > 0) set(settings);
}

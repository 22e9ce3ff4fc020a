/** Files of CAD: converted to triangles so fine as the cells ask for. What converts them is loaded with the first. */
import { task } from '../elements/tasks.js';
import { showNotice } from '../elements/messages.js';
import { bytes, count, short } from '../text/format.js';
import { freeFlag, state } from '../state/state.js';

/** @typedef {Pick<import('hexcast/cad').Cad, 'bodies' | 'unit' | 'deviation'>} Converted */

/** Triangles are at most so many cells away from the surface. */
export const SHARE = 0.1;
const LAST_FLAG = 255;
/** @type {readonly string[]} */
const UNITS = ['mm', 'cm', 'm', 'in', 'ft'];

/** Whether a file is one of CAD, by its name. @param {File} file */
export function isCad({ name }) {
  return /\.(step|stp|iges|igs)(\.gz)?$/i.test(name);
}

/** Says that a file may be too large, before it is tried. @param {File} file */
export async function warnOfSize(file) {
  if (!isCad(file)) return;
  const { largeBytes } = await import('hexcast/cad');
  if (file.size <= largeBytes) return;
  showNotice(
    `${file.name} has ${bytes(file.size)}: above ${bytes(largeBytes)} the 2 GiB that Open CASCADE can address in a page may not suffice. If it fails, export the file in parts or as STL, or use the command`,
  );
}

/**
 * Converts a file, in the unit of the settings where Open CASCADE knows it.
 *
 * @param {File} source
 * @param {number} [deviation]
 */
export async function convert(source, deviation) {
  const { unit } = state.settings;
  const asked = deviation === undefined ? fineness() : { deviation };
  const { surface, ...cad } = await task(`Converting ${source.name}`, async ({ signal }) => {
    const { readCad } = await import('hexcast/cad');
    const known = /** @type {import('hexcast/cad').CadUnit} */ (UNITS.includes(unit) ? unit : 'mm');
    return readCad(source, { ...asked, unit: known, signal });
  });
  return { surface, cad: /** @type {Converted} */ (cad) };
}

/** What the settings say of the size of cells, before it is known how large the file is. @returns {{ cells: number } | { deviation: number }} */
function fineness() {
  const { sizing, cells, dims, cell_size, graded } = state.settings;
  const size = sizing === 'graded' ? graded : sizing === 'cell_size' || sizing === 'max_cell_size' ? cell_size : null;
  if (size !== null) return { deviation: SHARE * Math.min(...[size].flat()) };
  return { cells: sizing === 'dims' && dims ? Math.max(...dims) : cells };
}

/**
 * Settings of a geometry of a file of CAD: each body is one, with its own flag, unless a link says otherwise.
 *
 * @param {Converted | null} cad
 * @param {boolean} isLinked
 */
export function settingsOf(cad, isLinked) {
  if (!cad || cad.bodies.length < 2 || isLinked) return {};
  const flag = freeFlag(cad.bodies.length);
  if (flag >= 1 && flag + cad.bodies.length - 1 <= LAST_FLAG) return { split: true, flag };
  showNotice(`the ${count(cad.bodies.length)} bodies are one geometry: flags end at ${LAST_FLAG}, and others have some of them`);
  return {};
}

/** How far the triangles are from the surface. @param {Converted} cad */
export function deviationText({ deviation, unit, bodies }) {
  const of = bodies.length > 1 ? `of ${count(bodies.length)} bodies, ` : '';
  return `${of}at most ${short(deviation)} ${unit} from the surface`;
}

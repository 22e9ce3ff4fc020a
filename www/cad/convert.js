/** The bytes of a STEP or IGES file -> a 3MF file of its bodies; runs in a thread of its own, where it cannot be interrupted. */
import { bodiesOf, boxOf } from './bodies.js';
import { UNITS, threeMf } from './three_mf.js';

/**
 * @typedef {(options: object) => Promise<{ ReadFile(kind: string, bytes: Uint8Array, options: object): import('./bodies.js').Read }>} Occt
 * @typedef {object} Request
 * @property {Uint8Array} bytes of the file
 * @property {'step' | 'iges'} kind
 * @property {string} unit of coordinates
 * @property {number} deviation largest distance of triangles from surfaces; 0 where it follows from `cells`
 * @property {number} cells along the longest axis
 * @property {string} wasm address of Open CASCADE
 * @typedef {object} Converted
 * @property {Blob} surface the 3MF file
 * @property {{ name: string, colour: string | null, facets: number }[]} bodies
 * @property {number[]} box around all of them
 * @property {boolean} isRead whether Open CASCADE could read it
 */

/** Triangles may be a tenth of a cell away from the surface. */
export const SHARE = 0.1;
/** Radians between the normals of triangles side by side, at most. */
const ANGLE = 0.5;

/** @param {Occt} occt @param {Request} request @returns {Promise<Converted>} */
export async function convert(occt, { bytes, kind, unit, deviation, cells, wasm }) {
  const quiet = () => {};
  const module = await occt({ locateFile: () => wasm, print: quiet, printErr: quiet });
  const read = module.ReadFile(kind, bytes, {
    linearUnit: UNITS[unit],
    // the mean edge of the box is no longer than the longest, which has the cells
    linearDeflectionType: deviation > 0 ? 'absolute_value' : 'bounding_box_ratio',
    linearDeflection: deviation > 0 ? deviation : SHARE / cells,
    angularDeflection: ANGLE,
  });
  const bodies = read.success ? bodiesOf(read) : [];
  return {
    isRead: read.success,
    // it goes to the other thread without a copy
    surface: new Blob(threeMf(bodies, unit), { type: 'model/3mf' }),
    bodies: bodies.map(({ name, colour, index }) => ({ name, colour, facets: index.length / 3 })),
    box: boxOf(bodies),
  };
}

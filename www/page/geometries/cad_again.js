/** Files of CAD are converted again where the size of cells changed: by more than twice, as each time all of a file is read. */
import { SHARE } from './cad.js';
import { isQuiet } from './files.js';
import { debounce } from '../elements/dom.js';
import { showError } from '../elements/messages.js';
import { change, on, state } from '../state/state.js';
import { readSurface } from './surfaces.js';

/** @typedef {import('../state/state.js').Geometry} Geometry */

/** A deviation that differs by no more than so many times stays. */
const TIMES = 2;
/** Milliseconds without a change of the settings after which a file is converted. */
const PATIENCE = 500;

/** Deviations that were asked for last, by the files: what the user ended, or what failed, is not tried again for the same cells. @type {WeakMap<File, number>} */
const asked = new WeakMap();
let isBusy = false;

/** Looks at the size of cells whenever it is estimated anew. */
export function startCadAgain() {
  on(['estimate', 'phase'], debounce(look, PATIENCE));
}

async function look() {
  if (isBusy || state.phase !== 'idle') return;
  const geometry = state.geometries.find((one) => isOff(one, wantedOf(one)));
  const wanted = geometry ? wantedOf(geometry) : null;
  if (!geometry || !wanted) return;
  isBusy = true;
  asked.set(geometry.source, wanted);
  try {
    await convertAgain(geometry, wanted);
  } catch (error) {
    showError(error, geometry.source.name);
  } finally {
    isBusy = false;
  }
  look();
}

/** The deviation that the cells ask for, in the unit of the file; null where none is known. @param {Geometry} geometry */
function wantedOf({ scale }) {
  const { result } = state.estimate ?? {};
  const sizes = result?.spacing ?? result?.grading?.largest;
  if (!sizes) return null;
  return (SHARE * Math.min(...sizes)) / Math.max(...[scale ?? 1].flat().map(Math.abs));
}

/** @param {Geometry} geometry @param {number | null} wanted */
function isOff({ cad, source }, wanted) {
  if (!cad || !wanted) return false;
  const times = wanted / (asked.get(source) ?? cad.deviation);
  // what rounding makes of twice is not more than that
  return Math.max(times, 1 / times) > 1.001 * TIMES;
}

/** @param {Geometry} geometry @param {number} deviation */
async function convertAgain({ id, surface, source }, deviation) {
  const { mesher } = state;
  if (!mesher) return;
  const read = await readSurface(mesher, source, deviation);
  await isQuiet();
  // it was removed meanwhile, or read again for another reason
  if (mesher !== state.mesher || !state.geometries.some((one) => one.id === id && one.surface === surface))
    return read.surface.dispose();
  surface.dispose();
  const geometries = state.geometries.map((one) => (one.id === id ? { ...one, ...read } : one));
  change('geometries', { geometries, revision: state.revision + 1 });
}

/** Meshes of coarser cells while the slider moves, where those that it asks for take too long to follow it. */
import { onInput } from '../elements/dom.js';

/** @typedef {ReturnType<typeof import('../state/job.js').currentJob>} Job */

/** Milliseconds after the last step of the slider until which it moves. */
const MOVING = 200;
/** Milliseconds that a mesh may take while it does. */
const PATIENCE = 100;
/** Fewer cells along the longest axis say nothing of the surface. */
const LEAST = 32;

let lastStep = -Infinity;
/** The last mesh that was not coarse, and the last that was: cells along the longest axis, and milliseconds. @type {{ n: number, ms: number }[]} */
const [fine, rough] = [
  { n: 0, ms: 0 },
  { n: 0, ms: 0 },
];

/** Watches the slider. */
export function startCoarse() {
  onInput('fineness', 'input', () => {
    lastStep = performance.now();
  });
}

/** Milliseconds until the slider rests, if nobody moves it again. */
export function untilRest() {
  return Math.max(0, lastStep + MOVING - performance.now());
}

/** Takes how long a mesh took. @param {boolean} isCoarse @param {number[]} dims @param {number} ms */
export function takePace(isCoarse, dims, ms) {
  Object.assign(isCoarse ? rough : fine, { n: Math.max(...dims), ms });
}

/**
 * The same job with cells of two, four, ... times the size, so that a mesh follows the slider; null where it is fast enough, or rests, or its sizes are lists.
 *
 * @param {Job} job
 * @param {number[]} dims of its mesh
 * @returns {Job | null}
 */
export function coarser(job, dims) {
  if (fine.n === 0 || untilRest() === 0) return null;
  // a part goes with the columns of cells, the rest with facets, which coarser cells do not change
  const isKnown = rough.n > 0 && rough.n < fine.n;
  const column = isKnown ? Math.max(0, fine.ms - rough.ms) / (fine.n ** 2 - rough.n ** 2) : fine.ms / fine.n ** 2;
  const rest = Math.max(0, fine.ms - column * fine.n ** 2);
  const most = Math.max(PATIENCE - rest, rest / 4);
  const n = Math.max(...dims);
  let times = 1;
  while (column * (n / times) ** 2 > most && n / (2 * times) >= LEAST) times *= 2;
  return times > 1 ? withCells(job, times) : null;
}

/** The slider makes a number of cells of a number for each axis. @param {Job} job @param {number} times @returns {Job | null} */
function withCells(job, times) {
  const { cells, cell_size, max_cell_size } = job;
  if (cells) return { ...job, cells: Math.ceil(cells / times) };
  if (typeof cell_size === 'number') return { ...job, cell_size: cell_size * times };
  if (typeof max_cell_size === 'number') return { ...job, max_cell_size: max_cell_size * times };
  return null;
}

/** The runs of all rays, out of the wasm in parts. */
import { cancelled, pause } from '../protocol/call.js';

/** Runs that are copied between two looks for messages. */
const RUNS_AT_A_TIME = 1 << 20;

/**
 * Copies the runs of all rays.
 *
 * @param {import('../hexcast_wasm.js').WebMesh} mesh
 * @param {number} rays
 * @param {import('../protocol/call.js').Listener} progress
 * @param {import('../protocol/call.js').State} state
 */
export async function allRuns(mesh, rays, progress, state) {
  const [n_runs] = mesh.columnFacts();
  const columns = { offsets: new Uint32Array(rays + 1), starts: new Uint32Array(n_runs), flags: new Uint8Array(n_runs) };
  const n_rays = Math.ceil(RUNS_AT_A_TIME / (n_runs / rays + 1));
  for (let first = 0; first < rays; first += n_rays) {
    unpack(mesh.rays(first, Math.min(n_rays, rays - first)), first, columns);
    progress({ stage: 'read', done: columns.offsets[Math.min(first + n_rays, rays)], total: n_runs });
    await pause();
    if (state.cancelled) throw cancelled();
  }
  return columns;
}

/**
 * Puts the runs of rays from a ray on into the arrays of all: each ray's come behind their number, packed as `start << 8 | flag`.
 *
 * @param {Uint32Array} packed
 * @param {number} ray
 * @param {{ offsets: Uint32Array, starts: Uint32Array, flags: Uint8Array }} columns
 */
function unpack(packed, ray, { offsets, starts, flags }) {
  for (let at = 0; at < packed.length; ray += 1) {
    let to = offsets[ray];
    for (const end = at + 1 + packed[at++]; at < end; at += 1, to += 1) {
      starts[to] = packed[at] >>> 8;
      flags[to] = packed[at] & 255;
    }
    offsets[ray + 1] = to;
  }
}

/**
 * The runs of cells that an update of a scene changed, of five numbers each; null where all may have.
 *
 * @param {Uint32Array | undefined} packed
 */
export function changedRuns(packed) {
  if (!packed) return null;
  const n = packed.length / 5;
  const of = (/** @type {number} */ part) => (/** @type {unknown} */ _, /** @type {number} */ run) => packed[5 * run + part];
  const numbers = (/** @type {number} */ part) => Uint32Array.from({ length: n }, of(part));
  const flags = (/** @type {number} */ part) => Uint8Array.from({ length: n }, of(part));
  return { rays: numbers(0), starts: numbers(1), ends: numbers(2), before: flags(3), after: flags(4) };
}

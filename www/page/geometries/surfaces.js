/**
 * Surfaces of files: read, looked at and drawn. One of many facets can be meshed as soon as it is read; its picture, of fewer facets,
 * and what its edges are follow.
 */
import { convert, isCad } from './cad.js';
import { showError } from '../elements/messages.js';
import { change, on, state } from '../state/state.js';
import { task } from '../elements/tasks.js';

/** @typedef {import('../state/state.js').Geometry} Geometry @typedef {Pick<Geometry, 'surface' | 'info' | 'corners' | 'cad'>} Read */

/** The 3-D view draws no more facets of a surface: of one with more, a preview. */
export const DRAWN_FACETS = 1_000_000;

/** Surfaces whose picture and edges are not there yet, with what ends the work on them. @type {Map<Geometry['surface'], AbortController>} */
const unfinished = new Map();

/** Surfaces whose edges the user did not want to be looked at. @type {WeakSet<Geometry['surface']>} */
const unchecked = new WeakSet();

/** Whether the work on the edges of a surface was ended. @param {Geometry} geometry */
export function isLeftUnchecked({ surface }) {
  return unchecked.has(surface);
}

/** Finishes what was read of large surfaces, and ends that where one is removed. */
export function startSurfaces() {
  on('geometries', () => {
    const live = new Set(state.geometries.map(({ surface }) => surface));
    for (const [surface, stop] of unfinished) if (!live.has(surface)) stop.abort();
    for (const geometry of state.geometries) {
      const { surface, info } = geometry;
      if (info.closed_parity === undefined && !unfinished.has(surface) && !unchecked.has(surface)) finish(geometry);
    }
  });
}

/**
 * Reads a file; of a surface with many facets, the facts of its file only.
 *
 * @param {import('hexcast').Mesher} mesher
 * @param {File} source
 * @param {number} [deviation] of the triangles of a file of CAD; by default it follows from the settings
 * @returns {Promise<Read>}
 */
export async function readSurface(mesher, source, deviation) {
  const made = isCad(source) ? await convert(source, deviation) : null;
  const cad = made?.cad ?? null;
  const surface = await task(`Reading ${source.name}`, (options) =>
    mesher.read(made?.surface ?? source, { ...options, file: source.name, check: false }),
  );
  if (surface.info.facets > DRAWN_FACETS) return { surface, info: surface.info, corners: null, cad };
  try {
    const { info } = await task(`Checking the edges of ${source.name}`, (options) => surface.check(options));
    return { surface, info, corners: await surface.corners(), cad };
  } catch (error) {
    surface.dispose();
    throw error;
  }
}

/** Looks at the edges of a surface after all. @param {Geometry} geometry */
export function checkAgain(geometry) {
  unchecked.delete(geometry.surface);
  finish(geometry);
}

/** Draws a surface and looks at its edges, where that was not done. @param {Geometry} geometry */
async function finish({ surface, source, corners }) {
  const stop = new AbortController();
  unfinished.set(surface, stop);
  try {
    if (!corners) {
      const drawn = await task(`Drawing ${source.name}`, (options) => surface.preview(DRAWN_FACETS, options), stop.signal).catch(
        (error) => failed(error, source, stop),
      );
      if (drawn) put(surface, { corners: drawn });
    }
    if (stop.signal.aborted) return;
    const checked = await task(`Checking the edges of ${source.name}`, (options) => surface.check(options), stop.signal).catch(
      (error) => failed(error, source, stop),
    );
    if (!checked) unchecked.add(surface);
    put(surface, { info: checked?.info ?? surface.info });
  } finally {
    unfinished.delete(surface);
  }
}

/** What was not done is left out; a failure is said. @param {unknown} error @param {File} source @param {AbortController} stop @returns {null} */
function failed(error, source, stop) {
  if (!stop.signal.aborted) showError(error, source.name);
  return null;
}

/** Changes a geometry, if it is still there: its card is made anew where that shows solids. @param {Geometry['surface']} surface @param {Partial<Geometry>} patch */
function put(surface, patch) {
  if (!state.geometries.some((geometry) => geometry.surface === surface)) return;
  const geometries = state.geometries.map((geometry) => (geometry.surface === surface ? { ...geometry, ...patch } : geometry));
  const isSplit = patch.info && patch.info.solids.length > 1;
  change('geometries', { geometries, revision: state.revision + (isSplit ? 1 : 0) });
}

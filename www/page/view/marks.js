/** Marks of what was found in the 3-D view: rings at places, boxes of walls without cells, and parts without cells. */
import { flagsOf, state } from '../state/state.js';
import { withScene } from './scene_holder.js';

/** Findings of walls without cells. */
const LOST = /^(no-cell-.*|shell-lost|wall-thin)$/;
/** Boxes that are drawn at most. */
const MOST_BOXES = 200;

/** Those of a mesh that is only previewed. @type {Parameters<import('./scene.js').Scene['mark']>[0]} */
export const NO_MARKS = { places: [], current: -1, path: [], marked: [], lost: [] };

/** Marks what was found. */
export function mark() {
  const { findings, finding: current, leak } = state;
  const places = findings.map(({ place }) => place);
  const lost = findings.filter(({ kind }) => LOST.test(kind)).flatMap(({ boxes }) => boxes);
  const marked = findings[current]?.boxes ?? [];
  const path = leak?.path?.points ?? [];
  withScene((scene) => scene.mark({ places, current, path, marked, lost: lost.slice(0, MOST_BOXES) }));
}

/** The corners of the parts that have no cell. @param {import('hexcast').Report} report */
export function lostParts({ findings }) {
  const flags = new Set(findings.filter(({ code }) => code.startsWith('no-cell-')).map(({ flag }) => flag));
  const lost = state.geometries.filter((geometry) => flagsOf(geometry).every((flag) => flags.has(flag)));
  return lost.flatMap(({ corners }) => corners ?? []);
}

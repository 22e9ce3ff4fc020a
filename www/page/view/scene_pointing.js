/** What people point at in the 3-D view: a click puts the crosshair on a cell, the pointer names the cell below it, keys turn. */
import { byId } from '../elements/dom.js';
import { on, state } from '../state/state.js';
import { centreOf } from '../text/places.js';
import { crosshair, moveTo } from './crosshair.js';
import { measured } from './measure.js';
import { areFour } from './panes.js';
import { picked } from './pick.js';
import { nameCell } from './readout.js';
import { held, withScene } from './scene_holder.js';

/**
 * Connects the keys, and returns what the scene calls.
 *
 * @param {() => boolean} hasCells whether the cells of the mesh are seen
 * @param {() => void} fit
 */
export function startPointing(hasCells, fit) {
  const canvas = byId('canvas-3d');
  /** Whether the cell below the pointer is looked for. */
  let isLooking = false;
  const seenAt = async (/** @type {number} */ x, /** @type {number} */ y) =>
    (hasCells() && (await held.scene?.pick(x, y))) || null;
  canvas.addEventListener('keydown', (event) => takeKey(event, fit));
  canvas.addEventListener('pointerleave', ({ pointerType }) => pointerType === 'mouse' && nameCell(null));
  on(['crosshair', 'panes', 'measure'], point);
  return {
    /** @param {number} x @param {number} y */
    async pick(x, y) {
      const found = await seenAt(x, y);
      nameCell(found?.cell ?? null, found?.flag, 'polite');
      if (!found) return;
      moveTo(found.cell, { isPicked: true });
      picked(found.cell);
    },
    /** @param {number} x @param {number} y */
    async hover(x, y) {
      if (isLooking) return;
      isLooking = true;
      const found = await seenAt(x, y);
      isLooking = false;
      nameCell(found?.cell ?? null, found?.flag);
    },
  };
}

/** Draws the crosshair, and what is measured. */
function point() {
  const { mesh } = state;
  const isSeen = mesh && (crosshair.isPicked || areFour());
  withScene((scene) => scene.point(isSeen ? centreOf(mesh.lines, crosshair.cell) : null, measured()));
}

/** @param {KeyboardEvent} event @param {() => void} fit */
function takeKey(event, fit) {
  const step = event.shiftKey ? 0.02 : 0.1;
  /** @type {Record<string, [number, number, number?]>} */
  const turns = {
    ArrowLeft: [-step, 0],
    ArrowRight: [step, 0],
    ArrowUp: [0, step],
    ArrowDown: [0, -step],
    '+': [0, 0, 1.15],
    '=': [0, 0, 1.15],
    '-': [0, 0, 1 / 1.15],
  };
  if (event.key === 'Home') fit();
  else if (event.key === 'Enter' && state.mesh) {
    moveTo(crosshair.cell, { isPicked: true });
    picked(crosshair.cell);
  } else if (turns[event.key] && !event.ctrlKey && !event.metaKey) withScene((scene) => scene.turn(...turns[event.key]));
  else return;
  event.preventDefault();
}

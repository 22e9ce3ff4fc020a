/** The 3-D scene, which is opened when there is first something to draw. */
import { canvasOf } from '../elements/dom.js';
import { state } from '../state/state.js';
import { Scene } from './scene.js';

/** `scene` once it is open; whether it could not be opened. @type {{ scene: Scene | null, hasFailed: boolean }} */
export const held = { scene: null, hasFailed: false };
/** @type {Omit<import('./scene.js').Listener, 'failed'> & { failed: () => void } | null} */
let listener = null;

/** Who hears of the scene. @param {Omit<import('./scene.js').Listener, 'failed'> & { failed: () => void }} given */
export function listenToScene(given) {
  listener = given;
}

/**
 * Calls an action with the scene once there is anything to show.
 *
 * @param {(scene: Scene) => unknown} action
 */
export function withScene(action) {
  if (held.hasFailed || !listener || (!held.scene && state.geometries.length === 0 && !state.mesh)) return;
  try {
    held.scene ??= new Scene(canvasOf('canvas-3d'), { ...listener, failed });
    action(held.scene);
  } catch (error) {
    failed('transferControlToOffscreen' in HTMLCanvasElement.prototype ? String(error) : undefined);
  }
}

/** @param {string} [message] where it is not for want of WebGL */
function failed(message) {
  if (message) console.error(message);
  if (held.hasFailed) return;
  held.hasFailed = true;
  listener?.failed();
}

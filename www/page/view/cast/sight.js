/** What a picture is seen with: a sight, the size of the picture, and the light. */
import { directionsOf } from '../camera.js';
import { dot, minus, plus, times, unit } from '../vectors.js';

/**
 * @typedef {import('../camera.js').Sight} Sight
 * @typedef {ReturnType<typeof viewOf>} View
 */

/** How bright what no lamp shines on is, and what the lamp adds. */
export const AMBIENT = 0.53;
export const LAMP = 0.6;
/** A tone for each axis: steps stay readable where all faces get the same light. */
const TONES = [0.94, 0.84, 1];

/** @param {Sight} sight @param {number} width @param {number} height @param {number[]} jitter pixels by which the picture is moved */
export function viewOf(sight, width, height, jitter = [0, 0]) {
  const directions = directionsOf(sight);
  const { ahead, right, up } = directions;
  // over the right shoulder
  const lamp = unit(plus(plus(times(right, 0.3), times(up, 0.65)), times(ahead, -1)));
  const face = (/** @type {number} */ axis, /** @type {number} */ side) =>
    TONES[axis] * (AMBIENT + LAMP * Math.max(0, side * lamp[axis]));
  const light = { lamp, down: [0, 1, 2].map((axis) => face(axis, -1)), up: [0, 1, 2].map((axis) => face(axis, 1)) };
  return { sight, width, height, jitter, directions, light };
}

/** The least depth of a box that is before the eye, a small one where the eye is in it. @param {Sight} sight @param {number[]} low @param {number[]} high */
export function depthOf(sight, low, high) {
  const { ahead } = directionsOf(sight);
  const depths = Array.from({ length: 8 }, (_, corner) => {
    const at = low.map((_, axis) => ((corner >> axis) & 1 ? high : low)[axis] * sight.stretch[axis] - sight.centre[axis]);
    return dot(minus(at, sight.eye), ahead);
  });
  return Math.max(Math.min(...depths), sight.near);
}

/**
 * The matrix from lengths around the centre to the picture, by columns.
 *
 * @param {View} view
 */
export function matrixOf({ sight, directions: { ahead, right, up }, width, height, jitter }) {
  const { eye, near, far, tangent } = sight;
  const rows = [right, up, ahead].map((axis) => [...axis, -dot(axis, eye)]);
  const [x, y, z] = [times(rows[0], height / width / tangent), times(rows[1], 1 / tangent), rows[2]];
  // a picture that looks at a place beside a pixel is moved the other way
  const moved = [plus(x, times(z, (-2 * jitter[0]) / width)), plus(y, times(z, (-2 * jitter[1]) / height))];
  const depth = plus(times(z, (far + near) / (far - near)), [0, 0, 0, (-2 * far * near) / (far - near)]);
  return Float64Array.from({ length: 16 }, (_, at) => [moved[0], moved[1], depth, z][at % 4][Math.floor(at / 4)]);
}

/** The product of two matrices by columns. @param {ArrayLike<number>} a @param {ArrayLike<number>} b */
export function product(a, b) {
  const sum = (/** @type {number} */ row, /** @type {number} */ column) =>
    [0, 1, 2, 3].reduce((all, at) => all + a[row + 4 * at] * b[at + 4 * column], 0);
  return Float64Array.from({ length: 16 }, (_, at) => sum(at % 4, Math.floor(at / 4)));
}

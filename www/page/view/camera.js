/** Where the picture is seen from: a camera that turns around a target, with z up. */
import { cross, dot, minus, plus, times, unit } from './vectors.js';

/**
 * @typedef {[number, number, number]} Vector
 * @typedef {object} Sight what the drawing needs of a camera
 * @property {number[]} stretch times that each axis is drawn longer than it is: what follows is in lengths as they are drawn
 * @property {number[]} centre of what was fitted; the other places are relative to it, as world lengths may be far from zero
 * @property {number[]} eye
 * @property {number[]} target
 * @property {number} tangent of half the angle of the view's height
 * @property {number} near
 * @property {number} far
 */

/** Degrees of the view's height. */
const ANGLE = 35;
export const TANGENT = Math.tan((ANGLE * Math.PI) / 360);
/** The eye stays this far from straight above, in radians. */
const FROM_POLE = 1e-3;
/** How much of the view a box is fitted to. */
const FILLED = 0.94;

/** The directions ahead, to the right and upwards of a sight. @param {Pick<Sight, 'eye' | 'target'>} sight */
export function directionsOf({ eye, target }) {
  const ahead = unit(minus(target, eye));
  const right = unit(cross(ahead, [0, 0, 1]));
  return { ahead, right, up: cross(right, ahead) };
}

export class Camera {
  stretch = [1, 1, 1];
  centre = [0, 0, 0];
  target = [0, 0, 0];
  /** From the target to the eye. */
  offset = [1.1, -1.6, 0.9];
  /** Of the sphere around what was fitted. */
  radius = 1;
  #aspect = 1;
  /** What fills the view, until the camera is moved. @type {number[] | null} */
  #fitted = null;

  /** What is in view stays in view, also where the view becomes narrow. @param {number} aspect */
  setAspect(aspect) {
    const before = Math.min(1, this.#aspect);
    this.#aspect = aspect;
    if (this.#fitted) this.fit(this.#fitted, this.offset);
    else this.offset = times(this.offset, before / Math.min(1, aspect));
  }

  /** Where a place in world lengths is drawn. @param {number[]} place */
  drawn(place) {
    return place.map((at, axis) => at * this.stretch[axis]);
  }

  /** Puts the camera somewhere. @param {number[]} target @param {number[]} offset of the eye */
  put(target, offset) {
    this.#fitted = null;
    [this.target, this.offset] = [target, offset];
  }

  /** Target and offset, where somebody moved the camera: six numbers; null where it is fitted to a box. */
  place() {
    return this.#fitted ? null : [...plus(this.centre, this.target), ...this.offset];
  }

  /** @returns {Sight} */
  sight() {
    const { stretch, centre, target, offset } = this;
    const distance = Math.hypot(...offset);
    // what was fitted, and what lies around it
    const reach = distance + 4 * this.radius + Math.hypot(...target);
    return {
      stretch,
      centre,
      target,
      eye: plus(target, offset),
      tangent: TANGENT,
      near: Math.max(reach / 1e5, Math.min(reach / 4000, distance / 20)),
      far: 2 * reach,
    };
  }

  /**
   * Moves so that a box fills the view, seen along a direction.
   *
   * @param {number[]} corners six numbers
   * @param {number[]} direction from the target to the eye
   */
  fit(corners, direction) {
    this.#fitted = corners;
    const [low, high] = [this.drawn(corners.slice(0, 3)), this.drawn(corners.slice(3))];
    this.centre = times(plus(low, high), 0.5);
    this.target = [0, 0, 0];
    const half = times(minus(high, low), 0.5);
    this.radius = Math.max(Math.hypot(...half), Number.MIN_VALUE);
    this.offset = unit(direction);
    const { ahead, right, up } = directionsOf({ eye: this.offset, target: [0, 0, 0] });
    // the nearest eye from which no corner is beyond an edge of the view
    let distance = 0;
    for (let corner = 0; corner < 8; corner += 1) {
      const at = half.map((length, axis) => ((corner >> axis) & 1 ? length : -length));
      const beside = Math.max(Math.abs(dot(at, right)) / this.#aspect, Math.abs(dot(at, up))) / (TANGENT * FILLED);
      distance = Math.max(distance, beside - dot(at, ahead));
    }
    this.offset = times(this.offset, Math.max(distance, 1e-3 * this.radius, Number.MIN_VALUE));
  }

  /** Turns around z and upwards, in radians. @param {number} around @param {number} up */
  turn(around, up) {
    this.#fitted = null;
    const [x, y, z] = this.offset;
    const length = Math.hypot(x, y, z);
    const azimuth = Math.atan2(y, x) + around;
    const height = Math.min(Math.max(Math.asin(z / length) + up, FROM_POLE - Math.PI / 2), Math.PI / 2 - FROM_POLE);
    const across = length * Math.cos(height);
    this.offset = [across * Math.cos(azimuth), across * Math.sin(azimuth), length * Math.sin(height)];
  }

  /** Moves nearer by a factor, towards what is seen at a place from -1 to 1 each way. @param {number} factor */
  zoom(factor, [x, y] = [0, 0]) {
    const distance = Math.hypot(...this.offset);
    const next = Math.min(Math.max(distance / factor, 1e-5 * this.radius), 100 * this.radius);
    this.pan(x * (1 - next / distance), y * (1 - next / distance));
    this.offset = times(this.offset, next / distance);
  }

  /** Moves the target by shares of half the view. @param {number} x @param {number} y */
  pan(x, y) {
    this.#fitted = null;
    const { right, up } = directionsOf({ eye: this.offset, target: [0, 0, 0] });
    const half = TANGENT * Math.hypot(...this.offset);
    this.target = plus(this.target, plus(times(right, x * half * this.#aspect), times(up, y * half)));
  }
}

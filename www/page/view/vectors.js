/** Arithmetic of places and ways: lists of three numbers. */

/** @param {number[]} a @param {number[]} b */
export const minus = (a, b) => a.map((number, axis) => number - b[axis]);
/** @param {number[]} a @param {number[]} b */
export const plus = (a, b) => a.map((number, axis) => number + b[axis]);
/** @param {number[]} a @param {number} by */
export const times = (a, by) => a.map((number) => number * by);
/** @param {number[]} a @param {number[]} b */
export const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
/** @param {number[]} a @param {number[]} b */
export const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
/** @param {number[]} a */
export const unit = (a) => a.map((number) => number / (Math.hypot(...a) || 1));

/** How fast a mesher is: expected seconds, from the largest mesh that its backend has made. */

/** So many times as much work is the most that is expected: what a small mesh takes is not the work of its rays. */
const REACH = 100;

export class Pace {
  /** @type {string | null} */
  #backend = null;
  #rays = 0;
  #crossings = 0;
  #seconds = 0;

  /** Takes what a mesh took, unless there was a larger one. @param {import('../hexcast.js').Report} report */
  learn({ backend, rays, crossings, seconds }) {
    if (backend === this.#backend && rays + crossings < this.#rays + this.#crossings) return;
    this.#backend = backend;
    this.#rays = Math.max(rays, 1);
    this.#crossings = Math.max(crossings, 1);
    this.#seconds = seconds.columns ?? 0;
  }

  /** Seconds of a mesh; null where none was made that is large enough to tell. @param {{ rays: number, crossings: number }} estimate */
  secondsOf({ rays, crossings }) {
    const [byRays, byCrossings] = [rays / this.#rays, crossings / this.#crossings];
    if (!(byRays <= REACH && byCrossings <= REACH)) return null;
    // half the time for the rays, half for their crossings: good enough to distinguish seconds from minutes
    return (this.#seconds / 2) * (byRays + byCrossings);
  }
}

/**
 * The objects that the core holds for its callers, by number: a message can contain a number, but not the object.
 *
 * @template {{ free(): void }} T
 */
export class Held {
  /** @type {Map<number, T>} */
  #held = new Map();
  #next = 1;
  #isClosed = false;

  /** Holds a thing and returns its number. @param {T} thing */
  keep(thing) {
    const id = this.#next++;
    if (this.#isClosed) thing.free();
    else this.#held.set(id, thing);
    return id;
  }

  /** Frees all, and from now on whatever is to be held. */
  close() {
    this.#isClosed = true;
    for (const thing of this.#held.values()) thing.free();
    this.#held.clear();
  }

  /** @param {number | undefined} id */
  get(id) {
    const thing = id === undefined ? undefined : this.#held.get(id);
    if (thing === undefined) throw new Error(`nothing is held as number ${id}`);
    return thing;
  }

  /** Frees what has the number, if anything has. @param {number} [id] */
  release(id) {
    if (id === undefined) return;
    this.#held.get(id)?.free();
    this.#held.delete(id);
  }
}

/**
 * Frees what was needed for a result only.
 *
 * @template T
 * @param {{ free(): void }} thing
 * @param {() => T} make
 * @returns {T}
 */
export function freeAfter(thing, make) {
  try {
    return make();
  } finally {
    thing.free();
  }
}

/**
 * The objects that the core holds for its callers, by number: a message can contain a number, but not the object.
 *
 * @template {{ free(): void }} T
 */
export class Held {
  /** @type {Map<number, T>} */
  #held = new Map();
  #next = 1;

  /** Holds a thing and returns its number. @param {T} thing */
  keep(thing) {
    const id = this.#next++;
    this.#held.set(id, thing);
    return id;
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

// Binary STL in and out, and subdivision: always the longest edge, in all facets that share it, so that closed stays closed.
// The new corner is the middle of the edge, rounded to f32 once; facets keep their orientation.

import { readFileSync, writeFileSync } from 'node:fs';

/** @typedef {{ key: number, length: number }} Edge */

const HEADER_BYTES = 84;
const FACET_BYTES = 50;

/** Reads the corners of a binary STL file: 9 numbers a facet. @param {string} path */
export function readStl(path) {
  const bytes = readFileSync(path);
  const n_facets = bytes.readUInt32LE(80);
  if (bytes.length < HEADER_BYTES + FACET_BYTES * n_facets) throw new Error(`${path} is no whole binary STL file`);
  const corners = new Float32Array(9 * n_facets);
  for (let facet = 0; facet < n_facets; facet++) {
    for (let k = 0; k < 9; k++) corners[9 * facet + k] = bytes.readFloatLE(HEADER_BYTES + FACET_BYTES * facet + 12 + 4 * k);
  }
  return corners;
}

/** Writes corners as binary STL, normals zero. @param {string} path @param {Float32Array} corners */
export function writeStl(path, corners) {
  const n_facets = corners.length / 9;
  const bytes = Buffer.alloc(HEADER_BYTES + FACET_BYTES * n_facets);
  bytes.writeUInt32LE(n_facets, 80);
  for (let facet = 0; facet < n_facets; facet++) {
    for (let k = 0; k < 9; k++) bytes.writeFloatLE(corners[9 * facet + k], HEADER_BYTES + FACET_BYTES * facet + 12 + 4 * k);
  }
  writeFileSync(path, bytes);
}

/**
 * Splits longest edges until there are at least so many facets; returns all corners, 9 numbers a facet.
 *
 * @param {Float32Array} corners
 * @param {number} n_wanted
 */
export function subdivide(corners, n_wanted) {
  const mesh = new Edges(corners);
  while (mesh.facets.length < n_wanted && mesh.splitLongest());
  return mesh.corners();
}

/** Points by number, facets as three of them, and which facets have an edge; edges in a heap, longest first. */
class Edges {
  /** @type {number[][]} */
  facets = [];
  /** @type {number[][]} */
  #points = [];
  /** @type {Map<string, number>} */
  #ids = new Map();
  /** @type {Map<number, Set<number>>} */
  #facetsOf = new Map();
  /** @type {Edge[]} */
  #heap = [];

  /** @param {Float32Array} corners */
  constructor(corners) {
    for (let at = 0; at < corners.length; at += 9) {
      this.#add(
        [0, 3, 6].map((k) => this.#id(corners[at + k], corners[at + k + 1], corners[at + k + 2])),
        this.facets.length,
      );
    }
  }

  /** Splits the longest edge; returns whether there was one of any length. */
  splitLongest() {
    const { key, length } = pop(this.#heap);
    if (!(length > 0)) return false;
    const [a, b] = [Math.floor(key / 2 ** 26), key % 2 ** 26];
    const middle = this.#id(...this.#points[a].map((x, axis) => Math.fround((x + this.#points[b][axis]) / 2)));
    // an edge between neighbouring numbers has no middle: it stays as it is, and is not asked for again
    if (middle === a || middle === b) return this.#heap.length > 0;
    for (const facet of [...(this.#facetsOf.get(key) ?? [])]) {
      const old = this.facets[facet];
      this.#remove(old, facet);
      this.#add(
        old.map((id) => (id === a ? middle : id)),
        facet,
      );
      this.#add(
        old.map((id) => (id === b ? middle : id)),
        this.facets.length,
      );
    }
    return true;
  }

  corners() {
    const corners = new Float32Array(9 * this.facets.length);
    this.facets.forEach((facet, index) => facet.forEach((id, k) => corners.set(this.#points[id], 9 * index + 3 * k)));
    return corners;
  }

  /** @param {...number} point */
  #id(...point) {
    // 0 and -0 are the same point
    const key = point.map((x) => x + 0).join();
    let id = this.#ids.get(key);
    if (id === undefined) {
      id = this.#points.push(point) - 1;
      this.#ids.set(key, id);
    }
    return id;
  }

  /** @param {number[]} facet @param {number} index */
  #add(facet, index) {
    this.facets[index] = facet;
    for (const key of edgeKeys(facet)) {
      const sharing = this.#facetsOf.get(key);
      if (sharing) sharing.add(index);
      else {
        this.#facetsOf.set(key, new Set([index]));
        push(this.#heap, { key, length: this.#length(key) });
      }
    }
  }

  /** @param {number[]} facet @param {number} index */
  #remove(facet, index) {
    for (const key of edgeKeys(facet)) this.#facetsOf.get(key)?.delete(index);
  }

  /** @param {number} key */
  #length(key) {
    const [a, b] = [this.#points[Math.floor(key / 2 ** 26)], this.#points[key % 2 ** 26]];
    return Math.hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
  }
}

/**
 * The edges of a facet, each the same number in both directions; an edge from a point to itself is none.
 *
 * @param {number[]} facet
 */
function edgeKeys([a, b, c]) {
  const ends = [
    [a, b],
    [b, c],
    [c, a],
  ].filter(([from, to]) => from !== to);
  return new Set(ends.map(([from, to]) => Math.min(from, to) * 2 ** 26 + Math.max(from, to)));
}

/** @param {Edge[]} heap @param {Edge} edge */
function push(heap, edge) {
  let at = heap.push(edge) - 1;
  while (at > 0) {
    const parent = (at - 1) >> 1;
    if (heap[parent].length >= edge.length) break;
    heap[at] = heap[parent];
    at = parent;
  }
  heap[at] = edge;
}

/** @param {Edge[]} heap */
function pop(heap) {
  const top = heap[0] ?? { key: 0, length: 0 };
  const last = heap.pop();
  if (!last || heap.length === 0) return top;
  let at = 0;
  for (let child = 1; child < heap.length; child = 2 * at + 1) {
    if (child + 1 < heap.length && heap[child + 1].length > heap[child].length) child += 1;
    if (heap[child].length <= last.length) break;
    heap[at] = heap[child];
    at = child;
  }
  heap[at] = last;
  return top;
}

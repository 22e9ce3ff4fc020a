/** Surfaces as callers have them: bytes of a file, or corners of facets, in arrays of any kind and of any window. */
import { kindOf, wrongValue } from './check.js';
import { HexcastError } from '../protocol/error.js';

/** @typedef {import('../hexcast.js').SurfaceSource} Source */

const FILES = 'a Blob, an ArrayBuffer, a Uint8Array, a DataView';
const SOURCES = `${FILES}, a Float32Array or Float64Array of corners, {positions, index} or a Surface`;
const BYTES = ['Uint8Array', 'Uint8ClampedArray', 'Int8Array', 'DataView'];
const CORNERS = ['Float32Array', 'Float64Array'];

/** Whether it is a Blob, which need not be of this window. @param {unknown} value @returns {value is Blob} */
export function isBlob(value) {
  return ['Blob', 'File'].includes(kindOf(value)) && typeof (/** @type {Blob} */ (value).arrayBuffer) === 'function';
}

/** The name of a File. @param {unknown} source */
export function nameOf(source) {
  return isBlob(source) && kindOf(source) === 'File' ? /** @type {File} */ (source).name : undefined;
}

/**
 * The bytes of a file; null where it is none.
 *
 * @param {string} key
 * @param {unknown} source
 * @returns {Blob | Uint8Array | null}
 */
export function fileOf(key, source) {
  if (isBlob(source)) return source;
  const kind = kindOf(source);
  if (kind === 'ArrayBuffer' || kind === 'SharedArrayBuffer') return bytesOf(key, /** @type {ArrayBuffer} */ (source));
  if (!ArrayBuffer.isView(source) || !BYTES.includes(kind)) return null;
  return bytesOf(key, source.buffer, source.byteOffset, source.byteLength);
}

/**
 * The bytes of a column file.
 *
 * @param {string} key
 * @param {unknown} source
 */
export function columnBytes(key, source) {
  const file = fileOf(key, source);
  if (!file) throw wrongValue(key, source, FILES);
  return file;
}

/**
 * A surface as the core reads it: a file, or nine numbers a facet.
 *
 * @param {string} key
 * @param {unknown} source
 * @returns {Blob | Uint8Array | Float32Array}
 */
export function surfaceOf(key, source) {
  const file = fileOf(key, source);
  if (file) return file;
  if (ArrayBuffer.isView(source) && CORNERS.includes(kindOf(source))) return cornersOf(key, numbers(key, source));
  if (kindOf(source) === 'Object' && 'positions' in /** @type {object} */ (source)) {
    const { positions, index, ...others } = /** @type {Record<string, unknown>} */ (source);
    const [other] = Object.keys(others);
    if (other !== undefined) throw wrongValue(`${key}.${other}`, others[other], 'nothing: a surface is {positions, index}');
    const corners = numbers(`${key}.positions`, positions);
    if (index === undefined || index === null) return cornersOf(`${key}.positions`, corners);
    return indexed(key, corners, numbers(`${key}.index`, index));
  }
  throw wrongValue(key, source, SOURCES);
}

/**
 * A view of bytes of this window.
 *
 * @param {string} key
 * @param {ArrayBufferLike} buffer
 * @param {number} [start]
 * @param {number} [length]
 */
function bytesOf(key, buffer, start, length) {
  if (isDetached(buffer)) throw wrongValue(key, 'detached', 'bytes that were not transferred away');
  return alone(new Uint8Array(buffer, start, length));
}

/**
 * The same numbers, in a buffer that nobody else writes and that is no larger: a message to the worker contains all of it.
 *
 * @template {Uint8Array | Float32Array} T
 * @param {T} view
 * @returns {T}
 */
function alone(view) {
  const isPart = view.byteLength < view.buffer.byteLength;
  return isPart || kindOf(view.buffer) === 'SharedArrayBuffer' ? /** @type {T} */ (view.slice()) : view;
}

/** @param {ArrayBufferLike} buffer */
function isDetached(buffer) {
  try {
    new Uint8Array(buffer);
    return false;
  } catch {
    return true;
  }
}

/**
 * A list of numbers.
 *
 * @param {string} key
 * @param {unknown} list
 * @returns {ArrayLike<number>}
 */
function numbers(key, list) {
  const kind = kindOf(list);
  if (Array.isArray(list)) return list;
  if (!ArrayBuffer.isView(list) || kind === 'DataView' || kind.startsWith('Big'))
    throw wrongValue(key, list, 'a typed array or a list of numbers');
  if (isDetached(list.buffer)) throw wrongValue(key, 'detached', 'numbers that were not transferred away');
  return /** @type {ArrayLike<number>} */ (/** @type {unknown} */ (list));
}

/** @param {string} key @param {ArrayLike<number>} list */
function cornersOf(key, list) {
  const wrong = Array.isArray(list) ? list.findIndex((number) => typeof number !== 'number') : -1;
  if (wrong >= 0) throw wrongValue(`${key}[${wrong}]`, list[wrong], 'numbers');
  if (!ArrayBuffer.isView(list) || kindOf(list) !== 'Float32Array') return Float32Array.from(list);
  return alone(new Float32Array(list.buffer, list.byteOffset, list.length));
}

/**
 * Nine numbers a facet from vertices and indices.
 *
 * @param {string} key
 * @param {ArrayLike<number>} positions
 * @param {ArrayLike<number>} index
 */
function indexed(key, positions, index) {
  const vertices = cornersOf(`${key}.positions`, positions);
  const [n_vertices, rest] = [Math.floor(vertices.length / 3), vertices.length % 3];
  if (rest !== 0) throw count(`${key}.positions`, vertices.length, 'three numbers a vertex');
  if (index.length % 3 !== 0) throw count(`${key}.index`, index.length, 'three numbers a facet');
  const corners = new Float32Array(3 * index.length);
  for (let at = 0; at < index.length; at += 1) {
    const vertex = index[at];
    if (!Number.isInteger(vertex) || vertex < 0 || vertex >= n_vertices)
      throw wrongValue(`${key}.index[${at}]`, vertex, `whole numbers from 0 to ${n_vertices - 1}`);
    for (let axis = 0; axis < 3; axis += 1) corners[3 * at + axis] = vertices[3 * vertex + axis];
  }
  return corners;
}

/** @param {string} key @param {number} found @param {string} allowed */
function count(key, found, allowed) {
  return new HexcastError('job-value', `${key} has ${found} numbers; allowed: ${allowed}`, { details: { key, found, allowed } });
}

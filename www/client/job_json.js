/** A job as JSON. What JSON would drop or change in silence is refused by its key: NaN, infinity, BigInt, functions. */
import { kindOf, wrongValue } from './check.js';

/** Deeper values are no job; an object may contain itself. */
const DEEPEST = 8;

/** Writes plain data as JSON; keys without a value are left out. @param {unknown} value */
export function plainJson(value) {
  return JSON.stringify(plain('the job', '', value, 0));
}

/**
 * @param {string} key as in messages
 * @param {string} path to the keys within
 * @param {unknown} value
 * @param {number} depth
 * @returns {unknown}
 */
function plain(key, path, value, depth) {
  if (value === null || typeof value === 'string' || typeof value === 'boolean') return value;
  if (typeof value === 'number') {
    if (!Number.isFinite(value)) throw wrongValue(key, value, 'finite numbers');
    return value;
  }
  if (typeof value !== 'object' || depth === DEEPEST)
    throw wrongValue(key, value, 'numbers, text, true, false, lists and objects');
  const isNumbers = ArrayBuffer.isView(value) && kindOf(value) !== 'DataView';
  if (Array.isArray(value) || isNumbers) {
    const list = /** @type {ArrayLike<unknown>} */ (value);
    return Array.from(list, (entry, at) => plain(`${path}[${at}]`, `${path}[${at}]`, entry, depth + 1));
  }
  const entries = Object.entries(value).filter(([, entry]) => entry !== undefined);
  const within = (/** @type {string} */ name) => (path ? `${path}.${name}` : name);
  return Object.fromEntries(entries.map(([name, entry]) => [name, plain(within(name), within(name), entry, depth + 1)]));
}

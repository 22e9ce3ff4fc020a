/** What callers pass, checked before it is used: each problem is the error `job-value`, which names the key. */
import { HexcastError } from '../protocol/error.js';

/** Options of `createMesher`. */
export const MESHER = ['backend', 'threads', 'wasm', 'worker', 'device', 'signal'];
/** Options of every call that takes time. */
export const CALL = ['signal', 'onProgress'];

/**
 * The error of a wrong value.
 *
 * @param {string} key
 * @param {unknown} found
 * @param {string} allowed
 */
export function wrongValue(key, found, allowed) {
  const value = shown(found);
  return new HexcastError('job-value', `${key} is ${value}; allowed: ${allowed}`, { details: { key, found: value, allowed } });
}

/** A value in few words. @param {unknown} value */
function shown(value) {
  if (typeof value === 'string') return value.length > 60 ? `a text of ${value.length} letters` : JSON.stringify(value);
  if (typeof value === 'bigint') return `the BigInt ${value}`;
  if (typeof value === 'function') return 'a function';
  if (Array.isArray(value)) return `a list of ${value.length}`;
  return value !== null && typeof value === 'object' ? `an object (${kindOf(value)})` : String(value);
}

/** The name of a built-in class, also where the value comes from another window or test environment. @param {unknown} value */
export function kindOf(value) {
  return Object.prototype.toString.call(value).slice(8, -1);
}

/**
 * The options of a call; none by default.
 *
 * @template {object} T
 * @param {T | undefined} options
 * @param {readonly string[]} allowed their names
 * @returns {Partial<T>}
 */
export function optionsOf(options, allowed) {
  if (options === undefined) return {};
  if (options === null || typeof options !== 'object') throw wrongValue('the options', options, 'an object');
  const given = /** @type {Record<string, any>} */ (options);
  for (const key of Object.keys(given)) {
    if (given[key] === undefined || allowed.includes(key)) continue;
    throw new HexcastError('job-value', `${key} is no option of this call; allowed: ${allowed.join(', ')}`, {
      details: { key, allowed: allowed.join(', ') },
    });
  }
  const { signal, onProgress } = given;
  if (signal !== undefined && !(typeof signal?.aborted === 'boolean' && typeof signal.addEventListener === 'function'))
    throw wrongValue('signal', signal, 'an AbortSignal');
  if (onProgress !== undefined && typeof onProgress !== 'function') throw wrongValue('onProgress', onProgress, 'a function');
  return options;
}

/**
 * A value that must be one of some.
 *
 * @template T
 * @param {string} key
 * @param {T} value
 * @param {readonly T[]} allowed
 * @returns {T}
 */
export function oneOf(key, value, allowed) {
  if (!allowed.includes(value)) throw wrongValue(key, value, allowed.map((one) => JSON.stringify(one)).join(', '));
  return value;
}

/**
 * A whole number from `least` to `most`, both included.
 *
 * @param {string} key
 * @param {unknown} value
 * @param {number} least
 * @param {number} most
 */
export function wholeNumber(key, value, least, most) {
  if (Number.isInteger(value) && Number(value) >= least && Number(value) <= most) return Number(value);
  throw wrongValue(key, value, `whole numbers from ${least} to ${most}`);
}

/** Methods of a `GPUDevice` that this package calls. */
const METHODS = ['createBuffer', 'createShaderModule', 'createBindGroup', 'createCommandEncoder', 'pushErrorScope', 'destroy'];

/** @param {string} key @param {any} value @returns {GPUDevice} */
export function gpuDevice(key, value) {
  const isDevice =
    METHODS.every((name) => typeof value?.[name] === 'function') &&
    typeof value.queue?.submit === 'function' &&
    typeof value.lost?.then === 'function';
  if (!isDevice) throw wrongValue(key, value, 'a GPUDevice');
  return value;
}

/** @param {string} key @param {unknown} value */
export function yesOrNo(key, value) {
  if (typeof value !== 'boolean') throw wrongValue(key, value, 'true, false');
  return value;
}

/** @param {string} key @param {unknown} value */
export function text(key, value) {
  if (typeof value !== 'string') throw wrongValue(key, value, 'text');
  return value;
}

/**
 * Three whole numbers, from those of `least` to those of `most`.
 *
 * @param {string} key
 * @param {unknown} value
 * @param {readonly number[]} least
 * @param {readonly number[]} most
 * @returns {[number, number, number]}
 */
export function threeNumbers(key, value, least, most) {
  const numbers = Array.isArray(value) || ArrayBuffer.isView(value) ? /** @type {ArrayLike<unknown>} */ (value) : null;
  if (numbers?.length !== 3) throw wrongValue(key, value, 'three whole numbers');
  const [x, y, z] = most.map((end, axis) => wholeNumber(`${key}[${axis}]`, numbers[axis], least[axis], end));
  return [x, y, z];
}

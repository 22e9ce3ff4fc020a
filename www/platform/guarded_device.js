/**
 * A device that hears of its own errors only. The caller's device has errors of the caller's, and a handler for them: around every
 * call of ours the error scopes are ours. They are opened and closed without a wait, so that none of the caller's is closed instead.
 */
import { replaced } from './replaced_property.js';

const FILTERS = /** @type {const} */ (['validation', 'out-of-memory', 'internal']);
/** Methods that make no errors, or whose errors are about scopes. */
const PLAIN = ['pushErrorScope', 'popErrorScope', 'destroy', 'addEventListener', 'removeEventListener'];

/** @typedef {(event: { error: { message: string } }) => void} Handler */

/**
 * Calls a function within error scopes of its own.
 *
 * @template T
 * @param {GPUDevice} device
 * @param {() => T} act
 * @param {(errors: Promise<(GPUError | null)[]>) => void} hear receives what the scopes will have caught
 * @returns {T}
 */
export function scoped(device, act, hear) {
  for (const filter of FILTERS) device.pushErrorScope(filter);
  try {
    return act();
  } finally {
    // a lost device has no scopes, and tells of the loss itself
    hear(Promise.all(FILTERS.map(() => device.popErrorScope().catch(() => null))));
  }
}

/**
 * Wraps a device; what is set as its `onuncapturederror` receives the errors of calls to the wrapper, and of nothing else.
 *
 * @param {GPUDevice} device
 * @returns {GPUDevice}
 */
export function guarded(device) {
  /** @type {Handler | null} */
  let handler = null;
  const hear = (/** @type {GPUError | null} */ error) => {
    if (error && handler) tell(handler, `${error.constructor.name}: ${error.message}`);
  };
  /** @template T @param {() => T} act @returns {T} */
  const within = (act) => scoped(device, act, (errors) => errors.then((all) => all.forEach(hear)));
  const queue = wrap(device.queue, within, {});
  return wrap(device, within, { queue }, (name, value) => {
    if (name !== 'onuncapturederror') return false;
    handler = value;
    return true;
  });
}

/**
 * Calls the wasm's handler. It knows two kinds of errors by their global classes, which need not exist and are not all there are.
 *
 * @param {Handler} handler
 * @param {string} message
 */
function tell(handler, message) {
  const anyError = { [Symbol.hasInstance]: () => true };
  replaced(globalThis, 'GPUValidationError', anyError, () => handler({ error: { message } }));
}

/**
 * An object whose methods run within scopes, also those of the encoders and buffers that it makes.
 *
 * @template {object} T
 * @param {T} target
 * @param {<R>(act: () => R) => R} scoped
 * @param {Record<string, unknown>} others properties that take the place of its own
 * @param {(name: string, value: any) => boolean} [set] sets a property elsewhere
 * @returns {T}
 */
function wrap(target, scoped, others, set = () => false) {
  /** @type {Map<PropertyKey, unknown>} */
  const methods = new Map(Object.entries(others));
  return new Proxy(target, {
    get(_, name) {
      if (methods.has(name)) return methods.get(name);
      const value = Reflect.get(target, name);
      if (typeof value !== 'function') return value;
      const call = (/** @type {unknown[]} */ ...args) => value.apply(target, args.map(unshared));
      const method = PLAIN.includes(String(name))
        ? call
        : (/** @type {unknown[]} */ ...args) =>
            made(
              scoped(() => call(...args)),
              scoped,
            );
      methods.set(name, method);
      return method;
    },
    set(_, name, value) {
      return set(String(name), value) || Reflect.set(target, name, value);
    },
  });
}

/** An argument, of memory that threads share a copy: the package webgpu of Node reads no such memory, and ends the program. @param {unknown} value */
function unshared(value) {
  const isShared =
    value instanceof Uint8Array && typeof SharedArrayBuffer !== 'undefined' && value.buffer instanceof SharedArrayBuffer;
  return isShared ? value.slice() : value;
}

/**
 * What a method made: errors of encoders show when they finish, those of buffers when they are mapped.
 *
 * @param {any} thing
 * @param {<R>(act: () => R) => R} scoped
 */
function made(thing, scoped) {
  for (const name of ['finish', 'mapAsync']) {
    const method = thing?.[name];
    if (typeof method === 'function')
      Object.defineProperty(thing, name, {
        value: (/** @type {unknown[]} */ ...args) => scoped(() => method.apply(thing, args)),
      });
  }
  return thing;
}

/**
 * Calls a function while a property of an object has another value.
 *
 * @template T
 * @param {object} object
 * @param {string} name
 * @param {unknown} value
 * @param {() => T} act
 * @returns {T}
 */
export function replaced(object, name, value, act) {
  const before = Object.getOwnPropertyDescriptor(object, name);
  Object.defineProperty(object, name, { value, configurable: true, writable: true });
  try {
    return act();
  } finally {
    if (before) Object.defineProperty(object, name, before);
    else Reflect.deleteProperty(object, name);
  }
}

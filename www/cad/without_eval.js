/**
 * What takes the place of `Function` while Open CASCADE runs: its glue (embind of Emscripten) makes functions from text, which pages
 * with a Content Security Policy do not allow. It makes two kinds, told apart by the name of their first parameter; both are here as code.
 */

/**
 * @typedef {object} Type a type of the glue
 * @property {(destructors: unknown[], value: unknown) => unknown} toWireType
 * @property {(wired: unknown) => unknown} fromWireType
 * @property {(pointer: number) => unknown} readValueFromPointer
 * @property {number} argPackAdvance bytes that a value takes among arguments
 * @property {boolean} [isVoid]
 * @property {string} name
 */

/** As `new Function(...parameters, body)`, for the two kinds. @param {...string} text */
function fromText(...text) {
  const [first] = text;
  const body = text[text.length - 1];
  const n_types = text.filter((name) => /^argType\d+$/.test(name)).length;
  if (first === 'humanName') return exported(n_types, body.includes('var ret ='));
  if (first === 'retType') return called(n_types, body.includes('new func('));
  throw new EvalError(`Open CASCADE asks for a function of ${first}, and this page makes none of text`);
}

/** A function of C++ that JavaScript calls. @param {number} n_types @param {boolean} returns */
function exported(n_types, returns) {
  return (
    /** @type {string} */ _name,
    /** @type {unknown} */ _throw,
    /** @type {(fn: unknown, ...wired: unknown[]) => unknown} */ invoke,
    /** @type {unknown} */ fn,
    /** @type {(destructors: unknown[]) => void} */ runDestructors,
    /** @type {Type} */ result,
    /** @type {unknown} */ _class,
    /** @type {Type[]} */ ...types
  ) =>
    (/** @type {unknown[]} */ ...values) => {
      /** @type {unknown[]} */
      const destructors = [];
      const wired = types.slice(0, n_types).map((type, at) => type.toWireType(destructors, values[at]));
      const made = invoke(fn, ...wired);
      runDestructors(destructors);
      return returns ? result.fromWireType(made) : undefined;
    };
}

/** A function of JavaScript that C++ calls. @param {number} n_types @param {boolean} constructs */
function called(n_types, constructs) {
  return (/** @type {Type} */ result, /** @type {any[]} */ ...rest) => {
    /** @type {Type[]} */
    const types = rest.slice(0, n_types);
    const returned = rest[n_types];
    return (
      /** @type {unknown} */ object,
      /** @type {any} */ func,
      /** @type {unknown} */ destructors,
      /** @type {number} */ at,
    ) => {
      let offset = at;
      const values = types.map((type) => {
        const value = type.readValueFromPointer(offset);
        offset += type.argPackAdvance;
        return value;
      });
      const made = constructs ? new func(...values) : func.call(object, ...values);
      return result.isVoid ? undefined : returned(result, destructors, made);
    };
  };
}

/** Puts it in the place of `Function` on this thread, which runs nothing else. */
export function makeNoneOfText() {
  // functions stay instances of it
  Object.defineProperty(fromText, 'prototype', { value: Function.prototype });
  Object.defineProperty(globalThis, 'Function', { value: fromText, configurable: true, writable: true });
}

/** What callers ask of pictures and comparisons, checked, as the core takes it. */
import { kindOf, oneOf, optionsOf, text, threeNumbers, wholeNumber, wrongValue, yesOrNo } from './check.js';

const AXES = /** @type {const} */ (['x', 'y', 'z']);
const LOOK = ['size', 'flags', 'colours', 'max_memory', 'signal'];
/** Most pixels on a side of a picture. */
const MOST_PIXELS = 32_768;
/** Most bytes for a picture or a mask where the caller does not say. */
const DEFAULT_BYTES = 2 ** 30;

/** @typedef {import('../core/pictures.js').Look} Look @typedef {import('../core/pictures.js').Asked} Asked */

/** @param {import('../hexcast.js').SliceOptions} options @returns {Asked} */
export function slicesAsked(options) {
  const { axis = [], at = [], lines = true, ...look } = optionsOf(options, ['axis', 'at', 'lines', ...LOOK]);
  const axes = Uint8Array.from([axis].flat(), (one) => AXES.indexOf(oneOf('axis', one, AXES)));
  const slices = { axes, places: [at].flat().map(place).join(), hasLines: yesOrNo('lines', lines) };
  return { look: lookOf(look), slices };
}

/** A place as text; the core reads its number. @param {unknown} at */
function place(at) {
  const isText = typeof at === 'string' && at.trim() !== '' && !at.includes(',');
  if (!isText && !(typeof at === 'number' && Number.isFinite(at))) throw wrongValue('at', at, 'numbers, or texts such as "25%"');
  return String(at);
}

/** @param {readonly number[]} dims @param {import('../hexcast.js').ViewOptions} [options] @returns {Asked} */
export function viewAsked(dims, options) {
  const { direction, window, ...look } = optionsOf(options, ['direction', 'window', ...LOOK]);
  if (direction !== undefined && !(Array.isArray(direction) && direction.length === 2 && direction.every(Number.isFinite)))
    throw wrongValue('direction', direction, 'two angles in degrees');
  if (window !== undefined && !(Array.isArray(window) && window.length === 6))
    throw wrongValue('window', window, 'six whole numbers');
  const first = window && threeNumbers('the start of window', window.slice(0, 3), [0, 0, 0], dims);
  const end = first && threeNumbers('the end of window', window.slice(3), first, dims);
  const cells = first && end && Uint32Array.from([...first, ...end]);
  return { look: lookOf(look), view: { direction: direction && Float64Array.from(direction), cells } };
}

/** @param {import('../hexcast.js').LookOptions} options @returns {Look} */
function lookOf({ size, flags = [], colours = {}, max_memory }) {
  if (size !== undefined) wholeNumber('size', size, 1, MOST_PIXELS);
  if (!Array.isArray(flags)) throw wrongValue('flags', flags, 'a list of flags');
  if (kindOf(colours) !== 'Object') throw wrongValue('colours', colours, 'an object of colours by flag');
  return {
    size,
    flags: Uint8Array.from(flags, (flag, index) => wholeNumber(`flags[${index}]`, flag, 0, 255)),
    colours: Uint32Array.from(Object.entries(colours), ([flag, colour]) => coloured(flag, colour)),
    maxBytes: mostBytes(max_memory),
  };
}

/** A flag and its colour in one number. @param {string} flag @param {unknown} colour */
function coloured(flag, colour) {
  const of = wholeNumber('a flag of colours', /^\d+$/.test(flag) ? Number(flag) : flag, 0, 255);
  const key = `colours[${flag}]`;
  if (!/^#[0-9a-f]{6}$/i.test(text(key, colour))) throw wrongValue(key, colour, 'colours such as "#d98324"');
  return of * 2 ** 24 + Number.parseInt(String(colour).slice(1), 16);
}

/** Most bytes of memory. @param {number} [max_memory] */
export function mostBytes(max_memory = DEFAULT_BYTES) {
  return wholeNumber('max_memory', max_memory, 0, Number.MAX_SAFE_INTEGER);
}

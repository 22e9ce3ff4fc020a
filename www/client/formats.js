/** The formats of files, and the options that they are written with. */
import { FORMATS } from './format_rows.js';
import { CALL, kindOf, oneOf, optionsOf, wholeNumber, wrongValue, yesOrNo } from './check.js';

/** Every format, in the order of lists. */
export const formats = FORMATS;
const NAMES = /** @type {Format[]} */ (Object.keys(formats));
/** Options of what stands for a cell. */
const BYTES = ['bits', 'axisOrder', 'map'];
const WRITE = ['compress', 'ascii', 'exportFlags', 'onLack', ...BYTES, ...CALL];
const SIDECAR = ['hash', ...BYTES, ...CALL];

/** @typedef {import('../hexcast.js').Format} Format */

/**
 * The options of a file, with what they are by default: those of its bytes, `asked`, and those of the call.
 *
 * @param {Format} format
 * @param {import('../hexcast.js').WriteOptions} [options]
 */
export function written(format, options) {
  oneOf('format', format, NAMES);
  const {
    compress = formats[format].compresses ? 6 : 0,
    ascii = false,
    exportFlags,
    onLack,
    signal,
    onProgress,
    ...bytes
  } = optionsOf(options, WRITE);
  const asked = {
    compress: wholeNumber('compress', compress, 0, 9),
    ascii: yesOrNo('ascii', ascii),
    exportFlags: flagsOf(exportFlags),
    ...bytesOf(bytes),
  };
  if (onLack !== undefined && typeof onLack !== 'function') throw wrongValue('onLack', onLack, 'a function');
  return { asked, onLack, signal, onProgress };
}

/**
 * The options of the description of a raw file.
 *
 * @param {import('../hexcast.js').SidecarOptions} [options]
 */
export function described(options) {
  const { hash, signal, onProgress, ...bytes } = optionsOf(options, SIDECAR);
  if (hash !== undefined) oneOf('hash', hash, ['sha256']);
  return { hash, asked: bytesOf(bytes), call: { signal, onProgress } };
}

/** The options of what stands for a cell. @param {import('../hexcast.js').CellBytes} options */
function bytesOf({ bits = false, axisOrder = 'zyx', map }) {
  return { bits: yesOrNo('bits', bits), axisOrder: oneOf('axisOrder', axisOrder, ['zyx', 'xyz']), map: tableOf(map) };
}

/** Flags to export. @param {readonly number[] | undefined} flags */
function flagsOf(flags) {
  if (flags === undefined) return undefined;
  if (!Array.isArray(flags)) throw wrongValue('exportFlags', flags, 'a list of flags');
  return flags.map((flag, index) => wholeNumber(`exportFlags[${index}]`, flag, 0, 255));
}

/** What is written for each of the 256 flags. @param {Readonly<Record<number, number>> | undefined} map */
function tableOf(map) {
  if (map === undefined) return undefined;
  if (kindOf(map) !== 'Object') throw wrongValue('map', map, 'an object, such as { 1: 0, 0: 1 }');
  const table = Array.from({ length: 256 }, (_, flag) => flag);
  for (const [flag, byte] of Object.entries(map)) {
    const at = wholeNumber('a key of map', /^\d+$/.test(flag) ? Number(flag) : flag, 0, 255);
    table[at] = wholeNumber(`map[${flag}]`, byte, 0, 255);
  }
  return table;
}

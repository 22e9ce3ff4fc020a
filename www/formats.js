/** The formats of files, and the options that they are written with. */
import { CALL, oneOf, optionsOf, wholeNumber, wrongValue, yesOrNo } from './check.js';

const FORMATS = /** @type {const} */ ([
  ...['vti', 'vtr', 'npy', 'npz', 'raw', 'hxc', 'links.npz', 'fractions.npz', 'staggered.npz'],
  ...['foam', 'inp', 'msh', 'csx.xml', 'geometry.xml', 'nrrd', 'vox', 'binvox'],
]);
/** Formats of the native command only: the core refuses them, and says why. */
const NATIVE = ['xdmf', 'in'];
const WRITE = ['compress', 'bits', 'ascii', 'exportFlags', ...CALL];

/** Types of files that have one. @type {Partial<Record<Format, string>>} */
const MIME = {
  vti: 'application/vnd.vtk.vti+xml',
  vtr: 'application/vnd.vtk.vtr+xml',
  foam: 'application/zip',
  'csx.xml': 'application/xml',
  'geometry.xml': 'application/xml',
};

/** @typedef {import('./hexcast.js').Format} Format */

/** The type of a file. @param {Format} format */
export function mimeOf(format) {
  return MIME[format] ?? 'application/octet-stream';
}

/**
 * The options of a file, with what they are by default.
 *
 * @param {Format} format
 * @param {import('./hexcast.js').WriteOptions} [options]
 */
export function written(format, options) {
  if (!NATIVE.includes(format)) oneOf('format', format, FORMATS);
  const { compress = 0, bits = false, ascii = false, exportFlags, ...call } = optionsOf(options, WRITE);
  return {
    compress: wholeNumber('compress', compress, 0, 9),
    bits: yesOrNo('bits', bits),
    ascii: yesOrNo('ascii', ascii),
    exportFlags: flagsOf(exportFlags),
    ...call,
  };
}

/** Flags to export. @param {readonly number[] | undefined} flags */
function flagsOf(flags) {
  if (flags === undefined) return undefined;
  if (!Array.isArray(flags)) throw wrongValue('exportFlags', flags, 'a list of flags');
  return Uint8Array.from(flags, (flag, index) => wholeNumber(`exportFlags[${index}]`, flag, 0, 255));
}

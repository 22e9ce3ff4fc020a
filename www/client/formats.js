/** The formats of files, and the options that they are written with. */
import { CALL, kindOf, oneOf, optionsOf, wholeNumber, wrongValue, yesOrNo } from './check.js';

/**
 * A format: a file of the mesh that can be compressed and holds every mesh, unless it says otherwise.
 *
 * @param {Partial<import('../hexcast.js').FormatFacts>} [facts]
 * @returns {import('../hexcast.js').FormatFacts}
 */
const row = (facts) =>
  Object.freeze({
    kind: 'cells',
    type: 'application/octet-stream',
    compresses: true,
    ascii: false,
    unit: false,
    spacing: 'any',
    ...facts,
  });
const [VTI, VTR] = ['application/vnd.vtk.vti+xml', 'application/vnd.vtk.vtr+xml'];
const [ZIP, XML] = ['application/zip', 'application/xml'];
const MEASURED = /** @type {const} */ ({ kind: 'measured' });
const EXPORT = /** @type {const} */ ({ kind: 'export' });
const PLAIN = { compresses: false };
const EQUAL = /** @type {const} */ ({ spacing: 'equal' });

/** Every format, in the order of lists. */
export const formats = /** @type {typeof import('../hexcast.js').formats} */ (
  Object.freeze({
    vti: row({ type: VTI, ...EQUAL }),
    vtr: row({ type: VTR }),
    npy: row(PLAIN),
    npz: row(),
    raw: row(PLAIN),
    hxc: row(),
    zarr: row({ type: ZIP }),
    'links.npz': row(MEASURED),
    'links.h5': row({ ...MEASURED, type: 'application/x-hdf5' }),
    links: row({ ...MEASURED, ...PLAIN }),
    'staggered.npz': row(MEASURED),
    'fractions.npz': row(MEASURED),
    'fractions.vti': row({ ...MEASURED, ...EQUAL, type: VTI }),
    'fractions.vtr': row({ ...MEASURED, type: VTR }),
    'fractions.npy': row({ ...MEASURED, ...PLAIN }),
    'fractions.zarr': row({ ...MEASURED, type: ZIP }),
    foam: row({ ...EXPORT, type: ZIP, ascii: true, unit: true }),
    inp: row({ ...EXPORT, ...PLAIN, unit: true }),
    msh: row({ ...EXPORT, ...PLAIN, ascii: true }),
    xdmf: row({ ...EXPORT, type: ZIP }),
    'csx.xml': row({ ...EXPORT, ...PLAIN, type: XML, unit: true }),
    in: row({ ...EXPORT, ...EQUAL, type: ZIP, unit: true }),
    'geometry.xml': row({ ...EXPORT, ...EQUAL, ...PLAIN, type: XML, unit: true }),
    nrrd: row({ ...EXPORT, ...EQUAL }),
    vox: row({ ...EXPORT, ...EQUAL, ...PLAIN }),
    binvox: row({ ...EXPORT, ...PLAIN, spacing: 'cubes' }),
  })
);
const NAMES = /** @type {Format[]} */ (Object.keys(formats));
/** Options of what stands for a cell. */
const BYTES = ['bits', 'axisOrder', 'map'];
const WRITE = ['compress', 'ascii', 'exportFlags', ...BYTES, ...CALL];
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
  return { asked, signal, onProgress };
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

/**
 * Files of CAD (STEP, IGES) -> a 3MF file of triangles, with names, colours and the unit. Open CASCADE does it (occt-import-js), in a
 * thread that is ended to cancel.
 */
import { oneOf, optionsOf, text, wholeNumber, wrongValue } from '../client/check.js';
import { fileOf, nameOf } from '../client/source.js';
import { HexcastError } from '../protocol/error.js';
import { SHARE } from './convert.js';
import { UNITS } from './three_mf.js';

/**
 * @typedef {import('../cad.js').CadOptions} CadOptions
 * @typedef {import('../cad.js').Cad} Cad
 * @typedef {Omit<import('./convert.js').Request, 'wasm'>} Asked
 * @typedef {{ made?: import('./convert.js').Converted, failure?: string }} Answer
 * @typedef {(asked: Asked, answer: (answer: Answer) => void) => (() => void)} Start starts a thread; returns what ends it
 */

const OPTIONS = ['deviation', 'cells', 'unit', 'file', 'signal'];
/** Bytes of a file from which on memory may not suffice: Open CASCADE can address 2 GiB here. */
export const MUCH = 100e6;
const MOST_CELLS = 1 << 21;

/** @param {Start} start @param {Parameters<typeof import('../cad.js').readCad>[0]} source @param {CadOptions} [options] @returns {Promise<Cad>} */
export async function readBy(start, source, options) {
  const { deviation = 0, cells = 256, unit = 'mm', file, signal } = optionsOf(options, OPTIONS);
  if (options?.deviation !== undefined && !(deviation > 0 && deviation < Infinity))
    throw wrongValue('deviation', deviation, 'a length above 0');
  wholeNumber('cells', cells, 1, MOST_CELLS);
  oneOf('unit', unit, Object.keys(UNITS));
  const given = fileOf('source', source);
  if (!given) throw wrongValue('source', source, 'a Blob, an ArrayBuffer, a Uint8Array, a DataView');
  const name = file === undefined ? (nameOf(source) ?? 'the file') : text('file', file);
  signal?.throwIfAborted();
  const since = performance.now();
  const bytes = await bytesOf(given, name);
  const kind = kindOfCad(bytes);
  if (!kind) {
    const hint = 'give it to mesher.read, or export the model as STEP (.step, .stp) or IGES (.iges, .igs)';
    throw new HexcastError('stl-not-stl', `${name} is neither STEP nor IGES by its first line`, { hint });
  }
  const made = await converted(
    start,
    { bytes, kind, unit, deviation, cells },
    { name, size: given instanceof Blob ? given.size : given.length, signal },
  );
  const edges = [0, 1, 2].map((axis) => made.box[3 + axis] - made.box[axis]);
  return {
    surface: made.surface,
    bodies: made.bodies,
    kind,
    unit,
    deviation: deviation || (SHARE * Math.max(...edges)) / cells,
    bounds: /** @type {Cad['bounds']} */ (made.box),
    seconds: (performance.now() - since) / 1000,
  };
}

/** The bytes of the file, unpacked where gzip packed it. @param {Blob | Uint8Array} given @param {string} name */
async function bytesOf(given, name) {
  const bytes = given instanceof Uint8Array ? given : new Uint8Array(await given.arrayBuffer());
  if (bytes[0] !== 0x1f || bytes[1] !== 0x8b) return bytes;
  try {
    const blob = new Blob([/** @type {Uint8Array<ArrayBuffer>} */ (bytes)]);
    return new Uint8Array(await new Response(blob.stream().pipeThrough(new DecompressionStream('gzip'))).arrayBuffer());
  } catch (cause) {
    throw new HexcastError('file-syntax', `${name} cannot be unpacked by gzip`, { hint: 'copy or pack it again', cause });
  }
}

/**
 * What a file is by its first line: STEP begins with `ISO-10303-21;`, and lines of IGES have a letter and a number at column 73.
 *
 * @param {Uint8Array} bytes
 * @returns {'step' | 'iges' | null}
 */
export function kindOfCad(bytes) {
  const head = String.fromCharCode(...bytes.subarray(0, 400)).replace(/^\u00ef\u00bb\u00bf/, '');
  if (/^\s*ISO-10303-21\s*;/.test(head)) return 'step';
  return /^[^\r\n]{72}[SC] {0,6}0*1\s/.test(head) ? 'iges' : null;
}

/**
 * Waits for a thread, which a signal ends.
 *
 * @param {Start} start
 * @param {Asked} asked
 * @param {{ name: string, size: number, signal?: AbortSignal }} of
 */
async function converted(start, asked, { name, size, signal }) {
  signal?.throwIfAborted();
  let stop = () => {};
  try {
    const { made, failure } = await new Promise((resolve, reject) => {
      signal?.addEventListener('abort', () => reject(signal.reason), { once: true });
      /** @type {(answer: Answer) => void} */
      const answer = resolve;
      stop = start(asked, answer);
    });
    if (failure !== undefined) throw broken(name, size, failure);
    if (!made.isRead) {
      const hint = 'open it in the program of CAD and export it again, as STEP AP214 or AP242, or as STL';
      throw new HexcastError('file-syntax', `${name}: Open CASCADE cannot read this ${asked.kind.toUpperCase()} file`, { hint });
    }
    if (made.bodies.length === 0) {
      const hint = 'export the bodies themselves, and not references to files; drawings and wires have no surface';
      throw new HexcastError('stl-empty', `${name} has no surface`, { hint });
    }
    return made;
  } finally {
    stop();
  }
}

/** @param {string} name @param {number} size @param {string} failure */
function broken(name, size, failure) {
  const megabytes = (size / 1e6).toFixed(1);
  if (/memory|Aborted\(OOM|allocat/i.test(failure) || size > MUCH) {
    const message = `${name} has ${megabytes} MB, for which the 2 GiB that Open CASCADE can address here do not suffice: ${failure}`;
    return new HexcastError('memory', message, { hint: 'export it in parts, or as STL', details: { bytes: size } });
  }
  const hint = 'export it again, or as STL; if other programs open it, please report this with the file';
  return new HexcastError('file-syntax', `${name}: Open CASCADE failed: ${failure}`, { hint });
}

/**
 * Files of CAD: STEP and IGES become a 3MF file of triangles, which every reader of hexcast takes, with a name a body and the unit.
 *
 * ```js
 * import { createMesher } from 'hexcast';
 * import { readCad } from 'hexcast/cad';
 *
 * const { surface, bodies, deviation } = await readCad(file, { cells: 256 });
 * const mesher = await createMesher();
 * const mesh = await mesher.mesh({ geometries: [{ source: surface, file: file.name, split: true }], cells: 256 });
 * ```
 *
 * With `split` each body is a geometry, with its name and the next flag. Open CASCADE makes the triangles, as built by the npm package
 * occt-import-js: 7.6 MB of wasm under the LGPL 2.1, in files of their own, which are loaded by the first call. It runs in a worker (in Node a
 * thread), which is ended when the call ends or is aborted.
 */

/** Units of a file that is made: those of 3MF that programs of CAD know, too. */
export type CadUnit = 'mm' | 'cm' | 'm' | 'in' | 'ft';

export interface CadOptions {
  /**
   * Largest distance of the triangles from the surfaces, in `unit`; by default a tenth of a cell of `cells`. Triangles also turn by no
   * more than 0.5 radians from one to the next, so that small rounds keep their form.
   */
  readonly deviation?: number;
  /** Cells along the longest axis, from which the deviation follows; 256 by default. */
  readonly cells?: number;
  /** Unit of the result, whatever that of the file is; `mm` by default. Lengths are converted. */
  readonly unit?: CadUnit;
  /** Name of the file in errors; by default that of a File. */
  readonly file?: string;
  /** Ends the thread at once; the call rejects with its reason. */
  readonly signal?: AbortSignal;
}

/** A body of a file: a solid, or surfaces that are no solid. */
export interface CadBody {
  /** The names of its assemblies and its own, separated by slashes, such as `pump/rotor/blade 2`; each body has another. */
  readonly name: string;
  /** Its colour as #rrggbb, if it has one and only one. */
  readonly colour: string | null;
  /** Number of its triangles. */
  readonly facets: number;
}

/** What a file of CAD became. */
export interface Cad {
  /** A 3MF file, with a solid a body in the order of `bodies`: the source of a geometry. */
  readonly surface: Blob;
  readonly bodies: readonly CadBody[];
  readonly kind: 'step' | 'iges';
  readonly unit: CadUnit;
  /** Largest distance of the triangles from the surfaces that was asked for, in `unit`. */
  readonly deviation: number;
  /** The box around all bodies, the least coordinates first, in `unit`. */
  readonly bounds: readonly [number, number, number, number, number, number];
  /** Seconds that it took. */
  readonly seconds: number;
}

/**
 * Bytes of a file from which on memory may not suffice: Open CASCADE can address 2 GiB in wasm. Larger files are tried all the same.
 */
export const largeBytes: number;

/**
 * What a file is by its first 400 bytes or more; null where it is neither STEP nor IGES. It is not unpacked.
 */
export function kindOfCad(bytes: Uint8Array): 'step' | 'iges' | null;

/**
 * Reads a STEP or IGES file, also one that is packed by gzip, and makes triangles of its bodies.
 *
 * Rejects with a `HexcastError`: `stl-not-stl` where it is neither; `file-syntax` where Open CASCADE cannot read it; `stl-empty` where it
 * has no surface; `memory` where it is too large; `job-value` where an option is wrong. Bodies that are not closed are found when the
 * result is read or meshed, by their names.
 */
export function readCad(source: Blob | ArrayBuffer | ArrayBufferView, options?: CadOptions): Promise<Cad>;

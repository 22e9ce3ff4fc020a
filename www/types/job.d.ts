/** What goes in besides the job: surfaces; and what a job would cost. */
import type { CallOptions } from '../hexcast.js';
import type { Grading } from './report.js';
import type { Float32Numbers } from './result.js';

/** The bytes of a file (STL, OBJ, PLY, OFF, 3MF or GLB, also packed by gzip), or facets. A Blob is read in slices, never as a whole. */
export type SurfaceSource =
  | FileSource
  /** Corners of facets: 9 numbers a facet (x y z of three corners), in the unit of the job. Rounded to f32, as STL files are. */
  | Float32Array
  | Float64Array
  | FacetsSource;

/** The same, or a surface that this mesher has read before with `Mesher.read`. */
export type GeometrySource = SurfaceSource | Surface<FileInfo>;

/** The bytes of a file. Shared memory is copied before the call returns. */
export type FileSource = Blob | ArrayBufferLike | Uint8Array | Uint8ClampedArray | Int8Array | DataView;

/** Facets by vertices, as three.js and others have them. */
export interface FacetsSource {
  /** Three numbers a vertex, rounded to f32; without `index` nine a facet. */
  readonly positions: Numbers;
  /** Three vertices a facet, counted from 0. */
  readonly index?: Numbers | null;
}

/** Numbers in an array of any kind. */
export type Numbers =
  | readonly number[]
  | Int8Array
  | Uint8Array
  | Uint8ClampedArray
  | Int16Array
  | Uint16Array
  | Int32Array
  | Uint32Array
  | Float32Array
  | Float64Array;

/** Facts of a surface that was read, before its edges are looked at. */
export interface FileInfo {
  /** Name of the file. */
  file: string;
  /** `STL, binary`, `STL, ASCII`, `OBJ`, `OFF`, `PLY, ASCII`, `PLY, binary`, `3MF`, `GLB`, or `facets` where the job has arrays. */
  format: string;
  /** The unit of its coordinates: that of a 3MF, `"m"` for GLB; null where the file does not say. */
  unit: 'um' | 'mm' | 'cm' | 'm' | 'in' | 'ft' | null;
  /** Length of the file in bytes. */
  bytes: number;
  /** BLAKE3 of its bytes, in hexadecimal; null for arrays, which are not hashed. */
  blake3: string | null;
  /** Names of its solids, empty strings where the file gives none. */
  solids: string[];
  facets: number;
  /** Least and greatest coordinates, in the file's own unit. */
  bounding_box: [[number, number, number], [number, number, number]];
  /** Signed volume enclosed; depends on the reference point where the surface is open. */
  volume: number;
  /** Defects of the file that the reader accepted. */
  warnings: string[];
}

/** Facts of a surface that was read and whose edges were looked at. */
export interface SurfaceInfo extends FileInfo {
  /** Number of solids that are closed by themselves: every edge is used an even number of times. */
  closed_solids: number;
  area: number;
  /** Every edge is used equally often both ways: rule `nonzero` is well defined. */
  closed_oriented: boolean;
  /** Every edge is used an even number of times: rule `parity` is well defined. */
  closed_parity: boolean;
  /** Edges used once. */
  open_edges: number;
  nonmanifold_edges: number;
  flipped_edges: number;
  shells: number;
}

/** A surface held by the mesher's worker, ready to be meshed many times. */
export interface Surface<Info extends FileInfo = SurfaceInfo> extends Disposable {
  /** Facts: those of the file, and what `check` has found. */
  readonly info: Info;
  /**
   * Checks the edges, unless that was done before, and resolves to this surface, whose `info` then is complete. Progress is a fraction
   * of 1. Meshing does not need this check, and a mesh that is asked for meanwhile goes first.
   */
  check(options?: CallOptions): Promise<Surface>;
  /**
   * Corners of at most `maxFacets` facets, 1 to 2^32 - 1, 9 numbers per facet, for drawing. If the surface has more facets, it is
   * simplified: corners near each other become one. Progress is a fraction of 1, which may begin again.
   */
  preview(maxFacets: number, options?: CallOptions): Promise<Float32Numbers>;
  /** Corners of all facets, 9 numbers per facet, for drawing. A copy. */
  corners(): Promise<Float32Numbers>;
  /** Frees it in the worker. */
  dispose(): void;
}

/** What a mesh would cost. Numbers of cells and rays are exact, the others expected. */
export interface Estimate {
  dims: [number, number, number];
  origin: [number, number, number];
  /** Null where cells differ in size. */
  spacing: [number, number, number] | null;
  /** The lines and how their distances change; null where all cells are equal. */
  grading: Grading | null;
  cells: number;
  /** Axis of the rays; what `auto` comes to. */
  ray_axis: 'x' | 'y' | 'z';
  rays: number;
  /** Facets of all geometries. */
  facets: number;
  /** Expected number of crossings of rays and facets. */
  crossings: number;
  /** Expected bytes of the columns in memory. */
  column_bytes: number;
  /** Expected bytes of memory for meshing and writing. */
  host_bytes: number;
  /** The parts of `host_bytes`. */
  host: Record<string, number>;
  /** Upper limit of the bytes of GPU buffers, as expected. */
  device_bytes: number;
  /** Bytes of the files. Exact for raw and npy, close for vti (vtr, where cells differ in size) and hxc, up to several times too large for `_zlib`. `_bits`: one bit per cell. */
  file_bytes: Record<'raw' | 'raw_bits' | 'npy' | 'npy_bits' | 'vti' | 'vti_zlib' | 'hxc' | 'hxc_zlib', number>;
  /** Expected seconds, from the largest mesh that this mesher has made; null before the first, and for a hundred times as much work. */
  seconds: number | null;
}

/// <reference lib="esnext.disposable" />

/**
 * hexcast: exact Cartesian meshing of closed surfaces, on the browser's GPU or its processor.
 *
 * ```js
 * import { createMesher } from 'hexcast';
 *
 * const mesher = await createMesher();
 * const mesh = await mesher.mesh({ geometries: [{ source: file, flag: 1 }], cells: 256 });
 * console.log(mesh.dims, mesh.report.flags);
 * for await (const slab of mesh.slabs()) consume(slab.flags);   // u8, x fastest
 * const vti = await mesh.blob('vti');
 * mesher.dispose();
 * ```
 *
 * The work happens in a dedicated worker; with `worker: false`, with a `device` and in Node on the calling thread. Inputs are never detached or changed; every typed array that comes back belongs
 * to the caller. Lengths are in the unit of the files, cells are counted from 0, ends of ranges are exclusive, and
 * the flags of a box lie with x fastest: `flags[x + nx * (y + ny * z)]`.
 */

/** Stable codes of {@link HexcastError}; the same as those of the native library. */
export type ErrorCode =
  | 'cancelled'
  | 'stl-empty'
  | 'stl-truncated'
  | 'stl-count'
  | 'stl-not-stl'
  | 'stl-syntax'
  | 'stl-not-finite'
  /** A geometry is not closed, and its `open` is `error`. */
  | 'surface-open'
  | 'columns-corrupt'
  | 'columns-version'
  | 'job-syntax'
  | 'job-value'
  | 'job-conflict'
  | 'job-empty'
  | 'domain-empty'
  | 'lines-no-common-size'
  | 'too-many-cells'
  | 'geometry-too-far'
  | 'too-many-facets'
  | 'too-many-geometries'
  | 'too-many-crossings'
  | 'memory'
  | 'no-adapter'
  | 'device-failed'
  /** The GPU driver computes wrongly, and what it returned was thrown away. */
  | 'device-wrong'
  | 'device-lost'
  | 'io';

/** Every failure but an abort, which rejects with `signal.reason`. */
export class HexcastError extends Error {
  /** What went wrong, for programs. */
  readonly code: ErrorCode;
  /** What to do about it, for people; may be empty. */
  readonly hint: string;
}

/**
 * Who meshes: with `auto` the GPU where there is one, otherwise the CPU, which is faster than an adapter that computes on the
 * processor; or one of them alone.
 */
export type BackendChoice = 'auto' | 'gpu' | 'cpu';

/** Where a wasm module is, or its bytes, or the compiled module. */
export type WasmSource = string | URL | ArrayBuffer | Uint8Array | WebAssembly.Module;

export interface MesherOptions {
  /** Default `auto`. With `gpu`, a missing adapter is the error `no-adapter`, and one lost for good `device-lost`. */
  backend?: BackendChoice;
  /** The wasm; by default `hexcast_bg.wasm` beside this script. */
  wasm?: WasmSource;
  /** Where the worker script is (another origin is fine), or `false` to work on the calling thread. */
  worker?: string | URL | false;
  /**
   * A `GPUDevice` of your own to mesh on, on the calling thread: devices cannot leave theirs, so that no worker is started.
   * It is never destroyed here; its `onuncapturederror` is taken. Where it is lost meanwhile, also by `device.destroy()`,
   * the mesher opens one of its own or, with `auto`, falls back to the CPU, and goes on with the band at which it stopped, with
   * the same result.
   */
  device?: Device;
  /** Stops the start. */
  signal?: AbortSignal;
}

/** What is looked at of a `GPUDevice`; said so that these types need no others. */
export interface Device {
  readonly features: object;
  readonly limits: object;
  readonly queue: object;
  readonly lost: Promise<unknown>;
  destroy(): void;
}

/** Bytes of a file: STL, binary or ASCII. Blobs are read in slices, never as a whole. */
export type GeometrySource =
  | Blob
  | ArrayBuffer
  | Uint8Array
  /** Corners of facets: 9 numbers a facet (x y z of three corners), in the unit of the job. */
  | Float32Array
  /** A surface that this mesher has read before with {@link Mesher.read}. */
  | Surface;

export interface GeometryJob {
  /** The facets. */
  source: GeometrySource;
  /** Name of the file in reports; by default that of the File, or `geometry-1`, ... */
  file?: string;
  /** Takes only the solid of this name from an ASCII file of several. */
  solid?: string;
  /** Makes every solid of the file a geometry of its own. */
  split?: boolean;
  /** Name in reports and outputs; by default the file's without its extension. */
  name?: string;
  /** Property flag of its cells, 1 to 255; by default 1, 2, ... in order. */
  flag?: number;
  /** Where geometries overlap the higher priority wins, at equal priority the later. Default 0. */
  priority?: number;
  /** How cells are decided where its surface is not closed; by default as the job says. */
  open?: Job['open'];
  /** Scales first; one factor or one an axis. */
  scale?: number | [number, number, number];
  /** Then rotates about x, y and z, in degrees. */
  rotate?: [number, number, number];
  /** Then moves. */
  translate?: [number, number, number];
}

/** What is meshed and how: the native job file, with sources in place of file names. */
export interface Job {
  /** In meshing order. */
  geometries: GeometryJob[];
  /** Two corners of the box, x0 y0 z0 x1 y1 z1; by default the box around all geometries. */
  domain?: [number, number, number, number, number, number];
  /** Room around the box of the geometries, in whole cells or by a length. */
  padding?: { cells: number | [number, number, number] } | { length: number | [number, number, number] };
  /** Cubic cells, so many along the longest axis; the default is 128. At most one of these four is given. */
  cells?: number;
  /** Exactly so many cells on x, y, z. */
  dims?: [number, number, number];
  /** Cell size, one or one an axis. */
  cell_size?: number | [number, number, number];
  /** The largest size an axis, at most this, that puts the ends of all bounding boxes on mesh lines. */
  max_cell_size?: number;
  /** How far from a line, in cells, `max_cell_size` lets an end lie: 0 to 0.5, default 0.05. */
  tolerance?: number;
  /** Inside is an odd number of crossings, or a winding number other than zero. Default `parity`. */
  rule?: 'parity' | 'nonzero';
  /**
   * How cells are decided where a surface is not closed. `winding`: by the rays of three axes where they are even and agree, elsewhere
   * by the generalised winding number; `vote`: by most of the axes whose rays are even, for surfaces that cannot be oriented;
   * `error`: not at all, the mesh fails with `surface-open`; `parity`: by the rays of one axis, up to the last matched pair of
   * crossings. Closed surfaces are not affected. Default `winding`.
   */
  open?: 'winding' | 'vote' | 'error' | 'parity';
  /** Axis of the rays; the result does not depend on it. Default `auto`: the longest, the first of those less than an eighth shorter. */
  axis?: 'auto' | 'x' | 'y' | 'z';
  /**
   * Most memory to take, in bytes or as text such as `2GB`; by default 3 GiB. A mesh that needs more fails with `memory`, but
   * for columns that {@link MeshOptions.spill}.
   */
  max_memory?: number | string;
  /** Unit of the files' lengths, such as `mm`; repeated in every output. */
  unit?: string;
}

/** How far a call has come. */
export interface Progress {
  /** `read`: bytes of files; `mesh`: rays; `write`: bytes of flags. */
  stage: 'read' | 'mesh' | 'write';
  /** Done so far, in the stage's unit. */
  done: number;
  /** Of so many. */
  total: number;
}

export interface CallOptions {
  /**
   * Gives the call up: it rejects with `signal.reason` at once, and the mesher stays usable. The work itself stops within
   * half a second; what is called next waits for that.
   */
  signal?: AbortSignal;
  /** Called from time to time, at most once a band. */
  onProgress?: (progress: Progress) => void;
}

export interface MeshOptions extends CallOptions {
  /**
   * Whether columns that outgrow `max_memory` go to a temporary file in the browser's private file system (OPFS), as the
   * command's `--spill` does it; the result is the same, and the file goes with the mesh. Default `auto`: where there is such
   * a file system, which is in workers of secure pages and not in Node. With `true` its absence is the error `io`.
   */
  spill?: 'auto' | boolean;
}

/** Facts of a surface that was read. */
export interface SurfaceInfo {
  /** Name of the file. */
  file: string;
  /** `STL, binary` or `STL, ASCII`. */
  format: string;
  /** Length of the file in bytes. */
  bytes: number;
  /** SHA-256 of its bytes, in hexadecimal. */
  sha256: string;
  /** Names of its solids, empty strings where the file gives none. */
  solids: string[];
  facets: number;
  /** Least and greatest coordinates, in the file's own unit. */
  bounding_box: [[number, number, number], [number, number, number]];
  /** Signed volume enclosed; depends on the reference point where the surface is open. */
  volume: number;
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
  /** What was accepted although it is not as it should be. */
  warnings: string[];
}

/** A surface held by the mesher's worker, ready to be meshed many times. */
export interface Surface extends Disposable {
  readonly info: SurfaceInfo;
  /** Corners of all facets, 9 numbers a facet, for drawing. A copy. */
  corners(): Promise<Float32Array>;
  /** Frees it in the worker. */
  dispose(): void;
}

/** What a mesh would cost. Numbers of cells and rays are exact, the others expected. */
export interface Estimate {
  dims: [number, number, number];
  origin: [number, number, number];
  spacing: [number, number, number];
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
  /** Expected bytes of memory that meshing and writing takes. */
  host_bytes: number;
  /** What they are made of. */
  host: Record<string, number>;
  /** Expected bytes of GPU buffers at most. */
  device_bytes: number;
  /** Bytes of the files: exact for raw and npy, near for vti and hxc; `_bits` a bit a cell; `_zlib` compressed, some times too large. */
  file_bytes: Record<'raw' | 'raw_bits' | 'npy' | 'npy_bits' | 'vti' | 'vti_zlib' | 'hxc' | 'hxc_zlib', number>;
  /** Expected seconds, from the speed of this mesher's last meshes; null before the first. */
  seconds: number | null;
}

export interface FlagReport {
  flag: number;
  name: string;
  cells: number;
  volume: number;
  /** Sum of the signed volumes of its geometries' facets; null for a mesh that {@link Mesher.open} read back. */
  mesh_volume: number | null;
}

/**
 * The report, as the native `--report` writes it; further keys are documented there. A mesh that {@link Mesher.open} read
 * back has no further keys, and null where only the meshing itself could tell.
 */
export interface Report {
  version: string;
  /** Who meshed; null for a mesh read back. */
  backend: 'gpu' | 'cpu' | null;
  /** Name of the GPU; null on the CPU. */
  adapter: string | null;
  driver: string | null;
  /**
   * What came of casting a sample of the GPU's rays again on the CPU: the number of these rays, and of those among them whose
   * cells differed; null if no GPU meshed.
   */
  device_check: { rays: number; differing: number } | null;
  unit: string | null;
  dims: [number, number, number];
  origin: [number, number, number];
  spacing: [number, number, number];
  /** Null for a mesh read back. */
  rule: 'parity' | 'nonzero' | null;
  ray_axis: 'x' | 'y' | 'z';
  rays: number;
  crossings: number;
  runs: number;
  odd_rays: number;
  /** Geometries that are not closed, unless their `open` is `parity`; null for a mesh read back. */
  open: OpenReport[] | null;
  cells: number;
  flags: FlagReport[];
  flags_sha256: string | null;
  warnings: string[];
  /** Cells per second of `seconds.total`; null for a mesh read back. */
  cells_per_second: number | null;
  /** Seconds of each stage, null for one that was not asked for; empty for a mesh read back. */
  seconds: Record<string, number | null>;
  [key: string]: unknown;
}

/** A geometry whose surface is not closed, and how its cells were decided. */
export interface OpenReport {
  geometry: string;
  policy: 'winding' | 'vote';
  /** Edges that facets use an odd number of times, or for the rule `nonzero` more often one way than the other. */
  open_edges: number;
  /** Loops of these edges. */
  holes: number;
  /** Middle of the longest of them. */
  longest_at: [number, number, number];
  /** Facets that were turned to agree with their neighbours. */
  turned: number;
  /** Rays along x, y and z that do not leave it as often as they enter. */
  odd_rays: [number, number, number];
  /** Cells whose three rays are not all even, or do not agree. */
  doubtful_cells: number;
}

/** Mesh lines: line i of an axis is `origin + i * spacing`, i = 0 ..= dims. */
export interface Lines {
  origin: [number, number, number];
  spacing: [number, number, number];
  dims: [number, number, number];
}

/** A box of cells: first and end on x, y, z. */
export interface CellBox {
  start: [number, number, number];
  end: [number, number, number];
}

/** Flags of a box of cells. */
export interface Flags extends CellBox {
  /** `flags[x + nx * (y + ny * z)]` counted from `start`; one byte a cell. */
  flags: Uint8Array;
}

/** A plane of cells for drawing. */
export interface Slice {
  /** Pixels along the first and the second of the two axes across, in the order x, y, z. */
  width: number;
  height: number;
  /** Cells a pixel. */
  step: number;
  /** `flags[i + width * j]`. */
  flags: Uint8Array;
}

/** The stair-step surface of one flag. */
export interface SkinPart {
  flag: number;
  /** Three coordinates a vertex, in world lengths relative to the mesh's origin. */
  positions: Float32Array;
  /** Three a triangle, counter-clockwise seen from outside. */
  indices: Uint32Array;
}

export interface Skin {
  /** Cells a drawn cell: 1, or a power of two where there would have been too many faces. */
  step: number;
  parts: SkinPart[];
}

export type Format = 'vti' | 'npy' | 'raw' | 'hxc';

export interface WriteOptions extends CallOptions {
  /** zlib level 1 (fast) to 9 (small) for vti and hxc, 6 is a good one; 0 (the default) does not compress. */
  compress?: number;
  /** Eight cells a byte, for raw and npy of meshes with one flag. */
  bits?: boolean;
}

/** The runs of one ray: flag `flags[r]` from cell `starts[r]` to the start of the next run or the end of the ray. */
export interface Runs {
  /** First cell of each run along the ray. */
  starts: Uint32Array;
  flags: Uint8Array;
}

/** The result as it is held: runs along rays. */
export interface Columns {
  /** Axis of the rays: 0, 1 or 2. */
  readonly axis: 0 | 1 | 2;
  readonly runs: number;
  /** Bytes held in memory; those of columns that spilled are `report.peak_bytes.aside`. */
  readonly bytes: number;
  /** Runs of the ray through cell (i, j) of the two axes across, in the order x, y, z. */
  ray(i: number, j: number): Promise<Runs>;
}

/** A mesh, held by the worker. */
export interface Mesh extends Disposable {
  readonly dims: [number, number, number];
  readonly lines: Lines;
  readonly report: Report;
  readonly columns: Columns;
  /** Flag of one cell. */
  flag(x: number, y: number, z: number): Promise<number>;
  /** Flags of a box of cells. */
  box(start: [number, number, number], end: [number, number, number]): Promise<Flags>;
  /** All flags in file order, in slabs of at most `maxBytes` (default 16 MiB), one expanded ahead. */
  slabs(options?: { maxBytes?: number; signal?: AbortSignal }): AsyncIterableIterator<Flags>;
  /** One plane of cells across an axis (0, 1, 2), sub-sampled to at most `maxPixels` a side (default 2048). */
  slice(axis: 0 | 1 | 2, index: number, maxPixels?: number): Promise<Slice>;
  /** The stair-step surface, coarsened until it has at most `maxQuads` (default 2,000,000). */
  skin(options?: { maxQuads?: number; signal?: AbortSignal }): Promise<Skin>;
  /** SHA-256 of all flags, one byte each, x fastest: that of the raw file. */
  sha256(options?: CallOptions): Promise<string>;
  /** Bytes of a file before it is made; null where they depend on the flags (compressed, hxc). */
  size(format: Format, options?: WriteOptions): number | null;
  /** A file, byte for byte that of the native command, as a stream that is made as it is read. */
  stream(format: Format, options?: WriteOptions): ReadableStream<Uint8Array>;
  /** A file as a Blob. */
  blob(format: Format, options?: WriteOptions): Promise<Blob>;
  /** The `.raw.json` that describes a raw file. */
  sidecar(options?: WriteOptions): Promise<string>;
  /** Frees it in the worker. */
  dispose(): void;
}

/** A GPU as far as the browser tells; empty strings where it does not. */
export interface Adapter {
  /** For people: the description, or vendor and architecture. */
  name: string;
  vendor: string;
  architecture: string;
  description: string;
  driver: string;
  /** Whether it computes on the processor, such as SwiftShader or llvmpipe. */
  software: boolean;
}

export interface Mesher extends Disposable {
  /** Who meshes; no longer the GPU where `auto` has lost it, and no other could be opened: the CPU goes on, with the same result. */
  readonly backend: 'gpu' | 'cpu';
  /** The GPU; null on the CPU. */
  readonly adapter: Adapter | null;
  /** Why the CPU meshes although `auto` looked for a GPU, found one that computes on the processor, or had one; null otherwise. */
  readonly fallback: string | null;
  /** Reads and checks a surface without meshing it. */
  read(source: Exclude<GeometrySource, Surface>, options?: CallOptions & { file?: string }): Promise<Surface>;
  /** Meshes a job. Calls wait for each other. */
  mesh(job: Job, options?: MeshOptions): Promise<Mesh>;
  /** What a mesh would cost, without making it. */
  estimate(job: Job, options?: CallOptions): Promise<Estimate>;
  /**
   * Opens a column file. In a worker a Blob stays where it is: the mesh reads pieces of it as they are needed, so that a file may
   * be larger than the memory. It must not change meanwhile; damage of a piece shows when it is read, as `columns-corrupt`.
   */
  open(file: Blob | Uint8Array | ArrayBuffer, options?: CallOptions): Promise<Mesh>;
  /** Ends the worker and frees everything; pending calls reject with `cancelled`. */
  dispose(): void;
}

/** Starts a worker and opens its backend. */
export function createMesher(options?: MesherOptions): Promise<Mesher>;

/** Version of hexcast. */
export const version: string;

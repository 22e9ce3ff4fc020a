/** What comes out: the mesh, its flags and its files. */
import type { CallOptions, Device, FileSource } from '../hexcast.js';
import type { CellsFormat, MeasuredFormat, ProgramFormat } from './formats.js';
import type { Job } from './options.js';
import type { Conformal, Distances, Fractions, Links, Staggered, Tensors } from './measured.js';
import type { Difference, SliceOptions, ViewOptions } from './pictures.js';
import type { Report } from './report.js';

/** Arrays over an `ArrayBuffer` of their own, in every version of TypeScript. */
export type Bytes = ReturnType<Uint8ArrayConstructor['of']>;
export type Uint32Numbers = ReturnType<Uint32ArrayConstructor['of']>;
export type Float32Numbers = ReturnType<Float32ArrayConstructor['of']>;

/** Three numbers, for x, y and z. */
export type Triple = readonly [number, number, number];

/** Mesh lines: line i of an axis is `origin + i * spacing`, i = 0 ..= dims; where cells differ in size `lists` has them all. */
export interface Lines {
  origin: [number, number, number];
  /** Null where cells differ in size. */
  spacing: [number, number, number] | null;
  dims: [number, number, number];
  /** All lines of each axis where cells differ in size, else null. */
  lists: { x: number[]; y: number[]; z: number[] } | null;
}

/** A box of cells: first and end on x, y, z. */
export interface CellBox {
  start: [number, number, number];
  end: [number, number, number];
}

/** Flags of a box of cells. */
export interface Flags<T extends Uint8Array = Bytes> extends CellBox {
  /** `flags[x + nx * (y + ny * z)]` counted from `start`; one byte a cell. */
  flags: T;
}

/** Which flags go to a device. */
export interface FlagsOnDeviceOptions {
  /** The first cell and the end, with at least one cell; by default the whole mesh. */
  box?: { readonly start: Triple; readonly end: Triple };
  signal?: AbortSignal;
}

export interface FlagsBufferOptions extends FlagsOnDeviceOptions {
  /**
   * Bits of a cell. With 8 (the default) cell (x, y, z) of the box is byte `x + nx * (y + ny * z)`, and holds its flag. With 1 it is bit
   * `x % 8` of byte `floor(x / 8) + ceil(nx / 8) * (y + ny * z)`, which is 1 where the flag is not 0.
   */
  bits?: 1 | 8;
}

export interface FlagsTextureOptions extends FlagsOnDeviceOptions {
  /** One unsigned byte a texel, the flag. There is no other. */
  format?: 'r8uint';
}

/** A plane of cells for drawing. */
export interface Slice {
  /** Pixels along the first and the second of the two other axes, in the order x, y, z. */
  width: number;
  height: number;
  /** Cells a pixel. */
  step: number;
  /** `flags[i + width * j]`. */
  flags: Bytes;
}

/** The stair-step surface of one flag. */
export interface SkinPart {
  flag: number;
  /** Three coordinates a vertex, in world lengths relative to the mesh's origin. */
  positions: Float32Numbers;
  /** Three a triangle, counter-clockwise seen from outside. */
  indices: Uint32Numbers;
}

export interface Skin {
  /** Edge of a drawn cell in cells: 1, or a power of two where there would have been too many faces. */
  step: number;
  parts: SkinPart[];
}

/**
 * Files for other programs; each is named as its files end. Those without a grid have the cells of all flags but 0, or those of `exportFlags`.
 *
 * - `foam`: OpenFOAM, as a ZIP archive of `mesh.foam` and `constant/polyMesh/`, to be unpacked into the folder of a case. With `cut_cells` in the job the cells of the fluid
 *   are cut at its surface.
 * - `eb`: AMReX, as a ZIP archive of a folder for `EB2::BuildFromChkptFile`, for cells of one size. The job needs `cut_cells: { boundary: true }`.
 * - `inp`: Abaqus and CalculiX.
 * - `msh`: Gmsh, MSH 4.1.
 * - `xdmf`: ParaView, VTK, meshio, dolfinx, as a ZIP archive of `mesh.xdmf` and `mesh.h5`.
 * - `csx.xml`: openEMS. Every flag needs a `material`.
 * - `in`: gprMax 4, for cells of one size, as a ZIP archive of `mesh.in`, `mesh_geo.h5` and `mesh_materials.json`. Every flag needs a `material`.
 * - `geometry.xml`: OpenMC, for cells of one size.
 * - `nrrd`: 3D Slicer, ITK, pynrrd, for cells of one size.
 * - `vox`: MagicaVoxel, for cells of one size. `binvox`: for cubes.
 * - `glb`, `stl`: closed surfaces of the cells; GLB with names and colours, in metres where the unit is known.
 *
 * foam, inp, csx.xml, in and geometry.xml need the `unit` of the job. HDF5 is held in memory, up to 2^29 bytes of numbers: of xdmf 65 bytes a cell and
 * 24 a point, of in 2 a cell of the box.
 */
export type ExportFormat = ProgramFormat;

/**
 * Formats of files: those of the mesh, of what its job asked for besides, and of other programs. `vti` is for cells of one size.
 *
 * - `zarr`: the files of a Zarr v3 store in a ZIP archive, for the `ZipStore` of zarr-python; chunks and shards as the `zarr` of the job says.
 * - `links.h5`, `distance.h5`: HDF5 with the arrays of the `.npz`, held in memory up to 2^29 bytes: 24 a link, 8 a point.
 * - `links`: records of 24 bytes, for programs that read without NumPy.
 * - `fractions.vti`, `fractions.vtr`, `fractions.npy`, `fractions.zarr`: for every cell the fraction that is not background.
 */
export type Format = CellsFormat | MeasuredFormat | ExportFormat;

/** What a {@link Format} is and can hold. */
export interface FormatFacts {
  /** The flags of the cells, what the job asked for besides, or a file of another program: an {@link ExportFormat}. */
  readonly kind: 'cells' | 'measured' | 'export';
  /** The media type of the file. */
  readonly type: string;
  /** Whether it can be compressed. */
  readonly compresses: boolean;
  /** Whether there is a form in text besides the binary one. */
  readonly ascii: boolean;
  /** Whether the job must have a `unit`. */
  readonly unit: boolean;
  /** The cells that it can hold: of any sizes, of one size along each axis, or cubes. */
  readonly spacing: 'any' | 'equal' | 'cubes';
  /** Of an {@link ExportFormat}: the program that reads it, or its own name. */
  readonly program?: string;
  /** Of an {@link ExportFormat}: what is in it, in a few words. */
  readonly about?: string;
  /** Of an {@link ExportFormat}: the name of its file, with `NAME` for what the caller chooses. An archive is to be unpacked. */
  readonly file?: string;
}

/** What stands for a cell in raw, npy and npz. */
export interface CellBytes {
  /** Eight cells a byte, for raw and npy of meshes with one flag. */
  bits?: boolean;
  /**
   * Order of the axes: `zyx` (the default) has x fastest, shape (nz, ny, nx); `xyz` has x slowest, shape (nx, ny, nz), as lattice Boltzmann
   * and FDTD codes in Python want it. Not with `bits`.
   */
  axisOrder?: 'zyx' | 'xyz';
  /**
   * Other numbers, 0 to 255, for some flags: `{ 1: 0, 0: 1 }` makes the pores of a solid 1. Flags that are not named stay as they are. Not with
   * `bits`.
   */
  map?: Readonly<Record<number, number>>;
}

export interface WriteOptions extends CallOptions, CellBytes {
  /**
   * zlib level for vti, vtr, hxc, nrrd, zarr (its chunks), every npz, HDF5 (xdmf, in, every h5; its chunks) and the archive of foam: 0 does not compress, 1 is fast, 6, the default, is a good
   * compromise, 9 is small. All other formats are never compressed.
   */
  compress?: number;
  /** Text in place of numbers in binary, for foam and msh. Default false. */
  ascii?: boolean;
  /** Flags, 0 to 255, whose cells are exported, for every {@link ExportFormat} but nrrd; by default all but 0. At least one; each has cells. */
  exportFlags?: readonly number[];
  /** Told at the end of a file, a sentence each, what it lacks of the mesh: parts of cut cells that foam or eb cannot hold. */
  onLack?: (sentence: string) => void;
}

/** Which raw file is described. */
export interface SidecarOptions extends CallOptions, CellBytes {
  /** Adds the SHA-256 of the raw file, which takes as long as making it. */
  hash?: 'sha256';
}

/** The runs of one ray: flag `flags[r]` from cell `starts[r]` to the start of the next run or the end of the ray. */
export interface Runs {
  /** First cell of each run along the ray. */
  starts: Uint32Numbers;
  flags: Bytes;
}

/** The result as it is held: runs along rays. */
export interface Columns {
  /** Axis of the rays: 0, 1 or 2. */
  readonly axis: 0 | 1 | 2;
  readonly runs: number;
  /** Bytes held in memory; `report.peak_bytes.spilled` has those that spilled. */
  readonly bytes: number;
  /** Runs of the ray through cell (i, j) of the two other axes, in the order x, y, z. */
  ray(i: number, j: number): Promise<Runs>;
  /** Runs of all rays at once; progress counts runs. Takes 5 bytes a run and 4 a ray. */
  all(options?: CallOptions): Promise<AllRuns>;
}

/**
 * The runs of all rays. The ray through cell (i, j) of the two other axes is number `k = i + n_i * j`; its runs are those from
 * `offsets[k]` to `offsets[k + 1]`.
 */
export interface AllRuns extends Runs {
  /** First run of each ray, and the number of runs at the end: one number more than there are rays. */
  offsets: Uint32Numbers;
}

/** Which leak is looked for. */
export interface LeakQuestion {
  /** The point at which paths begin, in the unit of the mesh. A point on a mesh line belongs to the cell above. */
  from: [number, number, number];
  /** The point at which they end. */
  to: [number, number, number];
  /** Flags of cells that a path may use, 0 to 255; by default that of the cell at `from`. */
  flags?: number[];
  /** Names the facets around the narrowest place in the surfaces of this job. */
  job?: Job;
  /** Most bytes of memory for the search, besides what the mesh takes; by default 1 GiB. */
  max_memory?: number;
}

/** An end of the paths. */
export interface LeakEnd {
  point: [number, number, number];
  /** The cell that holds the point. */
  cell: [number, number, number];
  /** Its flag. */
  flag: number;
  /** Number of cells that paths from it reach. */
  n_cells: number;
}

/** What was found, as the native `hexcast leak --json` prints it. A path goes from cell to cell over faces. */
export interface Leak {
  /** Whether there is no path. */
  is_tight: boolean;
  /** Flags of cells that a path may use, ascending. */
  flags: number[];
  from: LeakEnd;
  to: LeakEnd;
  /** A path of the fewest steps; null where there is none. */
  path: {
    /** Number of steps from cell to cell. */
    steps: number;
    /** From the centre of the first cell to that of the last, in the unit of the mesh. */
    length: number;
    /** The cells at which it begins, turns and ends. */
    cells: [number, number, number][];
    /** Their centres. */
    points: [number, number, number][];
  } | null;
  /** What stops a larger cube than the widest that passes; null where there is no path, or a cube of 64 cells passes. */
  narrowest: {
    /** Edge of the largest cube of open cells that passes, in cells. */
    width: number;
    /** First cell of the cube in the middle of the narrowest place, and the cell after its last, on each axis. */
    cells: [[number, number, number], [number, number, number]];
    /** The corners of these cells. */
    bounds: [[number, number, number], [number, number, number]];
    centre: [number, number, number];
    /** Centres of the cube where its way begins, turns and ends. */
    way: [number, number, number][];
  } | null;
  /** Unit of lengths. */
  unit: string | null;
  /** Facets within a cell of the narrowest place: the geometry, and the index of the facet in it from 0; null without a `job`. */
  facets: { geometry: string; facet: number }[] | null;
}

/** A mesh, held by the worker. */
export interface Mesh extends Disposable {
  readonly dims: [number, number, number];
  readonly lines: Lines;
  readonly report: Report;
  readonly columns: Columns;
  /** Flag of one cell. */
  flag(x: number, y: number, z: number): Promise<number>;
  /**
   * Flags of a box of cells: in a new array, or in the first bytes of `into`. A box of more cells than an array can have fails with
   * `memory`: read slabs.
   */
  box<T extends Uint8Array = Bytes>(start: Triple, end: Triple, options?: { into?: T; signal?: AbortSignal }): Promise<Flags<T>>;
  /**
   * Flags of a box of cells in a new `GPUBuffer` of your device, whether this mesher uses the device or not. Only runs go to the device,
   * which makes flags of them: some bytes a ray. Its size is that of the bytes, rounded up to 4; the last word is filled up with 0. Its
   * usage is `STORAGE | COPY_SRC | COPY_DST`, and it is yours: destroy it. In WGSL, over `flags: array<u32>`, the flag of cell i is
   * `(flags[i / 4] >> (8 * (i % 4))) & 0xff`.
   *
   * Fails with `job-value` where the box is not within the mesh or has no cell, `memory` where the device has no buffer as large,
   * `device-lost`, and `device-failed` where the device refuses the work. Errors of the device that are not of this call stay yours.
   */
  flagsBuffer(device: Device, options?: FlagsBufferOptions): Promise<GPUBuffer>;
  /**
   * Flags of a box of cells in a new 3-D `GPUTexture` of your device, one texel a cell, for `texture_3d<u32>` and `textureLoad`. Its usage is
   * `TEXTURE_BINDING | COPY_SRC | COPY_DST`, and it is yours: destroy it. Fails as `flagsBuffer`, and with `memory` where the box is longer
   * than the device's `maxTextureDimension3D`, 2048 by default.
   */
  flagsTexture(device: Device, options?: FlagsTextureOptions): Promise<GPUTexture>;
  /**
   * All flags in file order, in slabs of at most `maxBytes` (default 16 MiB, or those of `into`); the next slab is expanded in
   * advance. With `into` every slab is put into the same first bytes of that array, which the next one overwrites.
   */
  slabs<T extends Uint8Array = Bytes>(options?: {
    maxBytes?: number;
    into?: T;
    signal?: AbortSignal;
  }): AsyncIterableIterator<Flags<T>>;
  /** One plane of cells perpendicular to an axis (0, 1, 2), sub-sampled to at most `maxPixels` a side (default 2048). */
  slice(axis: 0 | 1 | 2, index: number, maxPixels?: number): Promise<Slice>;
  /**
   * A picture of slices with a legend, PNG, byte for byte that of the native `hexcast slice`. Fails with `job-value` where a place is not
   * within the mesh or the picture has too many pixels, `memory` where it takes more than is allowed.
   */
  slice(options: SliceOptions): Promise<Blob>;
  /**
   * A picture of the stair-step surface, shaded, with a legend, PNG, byte for byte that of the native `hexcast view`. Needs no display. Fails
   * as `slice`, and with `job-value` where no cell that is shown has a flag.
   */
  view(options?: ViewOptions): Promise<Blob>;
  /**
   * Compares it cell by cell with another mesh of this mesher, or with a column file (`.hxc`). The mask takes at most `max_memory` bytes, by
   * default 1 GiB. Fails with `job-conflict` where the two differ in their numbers of cells, `memory` where the mask takes more than is
   * allowed, and as `Mesher.open` where the file cannot be read.
   */
  diff(other: Mesh | FileSource, options?: { max_memory?: number; signal?: AbortSignal }): Promise<Difference>;
  /** The stair-step surface, coarsened until it has at most `maxQuads` (default 2,000,000). */
  skin(options?: { maxQuads?: number; signal?: AbortSignal }): Promise<Skin>;
  /**
   * Looks for a path from one point to another, its narrowest place, and the facets around that. Fails with `job-value` where a point
   * lies outside of the mesh or in a cell whose flag is not open, `job-conflict` where no flags are given and the points are in cells
   * of different flags, `memory` where the search takes more than is allowed. An abort does not stop the search itself.
   */
  leak(question: LeakQuestion, options?: CallOptions): Promise<Leak>;
  /** The links that the job asked for. Fails with `job-conflict` where it did not, and for an opened mesh. */
  links(options?: CallOptions): Promise<Links>;
  /** The fractions of cells that the job asked for. Fails as `links`. */
  fractions(options?: CallOptions): Promise<Fractions>;
  /** The flags at the points of a staggered grid, if the job asked for them: about seven bytes a cell. Fails as `links`. */
  staggered(options?: CallOptions): Promise<Staggered>;
  /** What of edges and faces lies outside metal, if the job asked for it: about 48 bytes a cell. Fails as `links`. */
  conformal(options?: CallOptions): Promise<Conformal>;
  /** Signed distances, if the job asked for them: 8 bytes a cell. Fails as `links`. */
  distance(options?: CallOptions): Promise<Distances>;
  /** The permittivity averaged around the points of E, if the job asked for it: about 144 bytes a cell. Fails as `links`. */
  tensors(options?: CallOptions): Promise<Tensors>;
  /** SHA-256 of all flags, one byte each, x fastest: that of the raw file. */
  sha256(options?: CallOptions): Promise<string>;
  /** Bytes of a file before it is made; null where they depend on the flags (compressed, hxc, exports but nrrd) or on the archive (npz, zarr). */
  size(format: Format, options?: WriteOptions): number | null;
  /**
   * A file, byte for byte that of the native command (HDF5: the same arrays and attributes), as a stream that is made as it is read. Where the browser has streams of bytes,
   * a reader can bring its own buffers: `getReader({ mode: 'byob' })`. An export holds what it makes of a plane of cells across z at a time:
   * up to about a hundred bytes a cell. Its progress counts bytes, before the first of them cells; an abort stops it within a slab or a plane.
   *
   * Fails with `job-conflict` where an option is not one of the format, or where no cell has a flag of `exportFlags`; `export-unit` where lengths must be in metres or centimetres and the job has no `unit`; `lines-graded` where
   * cells must be of one size, or cubes; `memory` where a plane of more than 2^22 cells would be held (across z, for binvox across x; not for nrrd, vox and in), or an HDF5 file would have more than 2^29 bytes; `export-material` where the program must know what a flag is made of; `export-too-large` where the
   * format cannot number so many cells or points.
   */
  stream(format: Format, options?: WriteOptions): ReadableStream<Bytes>;
  /** A file as a Blob. Fails as `stream`. */
  blob(format: Format, options?: WriteOptions): Promise<Blob>;
  /** The `.raw.json` that describes a raw file, byte for byte that of the native command. */
  sidecar(options?: SidecarOptions): Promise<string>;
  /** Frees it in the worker. */
  dispose(): void;
}

/** What comes out: the mesh, its report, its flags and its files. */
import type { CallOptions } from './hexcast.js';
import type { Job } from './job.js';

export interface FlagReport {
  flag: number;
  name: string;
  cells: number;
  volume: number;
  /**
   * Sum of the volumes that its geometries' surfaces enclose; null where one is open, filled, inverted or cut by the domain, and for a
   * mesh that was opened from a column file.
   */
  mesh_volume: number | null;
  /**
   * The most by which `volume` can differ from `mesh_volume` where neither geometries nor shells of one overlap; null where
   * `mesh_volume` is.
   */
  volume_bound: number | null;
}

/** Peak sizes in bytes. */
export interface PeakBytes {
  /** Of the whole process; null where the system does not report it, as in browsers. */
  host: number | null;
  /** Of facets, lattice and columns while meshing, as the library counts them. */
  meshing: number;
  /** Of buffers on the device. */
  device: number;
  /** Of columns that spilled to disk. */
  spilled: number;
}

/**
 * The report, as the native `--report` writes it; `docs/report.schema.json` describes every key. A mesh that `Mesher.open` opened has no
 * further keys than these, and null for what a column file does not hold.
 */
export interface Report {
  version: string;
  /** The backend that meshed; null for an opened mesh. */
  backend: 'gpu' | 'cpu' | null;
  /** Name of the GPU; null on the CPU. */
  adapter: string | null;
  driver: string | null;
  /**
   * The CPU casts a sample of the GPU's rays again: the number of these rays, and of those among them whose cells differed;
   * null if no GPU meshed.
   */
  device_check: { rays: number; differing: number } | null;
  unit: string | null;
  dims: [number, number, number];
  /** Which cells of a larger box these are: the first, and the end, exclusive; null where they are all, and for an opened mesh. */
  window: { first: [number, number, number]; end: [number, number, number]; of: [number, number, number] } | null;
  origin: [number, number, number];
  spacing: [number, number, number];
  /** Null for an opened mesh. */
  rule: 'parity' | 'nonzero' | null;
  ray_axis: 'x' | 'y' | 'z';
  rays: number;
  crossings: number;
  runs: number;
  odd_rays: number;
  /** The geometries of the job, in meshing order; missing for an opened mesh. */
  geometries?: GeometryReport[];
  /** Geometries that are not closed, unless their `open` is `parity`; null for an opened mesh. */
  open: OpenReport[] | null;
  /** Geometries that have the cells along their surfaces; null for an opened mesh. */
  filled: FillReport[] | null;
  /** Openings that were closed; null where the job has no `close_gaps`, and for an opened mesh. */
  gaps: GapsReport | null;
  cells: number;
  flags: FlagReport[];
  /** The geometries, in meshing order; missing for an opened mesh. */
  geometries?: GeometryReport[];
  /** Cells that the winding number or a vote decided, as rays could not; null for an opened mesh. */
  doubtful: DoubtReport | null;
  /**
   * The job with all that it left open filled in, in the form of job files: `file` in place of `source`; null for an opened mesh.
   */
  job: { geometries: { file: string; flag: number; [key: string]: unknown }[]; [key: string]: unknown } | null;
  /** Thin walls, overlaps and gaps of one cell; null where the job did not ask for them, and for an opened mesh. */
  certificate: CertificateReport | null;
  /** Hash of the flags, the same on every device and along every axis; null for an opened mesh and where the columns have spilled. */
  flags_hash: string | null;
  /** SHA-256 of the flags; null, as `Mesh.sha256` makes it where it is needed. */
  flags_sha256: string | null;
  warnings: string[];
  /** Cells per second of `seconds.total`; null for an opened mesh. */
  cells_per_second: number | null;
  /** Seconds of each stage, null for a stage that was not asked for; empty for an opened mesh. */
  seconds: Record<string, number | null>;
  /** Missing for an opened mesh. */
  peak_bytes?: PeakBytes;
  [key: string]: unknown;
}

/** A geometry of the job, as it was placed. */
export interface GeometryReport {
  name: string;
  flag: number;
  priority: number;
  facets: number;
  /** Least and greatest coordinates. */
  bounding_box: [[number, number, number], [number, number, number]];
  /** Signed volume enclosed by the facets: positive where normals point outwards. */
  mesh_volume: number;
  /**
   * The most by which the volume of its cells can differ from that, unless shells of it overlap; null where its cells are not those
   * within its surface: that is open, or its facets do not agree, or it is filled, a shell, inverted or cut by the domain.
   */
  volume_bound: number | null;
  /** Whether its cells are those outside of it. */
  invert: boolean;
  /** Edges that are not shared by two facets that agree, after the corners were rounded. */
  bad_edges: BadEdges;
}

/** The edges of a geometry that are not shared by two facets that agree. */
export interface BadEdges {
  /** Number of edges that one facet has. */
  open: number;
  /** Number of edges that two facets use in the same direction: one of the two is inside-out. */
  flipped: number;
  /** Number of edges that more than two facets have. */
  nonmanifold: number;
  /** At most 8 groups of edges of each kind that meet at corners, open ones first, then flipped ones; of each kind the longest first. */
  worst: {
    kind: 'open' | 'flipped' | 'nonmanifold';
    /** Number of edges, and their length together. */
    edges: number;
    length: number;
    /** Corners of the box around them. */
    bounds: [[number, number, number], [number, number, number]];
    /** Facets that have them, counted from 0 in their file, ascending; at most 8. */
    facets: number[];
  }[];
}

/** Cells of open geometries that rays do not decide. */
export interface DoubtReport {
  cells: number;
  /** Boxes of them, at most 1,000, the largest first: the first cell x, y, z and the end, exclusive. No cell is in two. */
  boxes: [[number, number, number], [number, number, number]][];
  /** Number of cells in these boxes, and whether these are all. */
  cells_in_boxes: number;
  are_all: boolean;
}

/** The openings that `close_gaps` closed. */
export interface GapsReport {
  /** Openings of fewer cells were closed. */
  width: number;
  /** Flag of the added cells. */
  flag: number;
  /** Number of added cells. */
  cells: number;
  /** Number of gaps: their cells are connected over faces. */
  gaps: number;
  /** The gaps of most cells, at most 100: number of cells, and the corners of the box around them. */
  largest: { cells: number; bounds: [[number, number, number], [number, number, number]] }[];
}

/** A geometry whose surface is not closed, and how its cells were decided. */
export interface OpenReport {
  geometry: string;
  policy: 'winding' | 'vote';
  /** Edges that facets use an odd number of times, or for the rule `nonzero` more often one way than the other. */
  open_edges: number;
  /** Loops of these edges. */
  holes: number;
  /** Middle of the longest of these edges. */
  longest_at: [number, number, number];
  /** Facets that were turned to agree with their neighbours. */
  turned: number;
  /** Rays along x, y and z that do not leave it as often as they enter. */
  odd_rays: [number, number, number];
  /** Cells whose three rays are not all even, or do not agree. */
  doubtful_cells: number;
}

/** A geometry that has the cells along its surface. */
export interface FillReport {
  geometry: string;
  fill: 'conservative' | 'separating';
  /** Whether it has no others. */
  shell: boolean;
  /** Cells that it has for no other reason. */
  added_cells: number;
}

/** What a mesh may have lost, or decided between closed geometries. */
export interface CertificateReport {
  /** Walls of fewer cells are listed. */
  thin_cells: number;
  /** Walls that are thin along an axis: stretches of rays, those that hold no centre of a cell, the fewest centres and a place. */
  thin_walls: {
    geometry: string;
    axis: 'x' | 'y' | 'z';
    rays: number;
    lost: number;
    cells: number;
    place: [number, number, number];
  }[];
  /** Pairs of geometries with common cells, and a place in them. */
  overlaps: { winner: string; loser: string; cells: number; volume: number; place: [number, number, number] }[];
  /**
   * Background cells with one flag before them and another behind, along an axis: the two flags, their names, the number of cells, the
   * centre of one of them, and the corners of the box around all.
   */
  gaps: {
    flags: [number, number];
    names: [string, string];
    axis: 'x' | 'y' | 'z';
    cells: number;
    place: [number, number, number];
    bounds: [[number, number, number], [number, number, number]];
  }[];
}

/** Arrays over an `ArrayBuffer` of their own, in every version of TypeScript. */
export type Bytes = ReturnType<Uint8ArrayConstructor['of']>;
export type Uint32Numbers = ReturnType<Uint32ArrayConstructor['of']>;
export type Float32Numbers = ReturnType<Float32ArrayConstructor['of']>;

/** Three numbers, for x, y and z. */
export type Triple = readonly [number, number, number];

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
export interface Flags<T extends Uint8Array = Bytes> extends CellBox {
  /** `flags[x + nx * (y + ny * z)]` counted from `start`; one byte a cell. */
  flags: T;
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

export type Format = 'vti' | 'npy' | 'raw' | 'hxc';

export interface WriteOptions extends CallOptions {
  /** zlib level for vti and hxc: 0 (the default) does not compress, 1 is fast, 6 is a good compromise, 9 is small. */
  compress?: number;
  /** Eight cells a byte, for raw and npy of meshes with one flag. */
  bits?: boolean;
}

export interface SidecarOptions extends CallOptions {
  /** Describes the file with eight cells a byte. */
  bits?: boolean;
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
  /** The stair-step surface, coarsened until it has at most `maxQuads` (default 2,000,000). */
  skin(options?: { maxQuads?: number; signal?: AbortSignal }): Promise<Skin>;
  /**
   * Looks for a path from one point to another, its narrowest place, and the facets around that. Fails with `job-value` where a point
   * lies outside of the mesh or in a cell whose flag is not open, `job-conflict` where no flags are given and the points are in cells
   * of different flags, `memory` where the search takes more than is allowed. An abort does not stop the search itself.
   */
  leak(question: LeakQuestion, options?: CallOptions): Promise<Leak>;
  /** SHA-256 of all flags, one byte each, x fastest: that of the raw file. */
  sha256(options?: CallOptions): Promise<string>;
  /** Bytes of a file before it is made; null where they depend on the flags (compressed, hxc). */
  size(format: Format, options?: WriteOptions): number | null;
  /**
   * A file, byte for byte that of the native command, as a stream that is made as it is read. Where the browser has streams of bytes,
   * a reader can bring its own buffers: `getReader({ mode: 'byob' })`.
   */
  stream(format: Format, options?: WriteOptions): ReadableStream<Bytes>;
  /** A file as a Blob. */
  blob(format: Format, options?: WriteOptions): Promise<Blob>;
  /** The `.raw.json` that describes a raw file, byte for byte that of the native command. */
  sidecar(options?: SidecarOptions): Promise<string>;
  /** Frees it in the worker. */
  dispose(): void;
}

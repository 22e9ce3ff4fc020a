/** What goes in: surfaces, the job, and what a job would cost. */
import type { CallOptions } from './hexcast.js';
import type { Grading } from './report.js';
import type { Float32Numbers, Triple } from './result.js';

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

/** Properties of a substance, all optional, in SI units whatever the unit of lengths. */
export interface Material {
  /** Relative permittivity, positive. */
  eps_r?: number;
  /** Relative permeability, positive. */
  mu_r?: number;
  /** Electric conductivity in S/m, 0 or positive. */
  sigma?: number;
  /** Whether it is a perfect electric conductor. */
  pec?: boolean;
  /** Density in kg/m3, positive. */
  density?: number;
  /** Young's modulus in Pa, positive. */
  E?: number;
  /** Poisson's ratio, greater than -1 and less than 0.5. */
  nu?: number;
}

export interface GeometryJob {
  /** The facets. */
  source: GeometrySource;
  /** Name of the file in reports; by default that of the File, or `geometry-1`, ... */
  file?: string;
  /** Takes only the solid of this name from an ASCII file of several. */
  solid?: string;
  /** Makes every solid of the file a geometry of its own. */
  split?: boolean;
  /** With `split` and `flag` every solid has this flag, instead of flags that count up. */
  same_flag?: boolean;
  /** Name in reports and outputs; by default the file's without its extension. */
  name?: string;
  /** Property flag of its cells, 1 to 255; by default 1, 2, ... in order. */
  flag?: number;
  /** Where geometries overlap, the higher priority wins; at equal priority a geometry that is closed or flat wins over one that is not, else the later one. Default 0. */
  priority?: number;
  /** How cells are decided where its surface is not closed; by default as the job says. */
  open?: Job['open'];
  /** Which cells along its surface it has as well; by default as the job says. */
  fill?: Job['fill'];
  /** Only the cells along its surface, and none for being inside; by default the `separating` ones. */
  shell?: boolean;
  /** The cells outside of it instead of those inside, such as the fluid around a body. */
  invert?: boolean;
  /** With `graded`: largest size of a cell across its box. */
  max_size?: number;
  /** With `graded`: fewest cells across its box along every axis, at least 1. */
  min_cells?: number;
  /** With `graded`: whether lines lie beside its edges, a third of a cell inside and two thirds outside, as solvers of Maxwell's equations want. */
  metal?: boolean;
  /** What it is made of: passed on to every output, and not used otherwise. */
  material?: Material;
  /** Scales first: one factor, or one for each axis. */
  scale?: number | Triple;
  /** Then rotates about x, y and z, in degrees. */
  rotate?: Triple;
  /** The point about which it rotates, where it is once scaled; by default the origin. */
  about?: Triple;
  /** Then moves. */
  translate?: Triple;
}

/** How lines are generated. Lengths are in the unit of the files. */
export interface GradedJob {
  /** Largest size of a cell, on all axes or each. */
  max_size: number | Triple;
  /** Smallest size of a cell; by default a thousandth of the largest. Of ends that are closer to each other one is left off the lines. */
  min_size?: number;
  /** Largest ratio of neighbouring cells, 1.01 to 10; default 1.3. */
  growth?: number;
  /** Cells of the size at the end that are added on both sides of every axis, up to 1,024: for absorbing layers. Default 0. */
  absorbing?: number | Triple;
}

/** Which links are measured. */
export interface LinksJob {
  /** `D3Q7` has links over the 6 faces of a cell, `D3Q15` also over the 8 corners, `D3Q19` (the default) over faces and 12 edges, `D3Q27` over all. */
  stencil?: 'D3Q7' | 'D3Q15' | 'D3Q19' | 'D3Q27';
  /** Flags of the fluid, 0 to 255; default 0, the background. */
  fluid?: readonly number[];
}

/** How fractions of cells are measured. */
export interface FractionsJob {
  /** Rays of a cell along each of two axes: 1, 2, 4 (the default), 8 or 16. The fraction of a cell that one plane cuts is off by less than 1 / rays. */
  rays?: number;
  /** Also the fraction of each face of these cells. Default false. */
  faces?: boolean;
  /** Also area, centre and normal of the surface in each cell. Default false. */
  surfaces?: boolean;
}

/** What is meshed and how: the native job file, with sources in place of file names. */
export interface Job {
  /** In meshing order. */
  geometries: readonly GeometryJob[];
  /** Two corners of the box, x0 y0 z0 x1 y1 z1; by default the bounding box of all geometries. */
  domain?: readonly [number, number, number, number, number, number];
  /** Space added on both sides of each axis, to `domain` or to the bounding box of the geometries, in whole cells or as a length. */
  padding?: { readonly cells: number | Triple } | { readonly length: number | Triple };
  /** Number of cubic cells along the longest axis; the default is 128. At most one of these six is given. */
  cells?: number;
  /** Number of cells on x, y, z. */
  dims?: Triple;
  /** Cell size: one for all axes, or one for each. */
  cell_size?: number | Triple;
  /** Upper limit of the cell size. The mesher takes the largest size for each axis that puts all bounding boxes on mesh lines. */
  max_cell_size?: number;
  /** Largest distance, in cells, of the end of a bounding box from its line with `max_cell_size`: 0 to 0.5, default 0.05. */
  tolerance?: number;
  /**
   * All lines of each axis, ascending, in the unit of the files: cells + 1 numbers each, at most 262,143. The first and the last are the domain.
   */
  lines?: { readonly x: Numbers; readonly y: Numbers; readonly z: Numbers };
  /** Generates lines of cells that differ in size: one on every end of every geometry's box, close where geometries are small, far elsewhere. */
  graded?: GradedJob;
  /** Most cells, however they are chosen; without it only those of an axis are limited. A mesh of more fails with `too-many-cells`. */
  max_cells?: number;
  /**
   * Meshes only some cells of the box: the first on x, y and z, and the end, exclusive. Lines, flags and all else are those of the whole
   * box.
   */
  window?: [number, number, number, number, number, number];
  /** Meshes only one of the windows that the box is divided into, from 1 on, x fastest: `of` has their numbers along x, y and z. */
  part?: { index: number; of: [number, number, number] };
  /**
   * Cells around the window or the part that are also meshed, on both sides: every axis of the mesh has twice this number of cells more.
   */
  halo?: number;
  /** Flags of halo cells beyond the box: background, or the flag of the nearest cell of the box. Default `background`. */
  halo_edge?: 'background' | 'clamp';
  /**
   * Shapes of the chunks and shards of a Zarr store, as cells on x, y, z, or most bytes of a shard. Where it is
   * given, parts are cut along the borders of shards.
   */
  zarr?: { chunks?: Triple; shards?: Triple; shard_bytes?: number | string };
  /** Inside is an odd number of crossings, or a winding number other than zero. Default `parity`. */
  rule?: 'parity' | 'nonzero';
  /**
   * How cells are decided where a surface is not closed. `winding`: by the rays of three axes where they are even and agree, elsewhere
   * by the generalised winding number. `vote`: by most of the axes whose rays are even, for surfaces that cannot be oriented.
   * `error`: the mesh fails with `surface-open`. `parity`: by the rays of one axis, up to the last matched pair of crossings.
   * Closed surfaces are not affected. Default `winding`.
   */
  open?: 'winding' | 'vote' | 'error' | 'parity';
  /**
   * Which cells a geometry has besides those whose centres lie inside of it. `centre`: none. `conservative`: every cell whose closed box
   * the surface touches. `separating`: those that separate the two sides of the surface, so that no path from face neighbour to face
   * neighbour leads through it; a wall of any thickness has them. Default `centre`.
   */
  fill?: 'centre' | 'conservative' | 'separating';
  /** As for a geometry, for all. */
  split?: boolean;
  /** As for a geometry, for all. */
  invert?: boolean;
  /**
   * Closes openings narrower than this number of cells along x, y or z, at least 2, and no wider ones: background cells get `gap_flag` if
   * fewer than that many in a row lie between flagged cells. Dents and slits as narrow as that are filled, too.
   */
  close_gaps?: number;
  /** Flag of the cells that `close_gaps` adds, 1 to 255; by default one more than the greatest flag of a geometry. */
  gap_flag?: number;
  /** Looks for thin walls and for cells that two geometries claim; takes several times as long as a mesh on the CPU. */
  certify?: boolean;
  /** Leaves out the checks that are made of every mesh: whether shells have no cell, or another volume than their surface. */
  quick?: boolean;
  /** Walls of fewer cells are thin; default 2. */
  thin_cells?: number;
  /** Measures the links from cells of a fluid to surfaces: see `Mesh.links`. */
  links?: LinksJob;
  /** Axes along which the box continues with itself, so that links lead through its sides. Default none. */
  periodic?: ('x' | 'y' | 'z')[];
  /** Measures the fraction of each flag in the cells that surfaces cut: see `Mesh.fractions`. */
  fractions?: FractionsJob;
  /** Finds the flags at the points of a staggered (Yee) grid: see `Mesh.staggered`. Default false. */
  staggered?: boolean;
  /** Flags of perfect conductors on a staggered grid: all edges of their cells conduct, not only those within the surface. Default none. */
  conductors?: number[];
  /** Axis of the rays; the result does not depend on it. Default `auto`: the longest, the first of those less than an eighth shorter. */
  axis?: 'auto' | 'x' | 'y' | 'z';
  /**
   * Memory limit in bytes, or as text such as `2GB`; by default 3 GiB. A mesh that needs more fails with `memory`, unless its
   * columns can spill: see `MeshOptions.spill`.
   */
  max_memory?: number | string;
  /** Unit of the lengths in the files, such as `mm`; it is written to every output. */
  unit?: string;
  /** Name and substance of the cells of no geometry, flag 0. */
  background?: { name?: string; material?: Material };
}

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
  /** SHA-256 of its bytes, in hexadecimal; null for arrays, which are not hashed. */
  sha256: string | null;
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

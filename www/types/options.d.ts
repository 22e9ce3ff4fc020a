/** The job: what is meshed, and how. Made by `npm run options` of docs/job.schema.json. */
import type { GeometrySource, Numbers } from './job.js';
import type { Triple } from './result.js';

/** Properties of a substance, all optional, in SI units whatever the unit of lengths. */
export interface Material {
  /** Relative permittivity, positive. */
  eps_r?: number;
  /** Relative permeability, positive. */
  mu_r?: number;
  /** Electric conductivity in S/m, 0 or positive. */
  sigma?: number;
  /** Whether it is a perfect electric conductor: JSON has no infinite `sigma`. */
  pec?: boolean;
  /** Density in kg/m3, positive. */
  density?: number;
  /** Young's modulus in Pa, positive. */
  E?: number;
  /** Poisson's ratio, greater than -1 and less than 0.5. */
  nu?: number;
}

/** A surface, the name and flag of its cells, and its transform. */
export interface GeometryJob {
  /** The facets. */
  source: GeometrySource;
  /** Name of the file in reports; by default that of the File, or `geometry-1`, ... */
  file?: string;
  /** Takes only the solid of this name from an ASCII file of several. */
  solid?: string;
  /** Makes every solid of the file a geometry of its own, named like the solid, flags counting up. */
  split?: boolean;
  /** With `split` and `flag` every solid has this flag, in place of flags that count up. */
  same_flag?: boolean;
  /** Name in reports and outputs; by default the file's without its extension. */
  name?: string;
  /** Flag of its cells, 1 to 255; by default 1, 2, ... in the order of the job. */
  flag?: number;
  /**
   * Where geometries overlap, the higher priority wins; of equal ones a geometry that is closed or flat wins over one that is not, else the
   * later. Default `0`.
   */
  priority?: number;
  /**
   * How cells are decided where its surface is not closed, if not as the job says. `winding`: by the rays of three axes where they agree,
   * elsewhere by the generalised winding number. `vote`: by most of the three axes whose rays cross it an even number of times: for surfaces
   * that cannot be oriented. `error`: not at all: an error. `parity`: by the rays of one axis, up to the last matched pair of crossings of
   * each.
   */
  open?: 'winding' | 'vote' | 'error' | 'parity';
  /**
   * Which cells along its surface it has as well, if not as the job says. `centre`: No others. `conservative`: every cell whose box the
   * surface touches. `separating`: the cells that separate the two sides of the surface: no path from face neighbour to face neighbour leads
   * through it.
   */
  fill?: 'centre' | 'conservative' | 'separating';
  /** Only the cells along its surface, and none for being inside; by default the `separating` ones. */
  shell?: boolean;
  /** The cells outside of it instead of those inside: the fluid around a body, or within a wall that fills the rest of the domain. */
  invert?: boolean;
  /** With `graded`: largest size of a cell across it. */
  max_size?: number;
  /** With `graded`: fewest cells across it along every axis, at least 1. */
  min_cells?: number;
  /** With `graded`: whether it is metal, so that the lines nearest to its edges lie a third of a cell inside and two thirds outside. */
  metal?: boolean;
  /** What it is made of: passed on to every output, and not used otherwise. */
  material?: Material;
  /** Scales first: one factor, or one an axis. */
  scale?: number | Triple;
  /** Then rotates about x, y and z, in degrees. */
  rotate?: Triple;
  /** The point about which it rotates, where it is once scaled; by default the origin. */
  about?: Triple;
  /** Then moves, in the unit of the result. */
  translate?: Triple;
}

/** Lines that are generated: on every end of every geometry's box, close where geometries are small, far elsewhere. */
export interface GradedJob {
  /** Largest size of a cell on all axes or each. */
  max_size: number | Triple;
  /** Smallest size of a cell; by default a thousandth of the largest. Of ends that are closer to each other one is left off the lines. */
  min_size?: number;
  /** Largest ratio of neighbouring cells, 1.01 to 10; by default 1.3. */
  growth?: number;
  /** Cells added on both sides of every axis, of the size of the cell at that end, up to 1,024: for absorbing layers. */
  absorbing?: number | Triple;
}

/** Asks for the distances from cells of a fluid to surfaces along links. */
export interface LinksJob {
  /**
   * The directions. `D3Q7`: over the 6 faces. `D3Q15`: over faces and the 8 corners. `D3Q19`: over faces and the 12 edges. `D3Q27`: over
   * faces, edges and corners. Default `D3Q19`.
   */
  stencil?: 'D3Q7' | 'D3Q15' | 'D3Q19' | 'D3Q27';
  /** Flags of the fluid; by default 0, the background. */
  fluid?: readonly number[];
}

/** Asks for the fraction of each flag in the cells that surfaces cut. */
export interface FractionsJob {
  /**
   * How they are measured: by default exactly, or by rays where `rays` is given. `exact`: Exactly but for rounding, from the facets within
   * each cell. `rays`: by rays, of which `rays` says how many.
   */
  method?: 'exact' | 'rays';
  /**
   * Rays of a cell along each of two axes, of the method `rays`: 1, 2, 4, 8 or 16; by default 4. The fraction of a cell that one plane cuts is
   * off by less than 1 / rays.
   */
  rays?: number;
  /** Also measures which fraction of each face of these cells a flag has. */
  faces?: boolean;
  /** Also measures area, centre and normal of the surface of each geometry in each cell. */
  surfaces?: boolean;
  /** Also measures which fraction of each of the twelve edges of these cells a flag has: exact alone. */
  edges?: boolean;
  /** Also measures the centre of what a flag has of a cell, and, with `faces`, of each of its faces: exact alone. */
  centroids?: boolean;
}

/** Asks for the fractions of edges and faces that lie outside metal, for conformal solvers of Maxwell's equations. */
export interface ConformalJob {
  /** Flags that are metal, 0 for the background; by default those of perfect conductors (`pec = true`) and of geometries with `metal = true`. */
  metal?: readonly number[];
  /**
   * The least area of a face outside metal, as a part of the fraction of its longest edge, 0 to 1; by default 1/8. Faces beside it give what
   * it lacks. The larger, the longer the stable step; 0 leaves areas as they are.
   */
  stable?: number;
}

/** A substance whose permittivity depends on the direction. */
export interface AnisotropicJob {
  /** Its flag, 0 for the background. */
  flag: number;
  /** Relative permittivity: xx, yy, zz, yz, xz and xy of a symmetric, positive tensor. */
  eps_r: readonly [number, number, number, number, number, number];
}

/**
 * Asks for the permittivity that stands for the cell around each point of E on a staggered (Yee) grid. What substances have is in their
 * materials (`eps_r`).
 */
export interface TensorsJob {
  /** Substances whose permittivity depends on the direction, in place of `eps_r` of their materials. */
  anisotropic?: readonly AnisotropicJob[];
}

/** Asks for the signed distance of points to the nearest surface. */
export interface DistanceJob {
  /**
   * Where: "centres" of cells, or "nodes", the crossings of lines. `centres`: at the centres of cells. `nodes`: at the crossings of lines: one
   * more than cells along each axis. Default `centres`.
   */
  at?: 'centres' | 'nodes';
  /**
   * How far from surfaces distances are known, in cells (of the longest edge of any), above 0; or "all". By default 3. Beyond it they are its
   * width. Default `3`.
   */
  band?: number | 'all';
  /** Flags of the geometries whose surfaces count, as if there were no others; by default all. */
  flags?: readonly number[];
}

/**
 * Asks for the cells of one flag to be cut at its surface, for files of polyhedra and embedded boundaries. Only closed bodies have such cells,
 * and only whole boxes are cut.
 */
export interface CutCellsJob {
  /** The flag, 0 for what is around all geometries; by default that of the geometries, which then have one. */
  fluid?: number;
  /** Also measures what the flag has of faces and edges, for embedded boundaries (`.eb`). */
  boundary?: boolean;
}

/** What is meshed and how: the native job file, with sources in place of file names. */
export interface Job {
  /** The geometries, in order: where two of equal priority overlap, one that is closed or flat wins over one that is not, else the later. */
  geometries: readonly GeometryJob[];
  /** Two corners of the box, x0 y0 z0 x1 y1 z1; by default the box around all geometries. Padding comes on top. */
  domain?: readonly [number, number, number, number, number, number];
  /** Space added on both sides of every axis, to `domain` or to the box around the geometries: whole cells, or a length. */
  padding?: { readonly cells: number | Triple } | { readonly length: number | Triple };
  /**
   * Cubic cells, so many along the longest axis; 128 where no size is given. At most one of `cells`, `dims`, `cell_size`, `max_cell_size`,
   * `lines` and `graded` is given.
   */
  cells?: number;
  /** Exactly so many cells on x, y and z, over the domain; padding by cells comes on top. */
  dims?: Triple;
  /** Cell size on all axes or each. */
  cell_size?: number | Triple;
  /** Upper limit of the cell size: the largest size per axis, at most this, that puts every end point of every bounding box on a mesh line. */
  max_cell_size?: number;
  /** Largest distance of an end point from its mesh line, in cells, with `max_cell_size`: 0 to 0.5, by default 0.05. */
  tolerance?: number;
  /** All lines of each axis, ascending, in the unit of the files: cells + 1 numbers each, at most 262,143. The first and the last are the domain. */
  lines?: { readonly x: Numbers; readonly y: Numbers; readonly z: Numbers };
  /** Generates lines of cells that differ in size: one on every end of every geometry's box, close where geometries are small, far elsewhere. */
  graded?: GradedJob;
  /**
   * Most cells, however they are chosen; without it only those of an axis are limited. A mesh of more is refused before it starts. A mesh of
   * more fails with `too-many-cells`.
   */
  max_cells?: number;
  /**
   * Meshes only some cells of the box, i0 j0 k0 i1 j1 k1: the first on each axis, and the end, exclusive. Lines, flags and all else are those
   * of the whole box.
   */
  window?: readonly [number, number, number, number, number, number];
  /** Meshes only one of the windows that the box is divided into: `index` from 1 on, x fastest, `of` so many along x, y and z. */
  part?: { readonly index: number; readonly of: Triple };
  /** Cells around the window or the part that are also meshed, on both sides of every axis. */
  halo?: number;
  /**
   * What the halo has beyond the box: background, the default, or the flag of the nearest cell of the box. `background`: background. `clamp`:
   * the flag of the nearest cell of the box.
   */
  halo_edge?: 'background' | 'clamp';
  /**
   * Shapes of the chunks and shards of a Zarr store, as cells on x, y, z, or most bytes of a shard. Where it is given, parts are cut along the
   * borders of shards.
   */
  zarr?: {
    readonly chunks?: Triple;
    readonly shards?: Triple;
    readonly shard_bytes?: number | string;
    readonly levels?: 'any' | 'majority';
    readonly sparse?: boolean;
  };
  /**
   * What is inside a surface. `parity`: inside is where a ray has crossed the surface an odd number of times. Facet orientation does not
   * matter. `nonzero`: inside is where the winding number is not zero. Overlapping shells unite; orientation matters. Default `parity`.
   */
  rule?: 'parity' | 'nonzero';
  /**
   * How cells are decided where a surface is not closed; a geometry may say otherwise. `winding`: by the rays of three axes where they agree,
   * elsewhere by the generalised winding number. `vote`: by most of the three axes whose rays cross it an even number of times: for surfaces
   * that cannot be oriented. `error`: not at all: an error. `parity`: by the rays of one axis, up to the last matched pair of crossings of
   * each. Default `winding`.
   */
  open?: 'winding' | 'vote' | 'error' | 'parity';
  /**
   * Which cells geometries have besides those whose centres lie inside; a geometry may say otherwise. `centre`: No others. `conservative`:
   * every cell whose box the surface touches. `separating`: the cells that separate the two sides of the surface: no path from face neighbour
   * to face neighbour leads through it. Default `centre`.
   */
  fill?: 'centre' | 'conservative' | 'separating';
  /** Makes every solid (part, node, item) of every file a geometry of its own. */
  split?: boolean;
  /** Gives every geometry the cells outside of it in place of those inside, such as the fluid around a body. */
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
  /** With `certify`: walls of fewer cells are thin, at least 1; by default 2. */
  thin_cells?: number;
  /** Measures the links from cells of a fluid to surfaces. See `Mesh.links`. */
  links?: LinksJob;
  /** Axes along which the box continues with itself, so that links lead through its sides. */
  periodic?: readonly ('x' | 'y' | 'z')[];
  /** Measures the fraction of each flag in the cells that surfaces cut. See `Mesh.fractions`. */
  fractions?: FractionsJob;
  /** Finds the flags at the points of a staggered (Yee) grid. See `Mesh.staggered`. */
  staggered?: boolean;
  /** Flags of perfect conductors on a staggered grid: all edges of their cells conduct, not only those within the surface. */
  conductors?: readonly number[];
  /** Measures the fractions of edges and faces that lie outside metal. See `Mesh.conformal`. */
  conformal?: ConformalJob;
  /** Measures the signed distance of centres or nodes to the nearest surface. See `Mesh.distance`. */
  distance?: DistanceJob;
  /** Averages the permittivity in the cell around each point of E, as tensors. See `Mesh.tensors`. */
  tensors?: TensorsJob;
  /** Cuts the cells of one flag at its surface, for files that hold cut cells. Files of `foam` then have cut cells; `eb` needs `boundary`. */
  cut_cells?: CutCellsJob;
  /**
   * Along which axis the rays run; the cells do not depend on it. `auto`: the axis with most cells; those with less than an eighth fewer count
   * as equal, and of equals the first is taken. `x`: along x. `y`: along y. `z`: along z. Default `auto`.
   */
  axis?: 'auto' | 'x' | 'y' | 'z';
  /**
   * Most bytes of memory to take, as a number or as text such as "2GB"; what does not fit is refused before it starts, unless its columns may
   * spill to disk. By default 3 GiB. A mesh that needs more fails with `memory`, unless its columns can spill: see `MeshOptions.spill`.
   */
  max_memory?: number | string;
  /** Unit of the files' lengths, such as "mm"; repeated in every output. */
  unit?: string;
  /** Name and substance of the cells of no geometry, flag 0. */
  background?: { readonly name?: string; readonly material?: Material };
}

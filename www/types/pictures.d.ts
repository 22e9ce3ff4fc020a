/** Pictures of a mesh, and what differs between two. */
import type { Mesh } from './result.js';

/** How a picture looks. */
export interface LookOptions {
  /**
   * Pixels: in slices of the longest side of the mesh (default 600), in a view of the longer side (default 1000). A picture, with its
   * legend, has at most 32,768 on a side.
   */
  size?: number;
  /** Flags, 0 to 255, that are shown; by default all. Slices leave the cells of others white, and say which. */
  flags?: readonly number[];
  /** Colours of flags as `#rrggbb`, in place of those that they have by themselves. */
  colours?: { readonly [flag: number]: string };
  /** Most bytes of memory for what is drawn, besides what the mesh takes; by default 1 GiB. */
  max_memory?: number;
  signal?: AbortSignal;
}

type Axis = 'x' | 'y' | 'z';

/** Slices: each place along each axis, side by side, in one scale. */
export interface SliceOptions extends LookOptions {
  /** Axes across the slices; by default all three. */
  axis?: Axis | readonly Axis[];
  /**
   * Places along each axis, in the unit of the mesh, or in percent of its length, such as `'25%'`; by default the middle. Of two planes of
   * cells that one lies between, the upper one is drawn.
   */
  at?: number | string | readonly (number | string)[];
  /** Whether lines between cells are drawn, where cells have 6 pixels or more. Default true. */
  lines?: boolean;
}

export interface ViewOptions extends LookOptions {
  /** Direction to the eye in degrees: around z from the x axis, and up from the plane of x and y. Default -60, 25. */
  direction?: readonly [number, number];
  /** Cells that are shown: the first and the end; by default all. */
  window?: readonly [number, number, number, number, number, number];
}

/** Cells that have one flag in this mesh and another in the other. */
export interface FlagPair {
  /** The flag in this mesh. */
  one: number;
  /** The flag in the other. */
  other: number;
  /** Number of cells. */
  cells: number;
  /** The first of them along the rays of this mesh. */
  first: [number, number, number];
  /** The box around them: the first cell on each axis, and the end. */
  bounds: [[number, number, number], [number, number, number]];
}

/** What differs between two meshes, as the native `hexcast diff --json` prints it, and the mask. */
export interface Difference {
  /** Number of cells that differ. */
  cells: number;
  /** Number of all cells. */
  n_cells: number;
  /** Whether the lines are the same; where they are not, cells are compared by their indices. */
  are_lines_equal: boolean;
  /** The pairs of flags, most cells first; of equal ones ascending. */
  pairs: FlagPair[];
  /** The lines of this mesh, and flag 1 where the two differ. Dispose of it when it is no longer needed. */
  mask: Mesh;
}

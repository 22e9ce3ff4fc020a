/** What is measured beside the cells, where the job asks for it: links to surfaces, fractions of cells, staggered grids. */
import type { Bytes, Float32Numbers, Uint32Numbers } from './result.js';

/** Arrays over an `ArrayBuffer` of their own, in every version of TypeScript. */
export type Float64Numbers = ReturnType<Float64ArrayConstructor['of']>;
export type Int8Numbers = ReturnType<Int8ArrayConstructor['of']>;
export type Int16Numbers = ReturnType<Int16ArrayConstructor['of']>;
export type Int32Numbers = ReturnType<Int32ArrayConstructor['of']>;

/** Links from cells of a fluid to surfaces: an entry for each link, in the order of cells, x fastest, then of directions. */
export interface Links {
  /** Cells of the mesh on x, y, z. */
  dims: Uint32Numbers;
  /** The first cell of the mesh, counted in the box: 0, 0, 0 but for windows and parts; below 0 where a halo begins beyond the box. */
  origin: Int32Numbers;
  /** Steps x, y, z in cells, three numbers a direction. The first is 0, 0, 0; direction 2 k is the opposite of 2 k - 1. */
  directions: Int8Numbers;
  /** Flags of the fluid. */
  fluid: Bytes;
  /** The cell of the fluid. */
  x: Uint32Numbers;
  y: Uint32Numbers;
  z: Uint32Numbers;
  /** The direction, as an index of `directions`. */
  direction: Bytes;
  /** Fraction of the link up to the surface: more than 0, at most 1. */
  q: Float32Numbers;
  /** The facet, counted from 0 in its geometry; -1 where no facet crosses the link. */
  facet: Int32Numbers;
  /** The geometry of the facet, counted from 0 in the job; -1 where no facet crosses the link. */
  geometry: Int16Numbers;
  /** Flag of the cell at the other end. */
  flag: Bytes;
}

/**
 * Fractions of the cells that are cut: an entry for each flag of each cell, in the order of cells, then of flags. With faces also those of cells with a face that is not
 * of their flag alone.
 */
export interface Fractions {
  /** Cells of the mesh on x, y, z. */
  dims: Uint32Numbers;
  /** The first cell of the mesh, counted in the box: 0, 0, 0 but for windows and parts; below 0 where a halo begins beyond the box. */
  origin: Int32Numbers;
  /** Index of the cell: x + nx (y + ny z). Whole numbers. */
  cell: Float64Numbers;
  flag: Bytes;
  /** The fraction of the cell that the flag has: 1 where no ray meets what cuts the cell, 0 for flags that only a face has. */
  fraction: Float32Numbers;
  /** With `faces`, six numbers an entry: the fraction of the faces below and above along x, then y, then z, 0 to 1. */
  faces?: Float32Numbers;
  /** With `edges`, twelve numbers an entry: the fraction of the edges along x, then y, then z, 0 to 1; `docs/fractions.md` has their order. */
  edges?: Float32Numbers;
  /** With `centroids`, three numbers an entry: the centre of what the flag has of the cell, in cells from its low corner. */
  centroid?: Float32Numbers;
  /** With `faces` and `centroids`, twelve numbers an entry: the same of the six faces, along the two axes of each. */
  face_centroid?: Float32Numbers;
  /** With `surfaces`, an entry for each geometry in each cell, in the order of cells, then of priorities: index of the cell. */
  surface_cell?: Float64Numbers;
  /** The geometry, counted from 0 in the job. */
  surface_geometry?: Int16Numbers;
  /** Area in the cell, in squares of the unit of length. */
  surface_area?: Float32Numbers;
  /** Its centre, in cells from the low corner of the cell, three numbers from 0 to 1 an entry. */
  surface_point?: Float32Numbers;
  /** Its normal, three numbers an entry: of length 1, out of the body; 0 where walls that face each other cancel. */
  surface_normal?: Float32Numbers;
}

/** Flags at the points of a staggered grid of nx x ny x nz cells, x fastest, and the faces of sheets, in the order of their axes, then x fastest. */
export interface Staggered {
  /** At the middle of edges along x: nx, ny + 1, nz + 1 points on x, y, z. */
  Ex: Bytes;
  /** Along y: nx + 1, ny, nz + 1 points. */
  Ey: Bytes;
  /** Along z: nx + 1, ny + 1, nz points. */
  Ez: Bytes;
  /** At the middle of faces across x: nx + 1, ny, nz points. */
  Hx: Bytes;
  /** Across y: nx, ny + 1, nz points. */
  Hy: Bytes;
  /** Across z: nx, ny, nz + 1 points. */
  Hz: Bytes;
  /** Flags of the cells: nx, ny, nz. */
  cell: Bytes;
  /** The cell of the first points, counted in the box: 0, 0, 0 but for windows and parts. */
  origin: Int32Numbers;
  /** Lines of each axis, cells + 1 numbers, in the unit of the files. */
  x: Float64Numbers;
  y: Float64Numbers;
  z: Float64Numbers;
  /** Of each face of a sheet the axis across it: 0, 1 or 2. */
  sheet_axis: Bytes;
  /** Its place on x, y and z: a line along its axis, a cell along the others. */
  sheet_x: Uint32Numbers;
  sheet_y: Uint32Numbers;
  sheet_z: Uint32Numbers;
  sheet_flag: Bytes;
}

/** Fractions of edges and faces outside metal, 0 to 1, on a grid of nx x ny x nz cells, x fastest. */
export interface Conformal {
  /** Of edges along x: nx, ny + 1, nz + 1 of them on x, y, z. */
  Lx: Float64Numbers;
  /** Along y: nx + 1, ny, nz + 1. */
  Ly: Float64Numbers;
  /** Along z: nx + 1, ny + 1, nz. */
  Lz: Float64Numbers;
  /** Of faces across x: nx + 1, ny, nz of them. */
  Ax: Float64Numbers;
  /** Across y: nx, ny + 1, nz. */
  Ay: Float64Numbers;
  /** Across z: nx, ny, nz + 1. */
  Az: Float64Numbers;
  /** Lines of each axis, cells + 1 numbers, in the unit of the files. */
  x: Float64Numbers;
  y: Float64Numbers;
  z: Float64Numbers;
  /** The cell of the first edges and faces, counted in the box: 0, 0, 0 but for windows and parts. */
  origin: Int32Numbers;
  /** One number: the longest stable step, as a part of that of the same lines without metal. */
  dt_factor: Float64Numbers;
}

/** Relative permittivity at the points of E of a staggered grid of nx x ny x nz cells: xx, yy, zz, yz, xz, xy of each point, x fastest. */
export interface Tensors {
  /** nx, ny + 1, nz + 1 points on x, y, z. */
  Ex: Float64Numbers;
  /** nx + 1, ny, nz + 1. */
  Ey: Float64Numbers;
  /** nx + 1, ny + 1, nz. */
  Ez: Float64Numbers;
  /** Lines of each axis, cells + 1 numbers, in the unit of the files. */
  x: Float64Numbers;
  y: Float64Numbers;
  z: Float64Numbers;
  /** The cell of the first points, counted in the box: 0, 0, 0 but for windows and parts. */
  origin: Int32Numbers;
}

/** Links from cells of the fluid to surfaces, counted. */
export interface LinksReport {
  stencil: 'D3Q7' | 'D3Q15' | 'D3Q19' | 'D3Q27';
  /** Flags of the fluid. */
  fluid: number[];
  /** Number of links. */
  links: number;
  /** Cells of the fluid with at least one of them. */
  cells: number;
  /** Links whose other end is in the fluid, too: the wall between is thinner than the link. */
  through_walls: number;
  /** Links that no facet crosses, as the flag at their other end is not decided by rays: q is 1/2. */
  without_facet: number;
}

/** Cells that surfaces cut, counted, and the volumes of flags that follow. */
export interface FractionsReport {
  /** Rays of a cell along each of two axes; 0 where cells are measured exactly. */
  rays: number;
  /** Cells that are cut: those with more than one flag, and those that a surface passes through where no ray meets it. */
  cut_cells: number;
  /** Cells that 16 x 16 rays measure where the others are exact, as a surface passes through itself there. */
  sampled_cells: number;
  /** Volume of each flag that has any, ascending; 0 is the background. */
  volumes: { flag: number; volume: number }[];
  /** Area of the surface of each geometry in the box, in the order of the job; null unless surfaces are asked for. */
  areas: number[] | null;
}

/** The points of a staggered grid, counted. */
export interface StaggeredReport {
  /** The components Ex, Ey, Ez, Hx, Hy and Hz: number of points on x, y and z, and of each flag that has any, ascending. */
  components: { name: string; dims: [number, number, number]; flags: { flag: number; points: number }[] }[];
  /** Number of faces that are sheets. */
  sheet_faces: number;
}

/** Signed distances of nx x ny x nz cells, or nodes, one more along each axis. */
export interface Distances {
  /** Distance to the nearest surface, x fastest, in the unit of the files: negative inside. */
  distance: Float64Numbers;
  /** Lines of each axis, cells + 1 numbers, in the unit of the files. */
  x: Float64Numbers;
  y: Float64Numbers;
  z: Float64Numbers;
  /** The cell of the first number, counted in the box: 0, 0, 0 but for windows and parts. */
  origin: Int32Numbers;
  /** One number: the largest distance that is known, infinite where all are. */
  width: Float64Numbers;
}

/** Edges and faces outside metal, counted. */
export interface ConformalReport {
  /** Edges of which a part lies in metal. Those on the last line of a window or part are counted by the one behind it. */
  cut_edges: number;
  /** Faces of which a part lies in metal. */
  cut_faces: number;
  /** Faces that are larger than what lies outside metal, so that the step stays long. */
  enlarged_faces: number;
  /** Those of which the faces beside them did not have all that they lacked. */
  unbalanced_faces: number;
  /** Cells whose faces rays measure, as a surface passes through itself there. */
  sampled_cells: number;
  /** The longest stable step, as a part of `dx / (c sqrt(3))` or what that is for the smallest cells. */
  dt_factor: number;
  /** This step in seconds, in vacuum; null where no unit of length is known. */
  dt: number | null;
}

/** Points at which permittivity was smoothed, counted. */
export interface TensorsReport {
  /** Points of Ex, Ey and Ez around which lies more than one permittivity. Those on the last line of a window or part are counted by the one behind it. */
  cut_points: number;
  /** Those at which surfaces cancel, so that no normal is known: they have the mean. */
  without_normal: number;
  /** Points around which rays measure, as a surface passes through itself there. */
  sampled_points: number;
}

/** What one size of cells gives. */
export interface Level {
  /** Cells along each axis. */
  dims: [number, number, number];
  /** Size of a cell along each axis. */
  spacing: [number, number, number];
  /** From the surfaces in memory to the mesh. */
  seconds: number;
  /** Bytes of the mesh as a column file (hxc). */
  column_bytes: number;
  /** Bytes of its flags, one a cell. */
  flag_bytes: number;
  /** Each flag of the job, ascending. */
  flags: {
    flag: number;
    /** Names of its geometries, joined by " + ". */
    name: string;
    cells: number;
    /** Volume of these cells. */
    volume: number;
    /** That of the surfaces; null where they enclose none (open, cut by the domain), or cells are not those whose centres lie inside. */
    mesh_volume: number | null;
    /** `volume` is so many times `mesh_volume`, less 1; null without that. */
    volume_error: number | null;
    /** Area of the faces across x, y and z between cells of the flag and others, and at the sides of the box. */
    areas: [number, number, number];
    /** Areas of the facets projected on planes across x, y and z. */
    mesh_areas: [number, number, number];
    /** The sum of `areas` is so many times that of `mesh_areas`, less 1; null where `mesh_volume` is. */
    area_error: number | null;
  }[];
}

/** Signed distances. */
export interface DistanceReport {
  /** Facets whose distances count. */
  facets: number;
  /** Largest distance that is known, in the unit of the files; null where all are. */
  width: number | null;
}

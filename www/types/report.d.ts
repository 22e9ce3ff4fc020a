/** What a mesh says about itself: its report, as the native command writes it. */
import type {
  ConformalReport,
  DistanceReport,
  FractionsReport,
  LinksReport,
  StaggeredReport,
  TensorsReport,
} from './measured.js';

/** The cells of a flag. */
export interface FlagReport {
  flag: number;
  name: string;
  cells: number;
  volume: number;
  /**
   * Sum of the volumes that its geometries' surfaces enclose; null where one is open, a shell, inverted or cut by the domain, and for a
   * mesh that was opened from a column file.
   */
  mesh_volume: number | null;
  /**
   * The most by which `volume` can differ from `mesh_volume` where neither geometries nor shells of one overlap; null where
   * `mesh_volume` is, where cells differ in size, and where a geometry is filled.
   */
  volume_bound: number | null;
}

/** Which cells of a larger box were meshed. */
export interface WindowReport {
  /** The first cell, without the halo. */
  first: [number, number, number];
  /** The end, exclusive, without the halo. */
  end: [number, number, number];
  /** Number of cells of the box. */
  of: [number, number, number];
  /** First corner of the box. */
  origin: [number, number, number];
  /** Cells beyond these on both sides of every axis, which all counts of the report include. */
  halo: number;
  /** What these cells add to the sum that `flags_hash` is made of; null with a halo. */
  flags_sum: string | null;
  /** Volumes and areas before they are rounded: whole numbers in hexadecimal digits, which add up to those of the box. */
  sums: {
    /** Of `flags[].volume`; empty among equal cells. */
    volumes: { flag: number; sum: string }[];
    /** Of `fractions.volumes`. */
    fractions: { flag: number; sum: string }[];
    /** Of `fractions.areas`. */
    areas: string[];
    /** Of the volumes of `certificate.overlaps`. */
    overlaps: string[];
  };
  /** `volume_bound` of each geometry in the whole box; null unless these cells are a `part`. */
  volume_bounds: (number | null)[] | null;
  /** Runs of the whole box that begin in these cells; null unless these are a `part` without halo, or no ray is cut before them. */
  runs: number | null;
  /**
   * The points of a staggered grid as in `staggered`, but of those on its last line along an axis only where that is the last of the box; null unless asked for.
   */
  staggered: StaggeredReport | null;
  /** Geometries, by their index in `geometries`, with cells in two or more of their shells here, on the rays of the box that are looked at. */
  shells: { geometry: number; cells: number }[];
  /**
   * Geometries, by their index in `geometries`, that have no cell here, and what to say if they have none in the box; null unless these cells
   * are a `part` without halo.
   */
  without_cells: { geometry: number; finding: Finding | null; warning: string | null }[] | null;
  /** The report without the halo, which `hexcast merge` takes; null where the part has no halo, and where its columns do not fit in memory. */
  without_halo: object | null;
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
  /** Why the CPU meshed although a GPU was looked for: there is none, it is one in software, or it failed; null otherwise, and for an opened mesh. */
  fallback: string | null;
  /**
   * The CPU casts a sample of the GPU's rays again: the number of these rays, and of those among them whose cells differed;
   * null if no GPU meshed.
   */
  device_check: { rays: number; differing: number } | null;
  unit: string | null;
  dims: [number, number, number];
  /** Which cells of a larger box these are; null where they are all, and for an opened mesh. */
  window: WindowReport | null;
  origin: [number, number, number];
  /** Cell size on x, y, z; null where cells differ in size. */
  spacing: [number, number, number] | null;
  /** The lines and how their distances change; null where all cells are equal. */
  grading: Grading | null;
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
  /** Cells that the winding number or a vote decided, as rays could not; null for an opened mesh. */
  doubtful: DoubtReport | null;
  /**
   * The job with all that it left open filled in, in the form of job files: `file` in place of `source`; null for an opened mesh.
   */
  job: { geometries: { file: string; flag: number; [key: string]: unknown }[]; [key: string]: unknown } | null;
  /** Thin walls, overlaps and gaps of one cell; null where the job did not ask for them, and for an opened mesh. */
  certificate: CertificateReport | null;
  /** Links from cells of a fluid to surfaces; null where the job did not ask for them, and for an opened mesh. */
  links: LinksReport | null;
  /** Cells that surfaces cut; null as `links`. */
  fractions: FractionsReport | null;
  /** Points of a staggered grid; null as `links`. */
  staggered: StaggeredReport | null;
  /** Edges and faces outside metal; null as `links`. */
  conformal: ConformalReport | null;
  /** Signed distances; null as `links`. */
  distance: DistanceReport | null;
  /** Points at which permittivity was smoothed; null as `links`. */
  tensors: TensorsReport | null;
  /** Hash of the flags, the same on every device and along every axis; null for an opened mesh and where the columns have spilled. */
  flags_hash: string | null;
  /** SHA-256 of the flags; null, as `Mesh.sha256` makes it where it is needed. */
  flags_sha256: string | null;
  /** What the reader should know, as data; empty for an opened mesh. */
  findings: Finding[];
  /** The sentences of `findings`. */
  warnings: string[];
  /** Cells per second of `seconds.total`; null for an opened mesh. */
  cells_per_second: number | null;
  /** Seconds of each stage, null for a stage that was not asked for; empty for an opened mesh. */
  seconds: Record<string, number | null>;
  /** Missing for an opened mesh. */
  peak_bytes?: PeakBytes;
  [key: string]: unknown;
}

/** What a finding is; `docs/findings.md` explains each. */
export type FindingCode =
  | 'gpu-failed'
  | 'file-changed'
  | 'end-without-line'
  | 'edge-on-line'
  | 'unit-differs'
  | 'fluid-without-geometry'
  | 'conductor-thin'
  | 'cells-fine'
  | 'surface-open'
  | 'rays-odd'
  | 'surface-open-parity'
  | 'surface-inside-out'
  | 'flag-shared'
  | 'shells-overlap'
  | 'shell-lost'
  | 'volume-off'
  | 'volume-filled'
  | 'wall-thin'
  | 'gap-narrow'
  | 'no-cell-outside'
  | 'no-cell-no-area'
  | 'no-cell-thin'
  | 'no-cell-flat'
  | 'no-cell-open'
  | 'no-cell-small'
  | 'no-cell-covered'
  | 'plate-covered';

/** A geometry by its index in `geometries` of the report, from 0, and its name. */
export interface NamedGeometry {
  index: number;
  name: string;
}

/** What helps against what was found. */
export interface Remedy {
  /** What it does, in some words, as on a button. */
  label: string;
  /**
   * What to change in the job that was given, in the keys of job files. An object changes the keys that it has, and null removes one; what is
   * no object replaces the value. In `geometries` the keys are indices of the job's entries, from 0.
   */
  patch: { [key: string]: unknown };
  /** What does the same on the command line: an option, or a file with settings in place of that file; null where nothing does. */
  option: string | null;
}

/** Something that the reader of a report should know. Places are in world coordinates. */
export interface Finding {
  code: FindingCode;
  /** All of it in words. */
  sentence: string;
  /** The geometry that it is about; null where it is about none, or about several. */
  geometry: NamedGeometry | null;
  /** A second geometry that it is about, such as the one that has the cells of the first. */
  other: NamedGeometry | null;
  /** Number of the shell of the geometry, from 0; null where it is about all of it. */
  shell: number | null;
  /** The flag whose cells it is about. */
  flag: number | null;
  axis: 'x' | 'y' | 'z' | null;
  /** Points where it is; the most telling first. */
  points: [number, number, number][];
  /** Boxes where it is, by their least and greatest corners. */
  boxes: [[number, number, number], [number, number, number]][];
  /** Its numbers by name. */
  values: { [name: string]: number };
  /** What helps; the best first. */
  remedies: Remedy[];
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
  /** Whether its facets enclose a volume that its cells should have, filled or not: closed, in agreement, neither a shell nor inverted. */
  has_volume: boolean;
  /** What its shells have in cells; null where all cells along its surface are its own (fill `conservative`), and with `quick`. */
  shells: ShellCheck | null;
  /** Whether its cells are those outside of it. */
  invert: boolean;
  /** Edges that are not shared by two facets that agree, after the corners were rounded. */
  bad_edges: BadEdges;
}

/** What was found of the shells of a geometry, each alone: what other geometries win is not looked at. */
export interface ShellCheck {
  /** Number of its shells: groups of facets connected over shared edges. */
  shells: number;
  /** Those of them that have no cell. */
  without_cells: number;
  /** Those that have cells, the volume of which differs by more than 5 % from that of the shell. */
  off: number;
  /** Shells without cells, then those whose volume is off, at most 20 of each kind, the largest first; of a `part` at most 1,000. */
  listed: ShellReport[];
  /**
   * Volume of the cells of all its shells together; null where no shell is listed and it is off by less than 5 %, and where there is nothing
   * to compare with.
   */
  volume: number | null;
  /** How many times as many cells along each axis, of equal ones, would give every listed shell a cell; null where that is not known. */
  cells_factor: number | null;
}

/** A shell that the cells do not keep. */
export interface ShellReport {
  /** Its number, from 0, in the order of their first facets. */
  shell: number;
  /** Least and greatest coordinates. */
  bounding_box: [[number, number, number], [number, number, number]];
  /** The volume that it encloses: less than 0 of a cavity. */
  mesh_volume: number;
  /** Number of its cells, counted as often as it winds around them; less than 0 of a cavity. */
  cells: number;
  /** Volume of these cells. */
  volume: number;
  /** Whether it has no cell. */
  is_lost: boolean;
  /** Whether lines through centres cross it, so that `fill: 'separating'` keeps it; false where it is not lost. */
  is_crossed: boolean;
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
  /** Holes of three edges: the facet that was missing there was added. */
  added_facets: number;
  /** Middle of the longest of these edges. */
  longest_at: [number, number, number];
  /** Facets that were turned to agree with their neighbours. */
  turned: number;
  /** Rays along x, y and z that do not leave it as often as they enter. */
  odd_rays: [number, number, number];
  /** Cells whose three rays are not all even, or do not agree. */
  doubtful_cells: number;
  /** Index of the geometry in `geometries`, from 0. */
  index: number;
}

/** A geometry that has the cells along its surface. */
export interface FillReport {
  geometry: string;
  /** Its index in `geometries`, from 0. */
  index: number;
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
  /** Walls that are thin along an axis: ray segments in them, those without a centre of a cell, the fewest centres and a place. */
  thin_walls: {
    geometry: string;
    axis: 'x' | 'y' | 'z';
    rays: number;
    lost: number;
    cells: number;
    place: [number, number, number];
    /** Index of the geometry in `geometries`. */
    index: number;
  }[];
  /**
   * Pairs of geometries with common cells, a place in them, the cells of the longest stretch of a ray in both, 0 in a window in which none
   * begins, and the indices of winner and loser in `geometries`.
   */
  overlaps: {
    winner: string;
    loser: string;
    cells: number;
    volume: number;
    place: [number, number, number];
    longest: number;
    indices: [number, number];
  }[];
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

/** Lines that are not equally spaced. Lengths are in the unit of the files. */
export interface Grading {
  /** All lines along x, ascending: cells + 1 of them. */
  x: number[];
  y: number[];
  z: number[];
  /** Sizes of the smallest and the largest cell on x, y, z. */
  smallest: [number, number, number];
  largest: [number, number, number];
  /** The greatest ratio of the sizes of two neighbours, at least 1. */
  ratio: [number, number, number];
  /** The longest step of a solver of the wave equation by central differences, as the length that light goes in it. */
  courant_length: number;
  /** The same in seconds, in vacuum; null where the unit of lengths is not known. */
  courant_seconds: number | null;
}

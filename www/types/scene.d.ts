/** Jobs whose geometries move: of their meshes only what changed is made again. */
import type { CallOptions, MeshOptions } from '../hexcast.js';
import type { Job } from './options.js';
import type { Finding } from './report.js';
import type { Bytes, Mesh, Uint32Numbers } from './result.js';

/** The columns of a scene stay in memory. */
export type SceneOptions = CallOptions & Pick<MeshOptions, 'maxDeviceBytes'>;

/** Cells whose flags changed, as runs along rays: run r is the cells `starts[r]` to `ends[r]`, exclusive, of ray `rays[r]`. */
export interface ChangedRuns {
  /** Ray of each run, ascending: that through cell (i, j) of the two other axes is number `i + n_i * j`, as of {@link AllRuns}. */
  rays: Uint32Numbers;
  /** First cell of each. */
  starts: Uint32Numbers;
  /** The cell after the last. */
  ends: Uint32Numbers;
  /** The flag that these cells had. */
  before: Bytes;
  /** The flag that they have. */
  after: Bytes;
}

/** What an update did. */
export interface Update {
  /** The cells whose flags changed; null where all may have: the box has other lines or rays, or an update before this one failed. */
  changed: ChangedRuns | null;
  /**
   * Why the whole was meshed, null where some rays were enough. `box`: the lines are other ones, or the axis of the rays, the rule, the unit or
   * the precision. `surface`: rays of one axis do not decide a geometry: it is open, flat, inverted, a shell or has cells along its surface.
   * `asked`: the job asks for more than cells, such as links, for closed gaps, or for a window or part. `memory`: the crossings exceed
   * `max_memory`. Each may be that of the job before, too.
   */
  whole: 'box' | 'surface' | 'asked' | 'memory' | null;
  /** Rays whose runs were made again. */
  rays: number;
  /** What to know; where some rays were enough, geometries without cells and facts of the lines alone. */
  findings: Finding[];
}

/** A job, and its mesh, which follows the edits of the job: {@link Mesher.scene}. */
export interface Scene extends Disposable {
  /**
   * The mesh of the last update, which the next one disposes of. Where some rays were enough for that, its report has what the columns say, as that
   * of an opened column file.
   */
  readonly mesh: Mesh;
  /**
   * Gives the scene another job, and meshes what that changes: the same bytes as the whole mesh of that job. Surfaces that were read once, by
   * `Mesher.read`, are known by that; any other source is read again, and counts as changed. Give the job a `domain`: without one the box follows
   * the geometries, and every edit that moves its sides is a whole mesh. Updates and meshes wait for each other. After an error the mesh is as before.
   */
  update(job: Job, options?: CallOptions): Promise<Update>;
  /** Frees it and its mesh. */
  dispose(): void;
}

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
 * The work happens in a dedicated worker; with `worker: false`, with a `device` and in Node on the calling thread. Inputs are
 * never detached or changed; every typed array that a call returns belongs to the caller. Lengths are in the unit of the files,
 * cells are counted from 0, ends of ranges are exclusive, and x varies fastest: `flags[x + nx * (y + ny * z)]`.
 */
import type { Estimate, FileInfo, FileSource, Surface, SurfaceSource } from './types/job.js';
import type { Level } from './types/measured.js';
import type { Job } from './types/options.js';
import type { Format, FormatFacts, Mesh } from './types/result.js';
import type { Scene, SceneOptions } from './types/scene.js';
import './globals.js';

export type * from './types/formats.js';
export type * from './types/job.js';
export type * from './types/options.js';
export type * from './types/measured.js';
export type * from './types/pictures.js';
export type * from './types/report.js';
export type * from './types/result.js';
export type * from './types/scene.js';

/** Stable codes of {@link HexcastError}; the same as those of the native library. */
export type ErrorCode =
  | 'cancelled'
  | 'stl-empty'
  | 'stl-truncated'
  | 'stl-count'
  | 'stl-not-stl'
  | 'stl-syntax'
  | 'file-syntax'
  | 'stl-not-finite'
  /** A geometry is not closed, and its `open` is `error`. */
  | 'surface-open'
  | 'columns-corrupt'
  | 'columns-version'
  | 'job-syntax'
  | 'job-value'
  | 'output-name'
  | 'columns-other'
  | 'job-conflict'
  | 'job-empty'
  | 'domain-empty'
  | 'lines-no-common-size'
  | 'lines-wrong'
  | 'lines-no-sizes'
  | 'lines-graded'
  | 'lines-too-fine'
  | 'too-many-cells'
  | 'geometry-too-far'
  | 'too-many-facets'
  | 'too-many-geometries'
  /** A cut cell is not closed, which is an error of hexcast. */
  | 'cut-open'
  /** Edges and faces outside metal are asked for, and no flag is metal. */
  | 'no-metal'
  /** Smoothed permittivity is asked for, and what a geometry is made of has none. */
  | 'no-permittivity'
  /** In the command and other packages alone: nothing converts STEP and IGES. Here `readCad` of `hexcast/cad` does. */
  | 'cad-program'
  | 'too-many-crossings'
  | 'export-too-large'
  | 'export-unit'
  | 'export-material'
  | 'memory'
  | 'no-adapter'
  | 'device-failed'
  /** The GPU driver computes wrongly. Its results are discarded. */
  | 'device-wrong'
  | 'device-lost'
  | 'io'
  /** The mesher, the mesh or the surface was disposed of before the call. */
  | 'disposed'
  /** `onProgress` threw what `cause` has, which ended the call. */
  | 'callback';

/** Every failure but an abort, which rejects with `signal.reason`. `cause` is the error behind it, if there is one. */
export class HexcastError extends Error {
  /** What went wrong, for programs. */
  readonly code: ErrorCode;
  /** What to do about it, for people; may be empty. */
  readonly hint: string;
  /** What is known of the cause; empty where that is nothing. */
  readonly details: ErrorDetails;
}

/** Facts of an error, for programs. */
export interface ErrorDetails {
  /** The key of the job, the option or the argument that is wrong, such as `geometries[0].flag`. */
  readonly key?: string;
  /** What was found there, in few words, or its size. */
  readonly found?: string | number;
  /** What is allowed there, in few words, or its size. */
  readonly allowed?: string | number;
  /** Bytes that are too many. */
  readonly bytes?: number;
}

/**
 * The backend that meshes. `auto` takes the GPU where there is one, otherwise the CPU; an adapter in software, which computes on
 * the processor, is slower than the CPU backend and does not count.
 */
export type BackendChoice = 'auto' | 'gpu' | 'cpu';

/** Where a wasm module is, or its bytes, or the compiled module. */
export type WasmSource = string | URL | ArrayBufferLike | Uint8Array | WebAssembly.Module;

export interface MesherOptions {
  /** Default `auto`. With `gpu`, a missing adapter is the error `no-adapter`, and one lost for good `device-lost`. */
  backend?: BackendChoice;
  /**
   * Threads of what the processor does, 1 to 256; 1 for none but that of the mesher. By default as many as the processor has, at most 16, in
   * Node and in pages that are isolated from other origins (`crossOriginIsolated`), where workers may share memory; 1 elsewhere, and with
   * `wasm`, `worker` or `device`. The result is the same. More than 1 is the error `job-conflict` where there can be one only.
   */
  threads?: number;
  /** The wasm; by default `hexcast_bg.wasm` in the folder of this script. */
  wasm?: WasmSource;
  /**
   * Where the worker script is (another origin is fine), or a worker that runs `hexcast/worker` and nothing else, or a function that
   * starts one, or `false` to work on the calling thread. The mesher ends a worker that it was given. By default `worker.js` in the
   * folder of this script.
   */
  worker?: string | URL | Worker | (() => Worker) | false;
  /**
   * A `GPUDevice` of your own to mesh on. A device cannot leave its thread: the mesher works on the calling thread and starts no
   * worker. It never destroys the device, and leaves its `onuncapturederror` and error scopes alone. If the device is lost, also by
   * `device.destroy()`, the mesher opens one of its own or, with `auto`, falls back to the CPU. It continues with the band at
   * which it stopped; the result is the same.
   */
  device?: Device;
  /** Aborts the start. */
  signal?: AbortSignal;
}

/** The parts of a `GPUDevice` that the mesher uses: these types need no others. */
export interface Device {
  readonly features: object;
  readonly limits: object;
  readonly queue: object;
  readonly lost: Promise<unknown>;
  destroy(): void;
}

/** How far a call has come. */
export interface Progress {
  /** `read`: bytes of files; `check`, of edges, and `preview`: a share of 1; `mesh`: rays; `write`: bytes of flags. */
  stage: 'read' | 'check' | 'preview' | 'mesh' | 'write';
  /** Done so far, in the stage's unit. */
  done: number;
  /** All there is to do. */
  total: number;
}

export interface CallOptions {
  /**
   * Aborts the call: it rejects with `signal.reason` at once, and the mesher stays usable. The work itself stops within half a
   * second; the next call waits for that.
   */
  signal?: AbortSignal;
  /** Called from time to time, at most once a band. */
  onProgress?: (progress: Progress) => void;
}

export interface MeshOptions extends CallOptions {
  /**
   * Whether columns that outgrow `max_memory` spill to a temporary file in the browser's private file system (OPFS), as with the
   * command's `--spill`. The result is the same; the file is removed with the mesh. Default `auto`: where there is such a file
   * system, that is in workers of secure pages, not in Node. With `true` its absence is the error `io`.
   */
  spill?: 'auto' | boolean;
  /**
   * Most bytes of buffers that the GPU holds at once, at least 2^20; by default as many as it takes. The result is the same: bands become
   * as small as it asks, and what the GPU cannot do in so many bytes the CPU does. The CPU backend has no such buffers.
   */
  maxDeviceBytes?: number;
}

/** A GPU as the browser describes it; empty strings for what the browser withholds. */
export interface Adapter {
  /** To be shown: the description, or vendor and architecture. */
  name: string;
  vendor: string;
  architecture: string;
  description: string;
  driver: string;
  /** Whether it computes on the processor, such as SwiftShader or llvmpipe. */
  software: boolean;
}

export interface Mesher extends Disposable {
  /** The backend that meshes. With `auto` it changes to the CPU if the GPU is lost and no other can be opened. */
  readonly backend: 'gpu' | 'cpu';
  /** Threads of what the processor does; see {@link MesherOptions.threads}. */
  readonly threads: number;
  /** The GPU; null on the CPU. */
  readonly adapter: Adapter | null;
  /** Why `auto` meshes on the CPU: no GPU was found, it is one in software, or it was lost; null otherwise. */
  readonly fallback: string | null;
  /** Reads a surface and looks at its edges, without meshing it. */
  read(source: SurfaceSource, options?: CallOptions & { file?: string; check?: true }): Promise<Surface>;
  /** With `check: false` reads a surface only: it can be meshed before its edges are looked at, by {@link Surface.check}. */
  read(source: SurfaceSource, options: CallOptions & { file?: string; check: boolean }): Promise<Surface<FileInfo>>;
  /** Meshes a job. Calls wait for each other. */
  mesh(job: Job, options?: MeshOptions): Promise<Mesh>;
  /** Meshes a job whose geometries will move, and keeps what makes the next mesh fast. */
  scene(job: Job, options?: SceneOptions): Promise<Scene>;
  /** What a mesh would cost, without making it. */
  estimate(job: Job, options?: CallOptions): Promise<Estimate>;
  /**
   * Meshes a job with so many cells along the longest side of its box, for each of `sizes` (default 32, 64, 128, 256), and says how far volumes
   * and areas are from those of the surfaces, and what each size costs: what `hexcast converge --json` prints. Progress begins again with each
   * size. Fails with `job-conflict` where the job chooses its cells itself, or asks for a window or a part; as `mesh` otherwise.
   */
  converge(job: Job, options?: CallOptions & { sizes?: readonly number[] }): Promise<Level[]>;
  /**
   * Opens a column file. In a worker a Blob is not copied: the mesh reads pieces of it as they are needed, so that a file may be
   * larger than the memory. It must not change meanwhile. A damaged piece shows when it is read, as `columns-corrupt`.
   */
  open(file: FileSource, options?: CallOptions): Promise<Mesh>;
  /** Ends the worker and frees everything; pending calls reject with `cancelled`, later ones with `disposed`. */
  dispose(): void;
}

/** Starts a worker and opens its backend. */
export function createMesher(options?: MesherOptions): Promise<Mesher>;

/** What each format of files is and can hold, in the order of lists. */
export const formats: Readonly<Record<Format, FormatFacts>>;

/** Version of hexcast. */
export const version: string;

/**
 * The operations of the package, on the calling thread: the wasm, surfaces and meshes by number. `worker.js` runs them in a worker;
 * `hexcast.js` calls them there or, without a worker, directly. Arguments and results can be cloned.
 */
import { arraysOf } from './arrays.js';
import { Devices, describeAdapter, whyNotTaken } from './adapter.js';
import { clearSpillFiles, spilling } from '../platform/spill.js';
import { cancelled, pause } from '../protocol/call.js';
import { columnFile } from './column_file.js';
import { comparedIn, pictureIn, skinOf, sliceOf } from './pictures.js';
import { sha256 } from './hash.js';
import { HexcastError } from '../protocol/error.js';
import { factsOf, onRays } from './mesh_facts.js';
import { Held, freeAfter } from './held_objects.js';
import { NOT_FOUND } from '../platform/own_files.js';
import { Pace } from './pace.js';
import { readSurface } from './read_files.js';
import { allRuns, changedRuns } from './runs.js';
import { inSteps } from './steps.js';

/**
 * @typedef {Omit<typeof import('../hexcast_wasm.js'), 'default' | 'initSync'> & { default: Load, startThreads?: (n: number) => boolean }} Glue
 *   of a wasm: that with threads can start them
 * @typedef {(given: { module_or_path: any }) => Promise<{ memory: WebAssembly.Memory }>} Load
 * @typedef {import('../hexcast_wasm.js').WebMesh} WebMesh
 * @typedef {import('../protocol/call.js').State} State
 * @typedef {import('../protocol/call.js').Listener} Listener
 * @typedef {{ json: string, surfaces: number[] }} JobArguments a job, and its surfaces by number
 * @typedef {JobArguments & { readSeconds: number, spill: 'auto' | boolean, maxDeviceBytes?: number }} MeshArguments
 * @typedef {{ backend: 'gpu' | 'cpu', adapter: import('../hexcast.js').Adapter | null, fallback: string | null }} Facts of a backend
 * @typedef {Exclude<keyof Core, 'run' | 'cancel' | 'dispose'>} Operation
 */

export class Core {
  #glue;
  /** Set by `open`. @type {import('../hexcast_wasm.js').WebEngine} */
  #engine = /** @type {never} */ (null);
  /** @type {Devices | null} */
  #devices = null;
  #isDisposed = false;
  /** @type {Held<import('../hexcast_wasm.js').WebSurface>} */
  #surfaces = new Held();
  /** @type {Held<WebMesh>} */
  #meshes = new Held();
  /** @type {Held<import('../hexcast_wasm.js').WebScene>} */
  #scenes = new Held();
  /** @type {Held<import('../hexcast_wasm.js').WebEncoder>} */
  #encoders = new Held();
  /** @type {Map<number, State>} */
  #switches = new Map();
  /** Resolves when the mesh before has ended. @type {Promise<unknown>} */
  #turn = Promise.resolve();
  /** The browser's name of the GPU. */
  #adapterName = '';
  /** Why `auto` meshes on the CPU although there is an adapter. @type {string | null} */
  #notTaken = null;
  #pace = new Pace();

  /** @param {Glue} glue of the wasm */
  constructor(glue) {
    this.#glue = glue;
  }

  /**
   * Loads the wasm. Returns what threads run and share if it is that with threads.
   *
   * @param {{ wasm: any, hasThreads: boolean }} args
   */
  async load({ wasm, hasThreads }) {
    if (!hasThreads) {
      await load(this.#glue, wasm);
      return null;
    }
    const module = await compiled(wasm);
    const { memory } = await load(this.#glue, module);
    return { module, memory };
  }

  /** Hands each thread its part of the work; so many wait. @param {{ n: number }} args */
  async startThreads({ n }) {
    if (!this.#glue.startThreads?.(n)) throw new Error(`the pool of ${n} threads could not be started`);
  }

  /**
   * Opens a backend; `auto` does not take an adapter in software, unless its device is the caller's.
   *
   * @param {{ backend: import('../hexcast.js').BackendChoice, device?: GPUDevice, gpu?: GPU | null }} args
   * @returns {Promise<Facts & { version: string }>}
   */
  async open({ backend, device, gpu = globalThis.navigator?.gpu }) {
    // files that earlier visits left; not awaited
    clearSpillFiles();
    // where the search fails, so does that of the wasm, which reports it
    const adapter = backend === 'cpu' ? null : await describeAdapter(gpu, device).catch(() => null);
    if (backend === 'auto' && !device && adapter) this.#notTaken = whyNotTaken(adapter);
    this.#devices = new Devices(gpu, device);
    const found = this.#devices.whileFound(() => new this.#glue.WebGpu());
    this.#engine = await this.#glue.WebEngine.open(this.#notTaken ? 'cpu' : backend, found, pause);
    if (this.#isDisposed) this.#free();
    const facts = JSON.parse(this.#engine.facts());
    if (facts.adapter) {
      Object.assign(facts.adapter, adapter);
      this.#adapterName = facts.adapter.name;
    }
    return { ...facts, fallback: this.#notTaken ?? facts.fallback, version: this.#glue.version() };
  }

  /**
   * Calls an operation by name; `call` identifies it for `cancel`, `progress` receives its progress.
   *
   * @param {Operation} operation
   * @param {number} call
   * @param {object} args
   * @param {Listener} progress
   */
  async run(operation, call, args, progress) {
    const stop = new this.#glue.WebSwitch();
    const state = { stop, cancelled: false };
    this.#switches.set(call, state);
    try {
      const act = /** @type {(args: object, progress: Listener, state: State) => unknown} */ (
        /** @type {unknown} */ (this[operation])
      );
      return await act.call(this, args, progress, state);
    } finally {
      this.#switches.delete(call);
      stop.free();
    }
  }

  /** @param {number} call */
  cancel(call) {
    const state = this.#switches.get(call);
    if (state) {
      state.cancelled = true;
      state.stop.cancel();
    }
  }

  /** Ends all calls and frees all that was made. */
  dispose() {
    for (const call of this.#switches.keys()) this.cancel(call);
    for (const held of [this.#surfaces, this.#meshes, this.#encoders]) held.close();
    this.#isDisposed = true;
    // a mesh that is being made holds the engine, and an update its scene
    this.#turn.then(() => {
      this.#scenes.close();
      this.#free();
    });
  }

  #free() {
    if (!this.#engine) return;
    this.#engine.free();
    this.#devices?.destroy();
  }

  /**
   * @param {{ file: string, source: Blob | Uint8Array | Float32Array }} args @param {Listener} progress @param {State} state
   * @returns {Promise<{ surface: number, info: import('../hexcast.js').FileInfo }>}
   */
  async read({ file, source }, progress, state) {
    const surface =
      source instanceof Float32Array
        ? this.#glue.WebSurface.fromCorners(file, source)
        : await readSurface(this.#glue, file, source, progress, state);
    await inSteps(surface.measure(), state).catch((error) => {
      surface.free();
      throw error;
    });
    return { surface: this.#surfaces.keep(surface), info: JSON.parse(surface.info()) };
  }

  /** Tells of a stage; waits for a mesh that is made: that goes first. @param {'check' | 'preview'} stage @param {Listener} progress */
  #stage(stage, progress) {
    return (/** @type {number} */ done) => {
      progress({ stage, done, total: 1 });
      return this.#turn;
    };
  }

  /** What edges tell of a surface. @param {{ surface: number }} args @param {Listener} progress @param {State} state */
  async check({ surface }, progress, state) {
    return JSON.parse(await inSteps(this.#surfaces.get(surface).check(), state, this.#stage('check', progress)));
  }

  /**
   * @param {{ surface: number, maxFacets: number }} args @param {Listener} progress @param {State} state
   * @returns {Promise<Float32Array>}
   */
  preview({ surface, maxFacets }, progress, state) {
    return inSteps(this.#surfaces.get(surface).preview(maxFacets), state, this.#stage('preview', progress));
  }

  /** @param {{ surface: number | undefined }} args */
  corners({ surface }) {
    return this.#surfaces.get(surface).corners();
  }

  /** @param {JobArguments} args @param {State} state */
  #job({ json, surfaces }, state) {
    const job = new this.#glue.WebJob(json, state.stop);
    for (const id of surfaces) job.add(this.#surfaces.get(id));
    return job;
  }

  /** @param {JobArguments} args @param {Listener} _progress @param {State} state @returns {Promise<import('../hexcast.js').Estimate>} */
  async estimate(args, _progress, state) {
    const job = this.#job(args, state);
    const steps = freeAfter(job, () => job.estimate());
    const estimate = JSON.parse(await inSteps(steps, state));
    return { ...estimate, seconds: this.#pace.secondsOf(estimate) };
  }

  /**
   * Meshes wait for each other: there is one engine.
   *
   * @param {MeshArguments} args
   * @param {Listener} progress
   * @param {State} state
   */
  mesh(args, progress, state) {
    return this.#inTurn(state, () => this.#make(args, progress, state));
  }

  /**
   * Works once the mesh before has ended.
   *
   * @template T
   * @param {State} state
   * @param {() => Promise<T>} work
   * @returns {Promise<T>}
   */
  #inTurn(state, work) {
    const made = this.#turn.then(() => {
      if (state.cancelled) throw cancelled();
      return work();
    });
    this.#turn = made.catch(() => {});
    return made;
  }

  /** @param {MeshArguments} args @param {Listener} progress @param {State} state */
  async #make(args, progress, state) {
    const mesh = await spilling(args.spill, async (open) => {
      // before the file is opened: a job may be refused
      const job = this.#job(args, state);
      return this.#engine.mesh(job, args.readSeconds, args.maxDeviceBytes, onRays(progress), await open?.());
    });
    const facts = this.#describeMade(mesh);
    this.#pace.learn(facts.report);
    return facts;
  }

  /** Facts of a mesh that the engine made, which may have lost its GPU for good. @param {WebMesh} mesh */
  #describeMade(mesh) {
    const facts = this.#describe(mesh);
    /** @type {Facts} */
    const engine = JSON.parse(this.#engine.facts());
    facts.report.fallback = this.#notTaken ?? facts.report.fallback;
    return engine.adapter ? facts : { ...facts, engine };
  }

  /** @param {JobArguments & { maxDeviceBytes?: number }} args @param {Listener} progress @param {State} state */
  scene({ maxDeviceBytes, ...args }, progress, state) {
    return this.#inTurn(state, async () => {
      const scene = await this.#engine.scene(this.#job(args, state), maxDeviceBytes, onRays(progress));
      return { scene: this.#scenes.keep(scene), ...this.#describeMade(scene.mesh()) };
    });
  }

  /** @param {JobArguments & { scene: number }} args @param {Listener} progress @param {State} state */
  update({ scene: id, ...args }, progress, state) {
    return this.#inTurn(state, async () => {
      const scene = this.#scenes.get(id);
      await this.#engine.update(scene, this.#job(args, state), onRays(progress));
      /** @type {Omit<import('../hexcast.js').Update, 'changed'>} */
      const update = JSON.parse(scene.update());
      return { update, changed: changedRuns(scene.changed()), n_made: scene.nMade(), ...this.#describeMade(scene.mesh()) };
    });
  }

  /**
   * @param {JobArguments & { sizes: number[] }} args @param {Listener} progress @param {State} state
   * @returns {Promise<import('../hexcast.js').Level[]>}
   */
  converge({ sizes, ...args }, progress, state) {
    return this.#inTurn(state, async () =>
      JSON.parse(await this.#engine.converge(this.#job(args, state), new Uint32Array(sizes), onRays(progress))),
    );
  }

  /** @param {{ source: Blob | Uint8Array }} args */
  async openColumns({ source }) {
    const file = await columnFile(source);
    return this.#describe(this.#glue.WebMesh.open(file, file.size));
  }

  /** @param {WebMesh} mesh */
  #describe(mesh) {
    return { mesh: this.#meshes.keep(mesh), ...factsOf(mesh, this.#adapterName) };
  }

  /** @param {{ mesh: number, cell: [number, number, number] }} args */
  flag({ mesh, cell }) {
    return this.#meshes.get(mesh).flag(...cell);
  }

  /** @param {{ mesh: number, start: number[], end: number[] }} args */
  box({ mesh, start, end }) {
    return this.#meshes.get(mesh).box(new Uint32Array([...start, ...end]));
  }

  /** @param {{ mesh: number, start: number[], end: number[] }} args */
  boxRuns({ mesh, start, end }) {
    return this.#meshes.get(mesh).boxRuns(new Uint32Array([...start, ...end]));
  }

  /** WGSL of the kernel that makes flags of runs. @param {object} _args none */
  expandText(_args) {
    return this.#glue.expandText();
  }

  /** @param {{ mesh: number, maxBytes: number }} args */
  slabs({ mesh, maxBytes }) {
    return this.#meshes.get(mesh).slabs(maxBytes);
  }

  /** @param {{ mesh: number, i: number, j: number }} args */
  ray({ mesh, i, j }) {
    const runs = this.#meshes.get(mesh).ray(i, j);
    return { starts: runs.map((run) => run >>> 8), flags: Uint8Array.from(runs, (run) => run & 255) };
  }

  /** The runs of all rays. @param {{ mesh: number, rays: number }} args @param {Listener} progress @param {State} state */
  columns({ mesh, rays }, progress, state) {
    return allRuns(this.#meshes.get(mesh), rays, progress, state);
  }

  /** @param {{ mesh: number, axis: number, index: number, maxPixels: number }} args */
  slice({ mesh, axis, index, maxPixels }) {
    return sliceOf(this.#meshes.get(mesh), axis, index, maxPixels);
  }

  /** @param {{ mesh: number, maxQuads: number }} args */
  skin({ mesh, maxQuads }) {
    return skinOf(this.#meshes.get(mesh), maxQuads);
  }

  /** A picture. @param {{ mesh: number, asked: import('./pictures.js').Asked }} args @param {Listener} _progress @param {State} state */
  draw({ mesh, asked }, _progress, state) {
    return pictureIn(this.#glue, this.#meshes.get(mesh), asked, state);
  }

  /** @param {{ mesh: number, other: number, maxBytes: number }} args @param {Listener} _progress @param {State} state */
  async compare({ mesh, other, maxBytes }, _progress, state) {
    const { facts, mask } = await comparedIn(this.#meshes.get(mesh), this.#meshes.get(other), maxBytes, state);
    return { facts, ...this.#describe(mask) };
  }

  /**
   * Looks for a path from one point to another; facets are named in the surfaces of a job, if there is one.
   *
   * @param {{ mesh: number, question: string, job: JobArguments | null }} args @param {Listener} _progress @param {State} state
   * @returns {import('../hexcast.js').Leak}
   */
  leak({ mesh, question, job }, _progress, state) {
    const surfaces = job ? this.#job(job, state) : undefined;
    return JSON.parse(this.#meshes.get(mesh).leak(question, surfaces));
  }

  /** @param {{ mesh: number, of: import('./arrays.js').Measured }} args */
  arrays({ mesh, of }) {
    return arraysOf(this.#meshes.get(mesh), of);
  }

  /** @param {{ mesh: number, format: string, options: string }} args */
  encode({ mesh, format, options }) {
    return this.#encoders.keep(this.#meshes.get(mesh).encode(format, options));
  }

  /**
   * The next bytes of a file, or the share of the work before the first of them that is done, or at the end what the file lacks of the mesh.
   *
   * @param {{ encoder: number }} args
   * @returns {Uint8Array | { share: number } | { lacks: string[] }}
   */
  next({ encoder }) {
    const made = this.#encoders.get(encoder);
    const bytes = made.nextPiece();
    if (bytes) return bytes.length > 0 ? bytes : { share: made.share() };
    const lacks = made.lacks();
    this.release({ encoder });
    return { lacks };
  }

  /** @param {{ mesh: number, options: string, sha256?: string }} args */
  sidecar({ mesh, options, sha256 }) {
    return this.#meshes.get(mesh).sidecar(options, sha256);
  }

  /** SHA-256 of the raw file. @param {{ mesh: number, options: string }} args @param {Listener} progress @param {State} state */
  sha256({ mesh, options }, progress, state) {
    return sha256(this.#meshes.get(mesh), options, progress, state);
  }

  /** Frees what is named. @param {{ surface?: number, mesh?: number, scene?: number, encoder?: number }} args */
  release({ surface, mesh, scene, encoder }) {
    // an update holds it
    if (scene) this.#turn.then(() => this.#scenes.release(scene));
    this.#surfaces.release(surface);
    this.#meshes.release(mesh);
    this.#encoders.release(encoder);
  }
}

/**
 * Loads the wasm. A server may give a page in its place, which no wasm is.
 *
 * @param {Glue} glue @param {any} wasm its address, bytes or module
 */
async function load(glue, wasm) {
  try {
    return await glue.default({ module_or_path: wasm });
  } catch (cause) {
    const [from, why] = [typeof wasm === 'string' ? ` from ${wasm}` : '', cause instanceof Error ? cause.message : String(cause)];
    throw new HexcastError('device-failed', `the wasm of hexcast cannot be loaded${from}: ${why}`, { hint: NOT_FOUND, cause });
  }
}

/** Compiles a wasm that threads run too. @param {any} source its address, bytes or module @returns {Promise<WebAssembly.Module>} */
async function compiled(source) {
  if (source instanceof WebAssembly.Module) return source;
  return typeof source === 'string' ? WebAssembly.compileStreaming(fetch(source)) : WebAssembly.compile(source);
}

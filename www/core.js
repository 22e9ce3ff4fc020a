/**
 * The work itself, on the thread it is called from: wasm, surfaces and meshes by number. `worker.js` runs it in a worker,
 * `hexcast.js` talks to it there or, without a worker, directly. Everything in and out can be cloned.
 */
import { clearAside, hasAside, openAside } from './aside.js';
import { describeAdapter, lendDevice } from './adapter.js';
import { columnFile } from './column_file.js';
import { errorFrom } from './error.js';
import init, { WebEngine, WebJob, WebMesh, WebReader, WebSurface, WebSwitch, version } from './hexcast_wasm.js';

/** Bytes of a Blob read at once. */
const SLICE_BYTES = 4 << 20;

/** Resolves once messages that were waiting have been handled. */
function pause() {
  return new Promise((resolve) => {
    const { port1, port2 } = new MessageChannel();
    port1.onmessage = () => {
      port1.close();
      resolve();
    };
    port2.postMessage(null);
  });
}

export class Core {
  #engine;
  #surfaces = new Map();
  #meshes = new Map();
  #encoders = new Map();
  #switches = new Map();
  #next = 1;
  /** Resolves when the mesh before has ended. */
  #turn = Promise.resolve();
  /** What the browser calls the GPU. */
  #adapterName = '';
  /** Seconds a ray and a crossing took last, for estimates. */
  #pace = null;

  /** Loads the wasm and opens a backend; resolves to `{backend, adapter, fallback, version}`. */
  async open({ backend, wasm, device }) {
    // what earlier visits left; nobody waits for it
    clearAside();
    await init({ module_or_path: wasm });
    const open = () => WebEngine.open(backend, pause);
    this.#engine = await (device ? lendDevice(device, open) : open());
    const facts = JSON.parse(this.#engine.facts());
    if (facts.adapter) {
      Object.assign(facts.adapter, await describeAdapter(device));
      this.#adapterName = facts.adapter.name;
    }
    return { ...facts, version: version() };
  }

  /** Calls an operation by name; `call` names it for `cancel`, `progress` hears how far it is. */
  async run(operation, call, args, progress) {
    const stop = new WebSwitch();
    const state = { stop, cancelled: false };
    this.#switches.set(call, state);
    try {
      return await this[operation](args, progress, state);
    } finally {
      this.#switches.delete(call);
    }
  }

  cancel(call) {
    const state = this.#switches.get(call);
    if (state) {
      state.cancelled = true;
      state.stop.cancel();
    }
  }

  #keep(map, value) {
    const id = this.#next++;
    map.set(id, value);
    return id;
  }

  async read({ file, source }, progress, state) {
    const surface = source instanceof Float32Array ? WebSurface.fromCorners(file, source) : await readFile(file, source, progress, state);
    return { surface: this.#keep(this.#surfaces, surface), info: JSON.parse(surface.info()) };
  }

  corners({ surface }) {
    return this.#surfaces.get(surface).corners();
  }

  #job({ json, surfaces }, state) {
    const job = new WebJob(json, state.stop);
    for (const id of surfaces) job.add(this.#surfaces.get(id));
    return job;
  }

  estimate(args, _progress, state) {
    const estimate = JSON.parse(this.#job(args, state).estimate());
    const seconds = this.#pace && this.#pace.ray * estimate.rays + this.#pace.crossing * estimate.crossings;
    return { ...estimate, seconds };
  }

  /** Meshes wait for each other: there is one engine. */
  mesh(args, progress, state) {
    const made = this.#turn.then(() => {
      if (state.cancelled) throw cancelled();
      return this.#mesh(args, progress, state);
    });
    this.#turn = made.catch(() => {});
    return made;
  }

  async #mesh(args, progress, state) {
    const told = (done, total) => progress({ stage: 'mesh', done, total });
    const mesh = await spilling(args.spill, async (open) => {
      // first of all: a job that is refused opens no file
      const job = this.#job(args, state);
      return this.#engine.mesh(job, args.readSeconds, told, await open?.());
    });
    const facts = this.#describe(mesh);
    const engine = JSON.parse(this.#engine.facts());
    // the GPU may have been lost for good
    if (!engine.adapter) facts.engine = engine;
    const { rays, crossings, seconds } = facts.report;
    // half the time goes with the rays, half with what they cross: good enough to tell seconds from minutes
    this.#pace = { ray: seconds.columns / 2 / Math.max(rays, 1), crossing: seconds.columns / 2 / Math.max(crossings, 1) };
    return facts;
  }

  async openColumns({ source }) {
    const file = await columnFile(source);
    return this.#describe(WebMesh.open(file, file.size));
  }

  #describe(mesh) {
    const [runs, bytes] = mesh.columnFacts();
    const sizes = {};
    for (const format of ['vti', 'npy', 'raw', 'hxc']) sizes[format] = mesh.size(format, false);
    for (const format of ['npy', 'raw']) sizes[`${format}-bits`] = mesh.size(format, true);
    const report = JSON.parse(mesh.report());
    // the wasm is told no name
    if (report.adapter === '') report.adapter = this.#adapterName;
    return { mesh: this.#keep(this.#meshes, mesh), report, axis: mesh.rayAxis(), runs, bytes, sizes };
  }

  flag({ mesh, cell }) {
    return this.#meshes.get(mesh).flag(...cell);
  }

  box({ mesh, start, end }) {
    return this.#meshes.get(mesh).box(new Uint32Array([...start, ...end]));
  }

  slabs({ mesh, maxBytes }) {
    return this.#meshes.get(mesh).slabs(maxBytes);
  }

  ray({ mesh, i, j }) {
    const runs = this.#meshes.get(mesh).ray(i, j);
    return { starts: runs.map((run) => run >>> 8), flags: Uint8Array.from(runs, (run) => run & 255) };
  }

  slice({ mesh, axis, index, maxPixels }) {
    const bytes = this.#meshes.get(mesh).slice(axis, index, maxPixels);
    const [width, height, step] = new Uint32Array(bytes.slice(0, 12).buffer);
    return { width, height, step, flags: bytes.slice(12) };
  }

  skin({ mesh, maxQuads }) {
    const skin = this.#meshes.get(mesh).skin(maxQuads);
    const parts = Array.from(skin.flags(), (flag, part) => ({ flag, positions: skin.positions(part), indices: skin.indices(part) }));
    const step = skin.step();
    skin.free();
    return { step, parts };
  }

  encode({ mesh, format, compress, bits }) {
    return this.#keep(this.#encoders, this.#meshes.get(mesh).encode(format, compress, bits));
  }

  /** The next bytes of a file, or the share of the work before the first of them that is done, or null at the end. */
  next({ encoder }) {
    const held = this.#encoders.get(encoder);
    const bytes = held.nextPiece();
    if (bytes) return bytes.length > 0 ? bytes : { share: held.share() };
    this.release({ encoder });
    return null;
  }

  sidecar({ mesh, bits, bytes, sha256 }) {
    return this.#meshes.get(mesh).sidecar(bits, bytes, sha256);
  }

  /** SHA-256 and length of the raw file. */
  async sha256({ mesh, bits }, progress, state) {
    const held = this.#meshes.get(mesh);
    const total = held.size('raw', bits);
    const hash = held.hash(bits);
    while (hash.step()) {
      progress({ stage: 'write', done: hash.nBytes(), total });
      await pause();
      if (state.cancelled) throw cancelled();
    }
    return { bytes: hash.nBytes(), sha256: hash.finish() };
  }

  /** Frees what is named. */
  release({ surface, mesh, encoder }) {
    for (const [map, id] of [[this.#surfaces, surface], [this.#meshes, mesh], [this.#encoders, encoder]]) {
      map.get(id)?.free();
      map.delete(id);
    }
  }
}

/** Makes a mesh with its columns in memory or, as `spill` says, in a file once they outgrow that. */
async function spilling(spill, make) {
  const open = async () => {
    if (!hasAside()) throw NO_SPILL;
    // a private window may refuse
    return openAside().catch(() => Promise.reject(NO_SPILL));
  };
  if (spill === true) return make(open);
  return make().catch((error) => {
    // most find out from their estimate, before a ray is cast
    if (spill === false || errorFrom(error).code !== 'memory') throw error;
    return make(open).catch((again) => Promise.reject(again === NO_SPILL ? error : again));
  });
}

const NO_SPILL = JSON.stringify({
  code: 'io',
  message: 'columns cannot spill here: there is no private file system that this thread can write without waiting',
  hint: 'leave out spill, or mesh in a worker of a secure page',
});

function cancelled() {
  return JSON.stringify({ code: 'cancelled', message: 'cancelled', hint: '' });
}

/** Feeds a file to the reader in slices: a Blob is never read as a whole. */
async function readFile(file, source, progress, state) {
  const total = source.size ?? source.byteLength;
  const reader = new WebReader(file, total);
  for (let at = 0; at < total; at += SLICE_BYTES) {
    const end = Math.min(at + SLICE_BYTES, total);
    const slice = source.slice ? source.slice(at, end) : source.subarray(at, end);
    reader.push(slice instanceof Uint8Array ? slice : new Uint8Array(slice.arrayBuffer ? await slice.arrayBuffer() : slice));
    progress({ stage: 'read', done: end, total });
    // bytes in memory come without a wait in which a message could
    if (!source.arrayBuffer) await pause();
    if (state.cancelled) throw cancelled();
  }
  return reader.finish();
}

/** The package's entry: see `hexcast.d.ts` for everything public. */
import { clearSpillFiles } from './spill.js';
import { HexcastError } from './error.js';
import { Mesh } from './mesh.js';
import { connect } from './connection.js';

/**
 * @typedef {import('./hexcast.js').MesherOptions} MesherOptions
 * @typedef {import('./hexcast.js').CallOptions} CallOptions
 * @typedef {import('./hexcast.js').Job} Job
 * @typedef {import('./hexcast.js').GeometrySource} GeometrySource
 * @typedef {import('./connection.js').Connection} Connection
 * @typedef {{ json: string, surfaces: number[], readAny: boolean }} Prepared a job as the core takes it
 */

export { HexcastError };
export const version = '0.1.0';

/** @type {typeof import('./hexcast.js').createMesher} */
export async function createMesher({ backend = 'auto', wasm, worker, device, signal } = {}) {
  signal?.throwIfAborted();
  if (device) checkDevice(backend, worker);
  const connection = await connect(device ? false : worker);
  try {
    const source = wasm ?? new URL('./hexcast_bg.wasm', import.meta.url);
    const facts = await connection.call(
      'open',
      // a URL cannot be sent to a worker
      { backend, wasm: source instanceof URL ? source.href : source, device: /** @type {GPUDevice | undefined} */ (device) },
      { signal },
    );
    return new Mesher(connection, facts);
  } catch (error) {
    connection.close();
    throw error;
  }
}

/** @param {MesherOptions['backend']} backend @param {MesherOptions['worker']} worker */
function checkDevice(backend, worker) {
  if (backend === 'cpu')
    throw new HexcastError('job-conflict', 'a device is given, and the backend "cpu"', 'leave out one of them');
  if (worker !== undefined && worker !== false) {
    throw new HexcastError(
      'job-conflict',
      'a device is given, and a worker: devices cannot leave their thread',
      'leave out one of them',
    );
  }
}

/** A surface in the worker. */
class Surface {
  #connection;
  /** @type {number | undefined} */
  #id;

  /** @param {Connection} connection @param {{ surface: number, info: import('./hexcast.js').SurfaceInfo }} made */
  constructor(connection, { surface, info }) {
    this.#connection = connection;
    this.#id = surface;
    this.info = info;
  }

  /** Its number there, for a connection that is the same. @param {Connection} connection */
  idFor(connection) {
    if (connection !== this.#connection || this.#id === undefined) {
      throw new HexcastError(
        'job-value',
        `surface "${this.info.file}" was disposed of or belongs to another mesher`,
        'read it again',
      );
    }
    return this.#id;
  }

  corners() {
    return this.#connection.call('corners', { surface: this.#id });
  }

  dispose() {
    if (this.#id !== undefined) this.#connection.send('release', { surface: this.#id });
    this.#id = undefined;
  }

  [Symbol.dispose]() {
    this.dispose();
  }
}

class Mesher {
  #connection;

  /** @param {Connection} connection @param {import('./core.js').Facts} facts */
  constructor(connection, { backend, adapter, fallback }) {
    this.#connection = connection;
    this.backend = backend;
    this.adapter = adapter;
    this.fallback = fallback;
  }

  /**
   * @param {Exclude<GeometrySource, import('./hexcast.js').Surface>} source
   * @param {CallOptions & { file?: string }} [options]
   */
  async read(source, { file, ...options } = {}) {
    return new Surface(this.#connection, await this.#read(source, file ?? nameOf(source) ?? 'geometry', options));
  }

  /** @param {Job} job @param {import('./hexcast.js').MeshOptions} [options] */
  async mesh(job, options = {}) {
    const start = performance.now();
    const { spill = 'auto' } = options;
    if (!['auto', true, false].includes(spill))
      throw new HexcastError('job-value', `spill is ${spill}; allowed: 'auto', true, false`);
    return this.#withSurfaces(job, options, async (prepared) => {
      const readSeconds = prepared.readAny ? (performance.now() - start) / 1000 : 0;
      const made = await this.#connection.call('mesh', { ...prepared, readSeconds, spill }, options);
      // where the GPU was lost for good, the mesher stays on the CPU
      if (this.backend === 'gpu' && 'engine' in made) Object.assign(this, made.engine);
      return this.#meshOf(made);
    });
  }

  /** @param {Job} job @param {CallOptions} [options] */
  async estimate(job, options = {}) {
    return this.#withSurfaces(job, options, (prepared) => this.#connection.call('estimate', prepared, options));
  }

  /** @param {Blob | Uint8Array | ArrayBuffer} file @param {CallOptions} [options] */
  async open(file, options = {}) {
    // bytes are copied: the mesh reads them as long as it lives
    const source = file instanceof Blob ? file : new Uint8Array(file instanceof ArrayBuffer ? file.slice(0) : file);
    return this.#meshOf(await this.#connection.call('openColumns', { source }, options));
  }

  /** @param {import('./connection.js').Result<'openColumns'>} made */
  #meshOf(made) {
    return new Mesh(this.#connection, made, (job, options, run) => this.#withSurfaces(job, options, run));
  }

  dispose() {
    this.#connection.close();
    // the worker was ended before it could
    clearSpillFiles();
  }

  [Symbol.dispose]() {
    this.dispose();
  }

  /** @param {GeometrySource} source @param {string} file @param {CallOptions} options */
  #read(source, file, options) {
    const bytes = source instanceof ArrayBuffer ? new Uint8Array(source) : source;
    if (!(bytes instanceof Blob || bytes instanceof Uint8Array || bytes instanceof Float32Array)) {
      throw new HexcastError(
        'job-value',
        `the source of "${file}" is no Blob, ArrayBuffer, Uint8Array, Float32Array or Surface`,
        '',
      );
    }
    return this.#connection.call('read', { file, source: bytes }, options);
  }

  /**
   * Reads what was not read yet, runs a call with the job as the core takes it, and frees what was read for it.
   *
   * @template T
   * @param {Job} job
   * @param {CallOptions} options
   * @param {(prepared: Prepared) => Promise<T>} run
   * @returns {Promise<T>}
   */
  async #withSurfaces(job, options, run) {
    const temporary = [];
    try {
      const surfaces = [];
      const geometries = [];
      for (const [index, { source, file, ...geometry }] of (job?.geometries ?? []).entries()) {
        const isSurface = source instanceof Surface;
        const name = file ?? (isSurface ? source.info.file : nameOf(source)) ?? `geometry-${index + 1}`;
        const id = isSurface ? source.idFor(this.#connection) : (await this.#read(source, name, options)).surface;
        if (!isSurface) temporary.push(id);
        surfaces.push(id);
        geometries.push({ ...geometry, file: name });
      }
      return await run({ json: JSON.stringify({ ...job, geometries }), surfaces, readAny: temporary.length > 0 });
    } finally {
      for (const surface of temporary) this.#connection.send('release', { surface });
    }
  }
}

/** The name of a File. @param {GeometrySource} source */
function nameOf(source) {
  return source instanceof File ? source.name : undefined;
}

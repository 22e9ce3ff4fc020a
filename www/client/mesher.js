/** A mesher: reads surfaces, meshes jobs, opens column files. Every call is the core's. */
import { CALL, kindOf, oneOf, optionsOf, text, wholeNumber, wrongValue, yesOrNo } from './check.js';
import { HexcastError } from '../protocol/error.js';
import { Mesh } from './mesh.js';
import { Scene } from './scene.js';
import { plainJson } from './job_json.js';
import { columnBytes, nameOf, surfaceOf } from './source.js';
import { clearSpillFiles } from '../platform/spill.js';

/**
 * @typedef {import('../hexcast.js').CallOptions} CallOptions
 * @typedef {import('../hexcast.js').Job} Job
 * @typedef {import('../hexcast.js').GeometrySource} GeometrySource
 * @typedef {import('./connection.js').Connection} Connection
 * @typedef {{ json: string, surfaces: number[], readAny: boolean }} Prepared a job as the core takes it
 */

/** Least limit of a GPU's memory. */
const LEAST_DEVICE_BYTES = 2 ** 20;
/** Most facets that a preview can have. */
const MAX_FACETS = 2 ** 32 - 1;

/** Cells along the longest side that `converge` compares by default. */
const SIZES = [32, 64, 128, 256];
/** Most cells along an axis that a job can ask for. */
const MOST_CELLS = 2 ** 32 - 1;

/** A surface in the worker. */
class Surface {
  #connection;
  /** @type {number | undefined} */
  #id;

  /** @param {Connection} connection @param {{ surface: number, info: import('../hexcast.js').FileInfo }} made */
  constructor(connection, { surface, info }) {
    this.#connection = connection;
    this.#id = surface;
    /** With what `check` has found. @type {any} */
    this.info = info;
  }

  /** Its number there, for a connection that is the same. @param {Connection} connection */
  idFor(connection) {
    if (this.#id === undefined)
      throw new HexcastError('disposed', `the surface "${this.info.file}" was disposed of`, { hint: 'read it again' });
    if (connection === this.#connection) return this.#id;
    const message = `the surface "${this.info.file}" belongs to another mesher`;
    throw new HexcastError('job-value', message, { hint: 'read it with this one' });
  }

  async corners() {
    return this.#connection.call('corners', { surface: this.idFor(this.#connection) });
  }

  /** @param {CallOptions} [options] */
  async check(options) {
    const call = optionsOf(options, CALL);
    const surface = this.idFor(this.#connection);
    if (!('closed_parity' in this.info)) {
      const found = await this.#connection.call('check', { surface }, call);
      this.info = { ...this.info, ...found };
    }
    return this;
  }

  /** @param {number} maxFacets @param {CallOptions} [options] */
  async preview(maxFacets, options) {
    wholeNumber('maxFacets', maxFacets, 1, MAX_FACETS);
    return this.#connection.call('preview', { surface: this.idFor(this.#connection), maxFacets }, optionsOf(options, CALL));
  }

  dispose() {
    if (this.#id !== undefined) this.#connection.send('release', { surface: this.#id });
    this.#id = undefined;
  }

  [Symbol.dispose]() {
    this.dispose();
  }
}

export class Mesher {
  #connection;

  /** @param {Connection} connection @param {import('../core/core.js').Facts & { threads: number }} facts */
  constructor(connection, { backend, threads, adapter, fallback }) {
    this.#connection = connection;
    this.backend = backend;
    this.threads = threads;
    this.adapter = adapter;
    this.fallback = fallback;
  }

  /**
   * @param {import('./source.js').Source} source
   * @param {CallOptions & { file?: string, check?: boolean }} [options]
   */
  async read(source, options) {
    const { file, check = true, ...call } = optionsOf(options, ['file', 'check', ...CALL]);
    yesOrNo('check', check);
    const name = text('file', file ?? (nameOf(source) || 'geometry'));
    const surface = new Surface(this.#connection, await this.#read('source', source, name, call));
    if (!check) return surface;
    return surface.check(call).catch((error) => {
      surface.dispose();
      throw error;
    });
  }

  /** @param {Job} job @param {import('../hexcast.js').MeshOptions} [options] */
  async mesh(job, options) {
    const start = performance.now();
    const { spill = 'auto', maxDeviceBytes, ...call } = optionsOf(options, ['spill', 'maxDeviceBytes', ...CALL]);
    oneOf('spill', spill, ['auto', true, false]);
    checkDeviceBytes(maxDeviceBytes);
    return this.#withSurfaces(job, call, async (prepared) => {
      const readSeconds = prepared.readAny ? (performance.now() - start) / 1000 : 0;
      const made = await this.#connection.call('mesh', { ...prepared, readSeconds, spill, maxDeviceBytes }, call);
      return this.#meshOf(made);
    });
  }

  /** @param {Job} job @param {import('../hexcast.js').SceneOptions} [options] */
  async scene(job, options) {
    const { maxDeviceBytes, ...call } = optionsOf(options, ['maxDeviceBytes', ...CALL]);
    checkDeviceBytes(maxDeviceBytes);
    return this.#withSurfaces(job, call, async (prepared) => {
      const made = await this.#connection.call('scene', { ...prepared, maxDeviceBytes }, call);
      const withSurfaces = /** @type {import('./mesh.js').WithSurfaces<any>} */ ((...args) => this.#withSurfaces(...args));
      return new Scene(this.#connection, made, withSurfaces, (of) => this.#meshOf(of));
    });
  }

  /** @param {Job} job @param {CallOptions} [options] */
  async estimate(job, options) {
    const call = optionsOf(options, CALL);
    return this.#withSurfaces(job, call, (prepared) => this.#connection.call('estimate', prepared, call));
  }

  /** @param {Job} job @param {CallOptions & { sizes?: readonly number[] }} [options] */
  async converge(job, options) {
    const { sizes = SIZES, ...call } = optionsOf(options, ['sizes', ...CALL]);
    if (!Array.isArray(sizes) || sizes.length === 0) throw wrongValue('sizes', sizes, 'a list of numbers of cells');
    const checked = sizes.map((size, at) => wholeNumber(`sizes[${at}]`, size, 1, MOST_CELLS));
    return this.#withSurfaces(job, call, (prepared) => this.#connection.call('converge', { ...prepared, sizes: checked }, call));
  }

  /** @param {Blob | Uint8Array | ArrayBuffer} file @param {CallOptions} [options] */
  async open(file, options) {
    const call = optionsOf(options, CALL);
    const bytes = columnBytes('file', file);
    // bytes are copied: the mesh reads them as long as it lives
    const source = bytes instanceof Uint8Array ? bytes.slice() : bytes;
    return this.#meshOf(await this.#connection.call('openColumns', { source }, call));
  }

  /** @param {import('./connection.js').Result<'openColumns'> & { engine?: import('../core/core.js').Facts }} made */
  #meshOf(made) {
    // where the GPU was lost for good, the mesher stays on the CPU
    if (this.backend === 'gpu' && made.engine) Object.assign(this, made.engine);
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

  /** @param {string} key @param {GeometrySource} source @param {string} file @param {CallOptions} options */
  #read(key, source, file, options) {
    return this.#connection.call('read', { file, source: surfaceOf(key, source) }, options);
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
    /** @type {number[]} */
    const temporary = [];
    const parts = partsOf(job);
    try {
      const surfaces = [];
      for (const [index, source] of parts.sources.entries()) {
        const isSurface = source instanceof Surface;
        const id = isSurface
          ? source.idFor(this.#connection)
          : (await this.#read(`geometries[${index}].source`, source, parts.files[index], options)).surface;
        if (!isSurface) temporary.push(id);
        surfaces.push(id);
      }
      return await run({ json: parts.json, surfaces, readAny: temporary.length > 0 });
    } finally {
      for (const surface of temporary) this.#connection.send('release', { surface });
    }
  }
}

/** @param {number | undefined} bytes */
function checkDeviceBytes(bytes) {
  if (bytes !== undefined) wholeNumber('maxDeviceBytes', bytes, LEAST_DEVICE_BYTES, Number.MAX_SAFE_INTEGER);
}

/**
 * A job as JSON, its sources and their names; the JSON is made before any source is read.
 *
 * @param {Job} job
 */
function partsOf(job) {
  if (kindOf(job) !== 'Object') throw wrongValue('the job', job, 'an object');
  const { backend, geometries = [], ...others } = /** @type {Job & { backend?: unknown }} */ (job);
  if (backend !== undefined) {
    const hint = 'give it to createMesher';
    throw new HexcastError('job-value', 'backend is no key of a job', { hint, details: { key: 'backend' } });
  }
  if (!Array.isArray(geometries)) throw wrongValue('geometries', geometries, 'a list of objects with a source');
  const sources = [];
  const files = [];
  const plain = [];
  for (const [index, geometry] of geometries.entries()) {
    const key = `geometries[${index}]`;
    if (kindOf(geometry) !== 'Object') throw wrongValue(key, geometry, 'an object with a source');
    const { source, file, ...placing } = geometry;
    const name = file ?? (source instanceof Surface ? source.info.file : nameOf(source)) ?? `geometry-${index + 1}`;
    files.push(text(`${key}.file`, name));
    sources.push(source);
    plain.push({ ...placing, file: name });
  }
  return { json: plainJson({ ...others, geometries: plain }), sources, files };
}

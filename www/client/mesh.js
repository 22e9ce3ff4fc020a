/** A mesh that the core holds: queries, pictures and files. */
import { placeFor, piecesOf, SLAB_BYTES } from './box.js';
import { byteStream } from './byte_stream.js';
import { CALL, optionsOf, wholeNumber, threeNumbers } from './check.js';
import { report } from './connection.js';
import { HexcastError } from '../protocol/error.js';
import { flagsBuffer, flagsTexture } from './flags_on_gpu.js';
import { described, formats, written } from './formats.js';
import { mostBytes, slicesAsked, viewAsked } from './picture_options.js';
import { plainJson } from './job_json.js';
import { columnBytes } from './source.js';

/** Bytes of a file that are collected in memory before they become a Blob, which browsers keep on disk. */
const BLOB_PART_BYTES = 64 << 20;

const MOST = 2 ** 32 - 1;
const LEAK = ['from', 'to', 'flags', 'job', 'max_memory'];

/**
 * @typedef {import('../hexcast.js').Format} Format
 * @typedef {import('../hexcast.js').WriteOptions} WriteOptions
 * @typedef {import('../hexcast.js').CallOptions} CallOptions
 * @typedef {[number, number, number]} Cell
 * @typedef {import('../core/core.js').JobArguments} JobArguments
 */

/**
 * Runs a call with the surfaces of a job: see `Mesher`.
 *
 * @template T
 * @typedef {(job: import('../hexcast.js').Job, options: CallOptions, run: (prepared: JobArguments) => Promise<T>) => Promise<T>} WithSurfaces
 */

/** @template {import('../core/core.js').Operation} K @typedef {import('./connection.js').Arguments<K>} Arguments */

function disposed() {
  return new HexcastError('disposed', 'the mesh was disposed of', { hint: 'mesh again' });
}

export class Mesh {
  #connection;
  /** @type {number | undefined} */
  #id;
  #sizes;
  #withSurfaces;

  /**
   * @param {import('./connection.js').Connection} connection
   * @param {import('./connection.js').Result<'openColumns'>} made
   * @param {WithSurfaces<import('../hexcast.js').Leak>} withSurfaces
   */
  constructor(connection, { mesh, report, axis, runs, bytes, sizes }, withSurfaces) {
    this.#connection = connection;
    this.#withSurfaces = withSurfaces;
    this.#id = mesh;
    this.#sizes = sizes;
    this.report = report;
    this.dims = report.dims;
    const { origin, spacing, dims, grading } = report;
    this.lines = { origin, spacing, dims, lists: grading && { x: grading.x, y: grading.y, z: grading.z } };
    this.columns = Object.freeze({
      axis,
      runs,
      bytes,
      ray: (/** @type {number} */ i, /** @type {number} */ j) => this.#ray(i, j),
      all: (/** @type {CallOptions | undefined} */ options) => this.#columns(options),
    });
  }

  /**
   * @template {import('../core/core.js').Operation} K
   * @param {K} operation
   * @param {Omit<Arguments<K>, 'mesh'>} args
   * @param {CallOptions} [options]
   */
  async #call(operation, args, options) {
    if (this.#id === undefined) throw disposed();
    return this.#connection.call(operation, /** @type {Arguments<K>} */ ({ mesh: this.#id, ...args }), options);
  }

  /** @param {CallOptions} [options] */
  async #columns(options) {
    const call = optionsOf(options, CALL);
    return this.#call('columns', { rays: this.report.rays }, call);
  }

  /** @param {number} i @param {number} j */
  async #ray(i, j) {
    const [n_i, n_j] = this.dims.filter((_, axis) => axis !== this.columns.axis);
    return this.#call('ray', { i: wholeNumber('i', i, 0, n_i - 1), j: wholeNumber('j', j, 0, n_j - 1) });
  }

  /** @param {number} x @param {number} y @param {number} z */
  async flag(x, y, z) {
    const [nx, ny, nz] = this.dims;
    const cell = /** @type {Cell} */ ([
      wholeNumber('x', x, 0, nx - 1),
      wholeNumber('y', y, 0, ny - 1),
      wholeNumber('z', z, 0, nz - 1),
    ]);
    return this.#call('flag', { cell });
  }

  /** @param {Cell} start @param {Cell} end @param {{ into?: Uint8Array, signal?: AbortSignal }} [options] */
  async box(start, end, options) {
    const { into, signal } = optionsOf(options, ['into', 'signal']);
    const first = threeNumbers('start', start, [0, 0, 0], this.dims);
    const last = threeNumbers('end', end, first, this.dims);
    return { start: first, end: last, flags: await this.#flags(first, last, into, signal) };
  }

  /** @param {Cell} start @param {Cell} end @param {Uint8Array} [into] @param {AbortSignal} [signal] */
  async #flags(start, end, into, signal) {
    const flags = placeFor(start, end, into);
    let at = 0;
    for (const [low, high] of piecesOf(start, end)) {
      const piece = await this.#call('box', { start: low, end: high }, { signal });
      // most boxes are one piece
      if (!into && piece.length === flags.length) return piece;
      flags.set(piece, at);
      at += piece.length;
    }
    return flags;
  }

  /** What the kernel on the caller's device needs. @returns {import('./flags_on_gpu.js').Source} */
  #source() {
    return {
      dims: this.dims,
      axis: this.columns.axis,
      runs: (start, end, signal) => this.#call('boxRuns', { start, end }, { signal }),
      text: () => this.#call('expandText', {}),
    };
  }

  /** @param {import('../hexcast.js').Device} device @param {import('../hexcast.js').FlagsBufferOptions} [options] */
  async flagsBuffer(device, options) {
    return flagsBuffer(this.#source(), device, options);
  }

  /** @param {import('../hexcast.js').Device} device @param {import('../hexcast.js').FlagsTextureOptions} [options] */
  async flagsTexture(device, options) {
    return flagsTexture(this.#source(), device, options);
  }

  /** @param {{ maxBytes?: number, into?: Uint8Array, signal?: AbortSignal }} [options] */
  async *slabs(options) {
    const { into, maxBytes = into?.length ?? SLAB_BYTES, signal } = optionsOf(options, ['maxBytes', 'into', 'signal']);
    wholeNumber('maxBytes', maxBytes, 1, Number.MAX_SAFE_INTEGER);
    const boxes = await this.#call('slabs', { maxBytes });
    const cell = (/** @type {number} */ at) => /** @type {Cell} */ ([...boxes.slice(at, at + 3)]);
    const load = (/** @type {number} */ at) => this.box(cell(at), cell(at + 3), { signal });
    let next = boxes.length > 0 ? load(0) : null;
    for (let at = 6; next; at += 6) {
      signal?.throwIfAborted();
      const { start, end, flags } = await next;
      next = at < boxes.length ? load(at) : null;
      // a caller that stops here never awaits it
      next?.catch(() => {});
      if (!into) yield { start, end, flags };
      else {
        const place = placeFor(start, end, into);
        place.set(flags);
        yield { start, end, flags: place };
      }
    }
  }

  /**
   * @overload
   * @param {0 | 1 | 2} axis
   * @param {number} index
   * @param {number} [maxPixels]
   * @returns {Promise<import('../hexcast.js').Slice>}
   *
   * @overload
   * @param {import('../hexcast.js').SliceOptions} options
   * @returns {Promise<Blob>}
   *
   * @param {number | import('../hexcast.js').SliceOptions} axis
   * @param {number} [index]
   * @returns {Promise<any>}
   */
  async slice(axis, index, maxPixels = 2048) {
    if (axis && typeof axis === 'object') return this.#picture(slicesAsked(axis), axis.signal);
    const of = wholeNumber('axis', axis, 0, 2);
    const plane = wholeNumber('index', index, 0, this.dims[of] - 1);
    wholeNumber('maxPixels', maxPixels, 1, MOST);
    return this.#call('slice', { axis: of, index: plane, maxPixels });
  }

  /** @param {import('../hexcast.js').ViewOptions} [options] */
  async view(options) {
    return this.#picture(viewAsked(this.dims, options), options?.signal);
  }

  /** @param {import('./picture_options.js').Asked} asked @param {AbortSignal} [signal] */
  async #picture(asked, signal) {
    return new Blob([await this.#call('draw', { asked }, { signal })], { type: 'image/png' });
  }

  /** @param {Mesh | import('../hexcast.js').FileSource} other @param {{ max_memory?: number, signal?: AbortSignal }} [options] */
  async diff(other, options) {
    const { max_memory, signal } = optionsOf(options, ['max_memory', 'signal']);
    const maxBytes = mostBytes(max_memory);
    const compare = async (/** @type {number} */ id) => {
      const { facts, ...made } = await this.#call('compare', { other: id, maxBytes }, { signal });
      return { ...facts, mask: new Mesh(this.#connection, made, this.#withSurfaces) };
    };
    if (other instanceof Mesh) return compare(other.#idFor(this.#connection));
    const { mesh } = await this.#connection.call('openColumns', { source: columnBytes('other', other) }, { signal });
    try {
      return await compare(mesh);
    } finally {
      this.#connection.send('release', { mesh });
    }
  }

  /** Its number in a connection, which must be its own. @param {import('./connection.js').Connection} connection */
  #idFor(connection) {
    if (this.#id === undefined) throw disposed();
    if (connection === this.#connection) return this.#id;
    throw new HexcastError('job-value', 'the other mesh belongs to another mesher', {
      hint: 'open its column file with this one',
    });
  }

  /** @param {{ maxQuads?: number, signal?: AbortSignal }} [options] */
  async skin(options) {
    const { maxQuads = 2_000_000, signal } = optionsOf(options, ['maxQuads', 'signal']);
    wholeNumber('maxQuads', maxQuads, 1, MOST);
    return this.#call('skin', { maxQuads }, { signal });
  }

  /** @param {import('../hexcast.js').LeakQuestion} question @param {CallOptions} [options] */
  async leak(question, options) {
    const call = optionsOf(options, CALL);
    const { job, ...points } = optionsOf(question, LEAK);
    const json = plainJson(points);
    const ask = (/** @type {JobArguments | null} */ prepared) => this.#call('leak', { question: json, job: prepared }, call);
    return job ? this.#withSurfaces(job, call, ask) : ask(null);
  }

  /** @param {CallOptions} [options] @returns {Promise<import('../hexcast.js').Links>} */
  async links(options) {
    return this.#measured('links', options);
  }

  /** @param {CallOptions} [options] @returns {Promise<import('../hexcast.js').Fractions>} */
  async fractions(options) {
    return this.#measured('fractions', options);
  }

  /** @param {CallOptions} [options] @returns {Promise<import('../hexcast.js').Staggered>} */
  async staggered(options) {
    return this.#measured('staggered', options);
  }

  /** @param {CallOptions} [options] @returns {Promise<import('../hexcast.js').Conformal>} */
  async conformal(options) {
    return this.#measured('conformal', options);
  }

  /** @param {CallOptions} [options] @returns {Promise<import('../hexcast.js').Distances>} */
  async distance(options) {
    return this.#measured('distance', options);
  }

  /** @param {CallOptions} [options] @returns {Promise<import('../hexcast.js').Tensors>} */
  async tensors(options) {
    return this.#measured('tensors', options);
  }

  /** @param {import('../core/arrays.js').Measured} of @param {CallOptions} [options] @returns {Promise<any>} */
  #measured(of, options) {
    return this.#call('arrays', { of }, optionsOf(options, CALL));
  }

  /** @param {CallOptions} [options] */
  async sha256(options) {
    return this.#call('sha256', { options: '{}' }, optionsOf(options, CALL));
  }

  /** @param {Format} format @param {WriteOptions} [options] */
  size(format, options) {
    const { compress, bits } = written(format, options).asked;
    if (compress > 0) return null;
    return this.#sizes[bits ? `${format}-bits` : format] ?? null;
  }

  /** @param {Format} format @param {WriteOptions} [options] */
  stream(format, options) {
    const { signal, onProgress, onLack, asked } = written(format, options);
    /** @type {number} */
    let encoder;
    let done = 0;
    const total = this.size(format, options) ?? 0;
    // before the first byte, progress counts flags
    const flags = this.report.cells;
    return byteStream({
      start: async () => {
        signal?.throwIfAborted();
        encoder = await this.#call('encode', { format, options: JSON.stringify(asked) }, { signal });
      },
      next: async () => {
        for (;;) {
          signal?.throwIfAborted();
          const bytes = await this.#connection.call('next', { encoder });
          if ('lacks' in bytes) {
            for (const lack of bytes.lacks) onLack?.(lack);
            return null;
          }
          if ('share' in bytes) {
            if (done === 0) report(onProgress, { stage: 'write', done: Math.floor(bytes.share * flags), total: flags });
          } else {
            done += bytes.byteLength;
            report(onProgress, { stage: 'write', done, total: Math.max(total, done) });
            return bytes;
          }
        }
      },
      cancel: () => this.#connection.send('release', { encoder }),
    });
  }

  /** @param {Format} format @param {WriteOptions} [options] */
  async blob(format, options) {
    /** @type {Blob[]} */
    const parts = [];
    /** @type {Uint8Array<ArrayBuffer>[]} */
    let pieces = [];
    let bytes = 0;
    const write = (/** @type {Uint8Array<ArrayBuffer>} */ piece) => {
      pieces.push(piece);
      bytes += piece.byteLength;
      if (bytes < BLOB_PART_BYTES) return;
      parts.push(new Blob(pieces));
      [pieces, bytes] = [[], 0];
    };
    await this.stream(format, options).pipeTo(new WritableStream({ write }));
    return new Blob([...parts, ...pieces], { type: formats[format].type });
  }

  /** @param {import('../hexcast.js').SidecarOptions} [options] */
  async sidecar(options) {
    const { hash, asked, call } = described(options);
    const json = JSON.stringify(asked);
    const sha256 = hash && (await this.#call('sha256', { options: json }, call));
    return this.#call('sidecar', { options: json, sha256 });
  }

  dispose() {
    if (this.#id !== undefined) this.#connection.send('release', { mesh: this.#id });
    this.#id = undefined;
  }

  [Symbol.dispose]() {
    this.dispose();
  }
}

/** A mesh that the core holds: queries, pictures and files. */

const SLAB_BYTES = 16 << 20;
/** Bytes of a file that are collected in memory before they become a Blob, which browsers keep on disk. */
const BLOB_PART_BYTES = 64 << 20;

const MIME = {
  vti: 'application/vnd.vtk.vti+xml',
  npy: 'application/octet-stream',
  raw: 'application/octet-stream',
  hxc: 'application/octet-stream',
};

/**
 * @typedef {import('./hexcast.js').Format} Format
 * @typedef {import('./hexcast.js').WriteOptions} WriteOptions
 * @typedef {import('./hexcast.js').CallOptions} CallOptions
 * @typedef {[number, number, number]} Cell
 */

/** @template {import('./core.js').Operation} K @typedef {import('./connection.js').Arguments<K>} Arguments */

export class Mesh {
  #connection;
  /** @type {number | undefined} */
  #id;
  #sizes;

  /** @param {import('./connection.js').Connection} connection @param {import('./connection.js').Result<'openColumns'>} made */
  constructor(connection, { mesh, report, axis, runs, bytes, sizes }) {
    this.#connection = connection;
    this.#id = mesh;
    this.#sizes = sizes;
    this.report = report;
    this.dims = report.dims;
    this.lines = { origin: report.origin, spacing: report.spacing, dims: report.dims };
    this.columns = Object.freeze({
      axis,
      runs,
      bytes,
      ray: (/** @type {number} */ i, /** @type {number} */ j) => this.#call('ray', { i, j }),
    });
  }

  /**
   * @template {import('./core.js').Operation} K
   * @param {K} operation
   * @param {Omit<Arguments<K>, 'mesh'>} args
   * @param {CallOptions} [options]
   */
  #call(operation, args, options) {
    return this.#connection.call(operation, /** @type {Arguments<K>} */ ({ mesh: this.#id, ...args }), options);
  }

  /** @param {number} x @param {number} y @param {number} z */
  flag(x, y, z) {
    return this.#call('flag', { cell: [x, y, z] });
  }

  /** @param {Cell} start @param {Cell} end */
  async box(start, end) {
    return { start, end, flags: await this.#call('box', { start, end }) };
  }

  /** @param {{ maxBytes?: number, signal?: AbortSignal }} [options] */
  async *slabs({ maxBytes = SLAB_BYTES, signal } = {}) {
    const boxes = await this.#call('slabs', { maxBytes });
    const cell = (/** @type {number} */ at) => /** @type {Cell} */ ([...boxes.slice(at, at + 3)]);
    const load = (/** @type {number} */ at) => this.box(cell(at), cell(at + 3));
    let next = boxes.length > 0 ? load(0) : null;
    for (let at = 6; next; at += 6) {
      signal?.throwIfAborted();
      const now = await next;
      next = at < boxes.length ? load(at) : null;
      // a caller that stops here never awaits it
      next?.catch(() => {});
      yield now;
    }
  }

  /** @param {0 | 1 | 2} axis @param {number} index */
  slice(axis, index, maxPixels = 2048) {
    return this.#call('slice', { axis, index, maxPixels });
  }

  /** @param {{ maxQuads?: number, signal?: AbortSignal }} [options] */
  skin({ maxQuads = 2_000_000, signal } = {}) {
    return this.#call('skin', { maxQuads }, { signal });
  }

  /** @param {CallOptions} [options] */
  async sha256(options) {
    return this.#call('sha256', { bits: false }, options);
  }

  /** @param {Format} format @param {WriteOptions} [options] */
  size(format, { compress = 0, bits = false } = {}) {
    if (compress > 0) return null;
    return this.#sizes[bits ? `${format}-bits` : format] ?? null;
  }

  /** @param {Format} format @param {WriteOptions} [options] */
  stream(format, { compress = 0, bits = false, signal, onProgress } = {}) {
    /** @type {number} */
    let encoder;
    let done = 0;
    const total = this.size(format, { compress, bits }) ?? 0;
    // while flags are compressed, progress counts flags
    const flags = this.report.cells;
    return new ReadableStream(
      {
        start: async () => {
          signal?.throwIfAborted();
          encoder = await this.#call('encode', { format, compress, bits }, { signal });
        },
        pull: async (controller) => {
          let bytes;
          for (;;) {
            signal?.throwIfAborted();
            bytes = await this.#connection.call('next', { encoder });
            if (bytes === null) return controller.close();
            if (!('share' in bytes)) break;
            onProgress?.({ stage: 'write', done: Math.floor(bytes.share * flags), total: flags });
          }
          done += bytes.byteLength;
          onProgress?.({ stage: 'write', done, total: Math.max(total, done) });
          controller.enqueue(bytes);
        },
        cancel: () => this.#connection.send('release', { encoder }),
      },
      { highWaterMark: 2 },
    );
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
    return new Blob([...parts, ...pieces], { type: MIME[format] });
  }

  /** @param {import('hexcast').SidecarOptions} [options] */
  async sidecar({ bits = false, hash, signal, onProgress } = {}) {
    const sha256 = hash && (await this.#call('sha256', { bits }, { signal, onProgress }));
    return this.#call('sidecar', { bits, sha256 });
  }

  dispose() {
    if (this.#id !== undefined) this.#connection.send('release', { mesh: this.#id });
    this.#id = undefined;
  }

  [Symbol.dispose]() {
    this.dispose();
  }
}

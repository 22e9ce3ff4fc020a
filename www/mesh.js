/** A mesh that the core holds: queries, pictures and files. */

const SLAB_BYTES = 16 << 20;
/** Bytes of a file gathered before they go into a Blob, which browsers keep on disk. */
const BLOB_PART_BYTES = 64 << 20;

const MIME = {
  vti: 'application/vnd.vtk.vti+xml',
  npy: 'application/octet-stream',
  raw: 'application/octet-stream',
  hxc: 'application/octet-stream',
};

export class Mesh {
  #connection;
  #id;
  #sizes;

  constructor(connection, { mesh, report, axis, runs, bytes, sizes }) {
    this.#connection = connection;
    this.#id = mesh;
    this.#sizes = sizes;
    this.report = report;
    this.dims = report.dims;
    this.lines = { origin: report.origin, spacing: report.spacing, dims: report.dims };
    this.columns = Object.freeze({ axis, runs, bytes, ray: (i, j) => this.#call('ray', { i, j }) });
  }

  #call(operation, args, options) {
    return this.#connection.call(operation, { mesh: this.#id, ...args }, options);
  }

  flag(x, y, z) {
    return this.#call('flag', { cell: [x, y, z] });
  }

  async box(start, end) {
    return { start, end, flags: await this.#call('box', { start, end }) };
  }

  async *slabs({ maxBytes = SLAB_BYTES, signal } = {}) {
    const boxes = await this.#call('slabs', { maxBytes });
    const load = (at) => (at < boxes.length ? this.box([...boxes.slice(at, at + 3)], [...boxes.slice(at + 3, at + 6)]) : null);
    let next = load(0);
    for (let at = 0; at < boxes.length; at += 6) {
      signal?.throwIfAborted();
      const now = await next;
      next = load(at + 6);
      // if the caller stops here nobody will wait for it
      next?.catch(() => {});
      yield now;
    }
  }

  slice(axis, index, maxPixels = 2048) {
    return this.#call('slice', { axis, index, maxPixels });
  }

  skin({ maxQuads = 2_000_000, signal } = {}) {
    return this.#call('skin', { maxQuads }, { signal });
  }

  async sha256(options) {
    return (await this.#call('sha256', { bits: false }, options)).sha256;
  }

  size(format, { compress = 0, bits = false } = {}) {
    if (compress > 0) return null;
    return this.#sizes[bits ? `${format}-bits` : format] ?? null;
  }

  stream(format, { compress = 0, bits = false, signal, onProgress } = {}) {
    let encoder;
    let done = 0;
    const total = this.size(format, { compress, bits }) ?? 0;
    // what is compressed first is counted in flags
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
            if (bytes.share === undefined) break;
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

  async blob(format, options) {
    const parts = [];
    let gathered = [];
    let bytes = 0;
    for await (const piece of iterate(this.stream(format, options))) {
      gathered.push(piece);
      bytes += piece.byteLength;
      if (bytes >= BLOB_PART_BYTES) {
        parts.push(new Blob(gathered));
        [gathered, bytes] = [[], 0];
      }
    }
    return new Blob([...parts, ...gathered], { type: MIME[format] });
  }

  async sidecar({ bits = false, signal, onProgress } = {}) {
    const { sha256, bytes } = await this.#call('sha256', { bits }, { signal, onProgress });
    return this.#call('sidecar', { bits, bytes, sha256 });
  }

  dispose() {
    if (this.#id !== undefined) this.#connection.send('release', { mesh: this.#id });
    this.#id = undefined;
  }

  [Symbol.dispose ?? Symbol.for('Symbol.dispose')]() {
    this.dispose();
  }
}

/** Reads a stream with `for await` where streams are not iterable by themselves. */
async function* iterate(stream) {
  const reader = stream.getReader();
  try {
    for (;;) {
      const { done, value } = await reader.read();
      if (done) return;
      yield value;
    }
  } finally {
    await reader.cancel().catch(() => {});
  }
}

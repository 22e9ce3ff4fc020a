/** A column file that is not copied to memory: the wasm reads parts of it, synchronously. */

/**
 * A file of which any part can be read; a failure is thrown as a sentence.
 *
 * @typedef {object} ColumnFile
 * @property {number} size in bytes
 * @property {(at: number, bytes: Uint8Array) => void} read fills `bytes` from an offset; all of them must exist
 */

/** Whether a Blob can be read synchronously on this thread: in workers of browsers. */
const CAN_READ = typeof FileReaderSync !== 'undefined';

/**
 * Makes a Blob, or bytes, readable at any offset. A Blob that cannot be read synchronously is copied to memory.
 *
 * @param {Blob | Uint8Array} source
 * @returns {Promise<ColumnFile>}
 */
export async function columnFile(source) {
  if (!(source instanceof Blob)) return new Bytes(source);
  return CAN_READ ? new Slices(source) : new Bytes(new Uint8Array(await source.arrayBuffer()));
}

/** Bytes in memory. */
class Bytes {
  #bytes;

  /** @param {Uint8Array} bytes */
  constructor(bytes) {
    this.#bytes = bytes;
    this.size = bytes.length;
  }

  /** @param {number} at @param {Uint8Array} bytes */
  read(at, bytes) {
    bytes.set(this.#bytes.subarray(at, at + bytes.length));
  }
}

/** A file of which slices are read. */
class Slices {
  #blob;
  #reader = new FileReaderSync();

  /** @param {Blob} blob */
  constructor(blob) {
    this.#blob = blob;
    this.size = blob.size;
  }

  /** @param {number} at @param {Uint8Array} bytes */
  read(at, bytes) {
    try {
      bytes.set(new Uint8Array(this.#reader.readAsArrayBuffer(this.#blob.slice(at, at + bytes.length))));
    } catch (error) {
      throw `the file cannot be read any more: ${error instanceof Error ? error.message : error}`;
    }
  }
}

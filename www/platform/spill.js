/**
 * Columns on disk: a temporary file in the origin's private file system (OPFS), which workers read and write synchronously. It is
 * removed with the mesh. A file of a worker that was ended before is removed by the next mesher.
 */
import { HexcastError, asError } from '../protocol/error.js';

const FOLDER = 'hexcast-columns';
/** Milliseconds between attempts: the browser releases the files of a worker a moment after its end. */
const WAITS = [0, 50, 200, 1000, 4000];

const NO_SPILL = new HexcastError(
  'io',
  'columns cannot spill here: this thread has no private file system that it can write synchronously',
  { hint: 'leave out spill, or mesh in a worker of a secure page' },
);

/** Opens a file for the columns of one mesh, which only workers of secure pages can. @returns {Promise<SpillFile>} */
async function openSpillFile() {
  if (!globalThis.FileSystemFileHandle?.prototype.createSyncAccessHandle) throw NO_SPILL;
  return withLock(async () => {
    const root = await navigator.storage.getDirectory();
    const folder = await root.getDirectoryHandle(FOLDER, { create: true });
    const name = crypto.randomUUID();
    const file = await folder.getFileHandle(name, { create: true });
    return new SpillFile(await file.createSyncAccessHandle(), () => folder.removeEntry(name));
  });
}

/** Removes files that no worker has open; resolves to whether none is left. */
async function clear() {
  const root = await navigator.storage.getDirectory();
  const folder = await root.getDirectoryHandle(FOLDER).catch(() => null);
  if (!folder) return true;
  const names = [];
  for await (const name of folder.keys()) names.push(name);
  // the browser does not remove a file that is open
  const removed = await Promise.allSettled(names.map((name) => folder.removeEntry(name)));
  return removed.every(({ status }) => status === 'fulfilled');
}

/** Removes the files of workers that were ended before their meshes were. */
export async function clearSpillFiles() {
  if (!globalThis.navigator?.storage?.getDirectory || !navigator.locks) return;
  for (const wait of WAITS) {
    await new Promise((resolve) => setTimeout(resolve, wait));
    // a private window may have no such file system, and no files
    if (await withLock(clear).catch(() => true)) return;
  }
}

/**
 * Makes a mesh with its columns in memory or, as `spill` says, in a file once they outgrow that.
 *
 * @template T
 * @param {'auto' | boolean} spill
 * @param {(open?: () => Promise<SpillFile>) => Promise<T>} make
 * @returns {Promise<T>}
 */
export async function spilling(spill, make) {
  // a private window may refuse
  const open = () => openSpillFile().catch(() => Promise.reject(NO_SPILL));
  if (spill === true) return make(open);
  return make().catch((error) => {
    // the estimate finds most of these errors, before a ray is cast
    if (spill === false || asError(error).code !== 'memory') throw error;
    return make(open).catch((again) => Promise.reject(again === NO_SPILL ? error : again));
  });
}

/**
 * Holds a lock, so that no file is removed between its creation and its opening.
 *
 * @template T
 * @param {() => Promise<T>} act
 * @returns {Promise<T>}
 */
async function withLock(act) {
  return navigator.locks.request(FOLDER, act);
}

/** What the wasm calls; a failure is thrown as a sentence. */
class SpillFile {
  #handle;
  #remove;
  #bytes = 0;

  /**
   * @param {FileSystemSyncAccessHandle} handle
   * @param {() => Promise<void>} remove
   */
  constructor(handle, remove) {
    this.#handle = handle;
    this.#remove = remove;
  }

  /**
   * Appends bytes and returns the offset of the first.
   *
   * @param {Uint8Array} bytes
   */
  append(bytes) {
    const at = this.#bytes;
    for (let done = 0; done < bytes.length; ) done += this.#act('write', bytes.subarray(done), at + done);
    this.#bytes += bytes.length;
    return at;
  }

  /**
   * Reads bytes from an offset.
   *
   * @param {number} at
   * @param {Uint8Array} bytes
   */
  read(at, bytes) {
    for (let done = 0; done < bytes.length; ) done += this.#act('read', bytes.subarray(done), at + done);
  }

  /** @param {number} bytes */
  truncate(bytes) {
    this.#handle.truncate(bytes);
    this.#bytes = bytes;
  }

  /**
   * Reads or writes; returns the number of bytes, which may be fewer than asked for.
   *
   * @param {'read' | 'write'} operation
   * @param {Uint8Array} bytes
   * @param {number} at
   */
  #act(operation, bytes, at) {
    let done;
    try {
      done = this.#handle[operation](bytes, { at });
    } catch (error) {
      throw `the browser's private files fail with "${error instanceof Error ? error.message : error}"; make room on the disk, or use larger cells`;
    }
    if (done === 0) throw `the browser's private files end at byte ${at}`;
    return done;
  }

  /** Closes and removes the file. */
  close() {
    this.#handle.close();
    // where this fails, the next mesher removes it
    this.#remove().catch(() => {});
  }
}

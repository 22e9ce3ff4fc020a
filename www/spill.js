/**
 * Columns outside memory: a temporary file in the origin's private file system (OPFS), which workers read and write without
 * waiting. It is removed with the mesh; those of workers that were ended meanwhile are removed later by others.
 */
import { errorFrom } from './error.js';

const FOLDER = 'hexcast-columns';
/** Milliseconds between attempts: a worker that was ended lets go of its files a moment later. */
const WAITS = [0, 50, 200, 1000, 4000];

/** Whether columns can spill on this thread: in workers of secure pages, not in Node. */
function canSpill() {
  const { navigator, FileSystemFileHandle } = globalThis;
  const hasFiles = typeof navigator?.storage?.getDirectory === 'function';
  return hasFiles && typeof FileSystemFileHandle?.prototype.createSyncAccessHandle === 'function';
}

/** Opens a file for the columns of one mesh. @returns {Promise<SpillFile>} */
async function openSpillFile() {
  return alone(async () => {
    const root = await navigator.storage.getDirectory();
    const folder = await root.getDirectoryHandle(FOLDER, { create: true });
    const name = crypto.randomUUID();
    const file = await folder.getFileHandle(name, { create: true });
    const handle = await file.createSyncAccessHandle?.();
    if (!handle) throw new Error('files cannot be written here without waiting');
    return new SpillFile(handle, () => folder.removeEntry(name));
  });
}

/** Removes files that no worker has open; resolves to whether none is left. */
async function clear() {
  const root = await navigator.storage.getDirectory();
  const folder = await root.getDirectoryHandle(FOLDER).catch(() => null);
  if (!folder) return true;
  const names = [];
  for await (const name of folder.keys()) names.push(name);
  // one that is open refuses
  const removed = await Promise.all(
    names.map((name) =>
      folder.removeEntry(name).then(
        () => true,
        () => false,
      ),
    ),
  );
  return removed.every(Boolean);
}

/** Removes what was left behind by workers that were ended with their meshes. */
export async function clearSpillFiles() {
  if (!globalThis.navigator?.storage?.getDirectory || !navigator.locks) return;
  for (const wait of WAITS) {
    await new Promise((resolve) => setTimeout(resolve, wait));
    // a private window may have no such file system: then there is nothing
    if (await alone(clear).catch(() => true)) return;
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
  const open = async () => {
    if (!canSpill()) throw NO_SPILL;
    // a private window may refuse
    return openSpillFile().catch(() => Promise.reject(NO_SPILL));
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

/**
 * Keeps files from being removed between their making and their opening.
 *
 * @template T
 * @param {() => Promise<T>} act
 * @returns {Promise<T>}
 */
async function alone(act) {
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
   * Appends bytes and returns the place of the first.
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
   * Reads bytes at a place.
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
    // what cannot be removed now is so later
    this.#remove().catch(() => {});
  }
}

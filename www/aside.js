/**
 * Columns outside memory: a temporary file in the origin's private file system (OPFS), which workers read and write without
 * waiting. It is removed with the mesh; those of workers that were ended meanwhile are removed later by others.
 */

const FOLDER = 'hexcast-columns';
/** Milliseconds between attempts: a worker that was ended lets go of its files a moment later. */
const WAITS = [0, 50, 200, 1000, 4000];

/** Whether columns can go aside on this thread: in workers of secure pages, not in Node. */
export function hasAside() {
  return Boolean(
    globalThis.navigator?.storage?.getDirectory && globalThis.FileSystemFileHandle?.prototype.createSyncAccessHandle,
  );
}

/** Opens a file for the columns of one mesh. @returns {Promise<AsideFile>} */
export async function openAside() {
  return alone(async () => {
    const root = await navigator.storage.getDirectory();
    const folder = await root.getDirectoryHandle(FOLDER, { create: true });
    const name = crypto.randomUUID();
    const file = await folder.getFileHandle(name, { create: true });
    return new AsideFile(await file.createSyncAccessHandle(), () => folder.removeEntry(name));
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
export async function clearAside() {
  if (!globalThis.navigator?.storage?.getDirectory || !navigator.locks) return;
  for (const wait of WAITS) {
    await new Promise((resolve) => setTimeout(resolve, wait));
    // a private window may have no such file system: then there is nothing
    if (await alone(clear).catch(() => true)) return;
  }
}

/** Keeps files from being removed between their making and their opening. */
function alone(act) {
  return navigator.locks.request(FOLDER, act);
}

/** What the wasm calls; a failure is thrown as a sentence. */
class AsideFile {
  #handle;
  #remove;
  #bytes = 0;

  constructor(handle, remove) {
    this.#handle = handle;
    this.#remove = remove;
  }

  /** Appends bytes and returns the place of the first. */
  append(bytes) {
    const at = this.#bytes;
    for (let done = 0; done < bytes.length; ) done += this.#act('write', bytes.subarray(done), at + done);
    this.#bytes += bytes.length;
    return at;
  }

  /** Reads bytes at a place. */
  read(at, bytes) {
    for (let done = 0; done < bytes.length; ) done += this.#act('read', bytes.subarray(done), at + done);
  }

  truncate(bytes) {
    this.#handle.truncate(bytes);
    this.#bytes = bytes;
  }

  /** Reads or writes; returns the number of bytes, which may be fewer than asked for. */
  #act(operation, bytes, at) {
    let done;
    try {
      done = this.#handle[operation](bytes, { at });
    } catch (error) {
      throw `the browser's private files fail with "${error.message}"; make room on the disk, or use larger cells`;
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

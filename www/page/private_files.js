/**
 * The origin's private file system (OPFS), for files too large for memory where the browser cannot ask for a place: a file
 * is streamed there and handed on from there.
 */

const FOLDER = 'hexcast-downloads';

let isHeld = false;

/**
 * Opens a file for writing; its handle gives the file once that is closed. @returns {Promise<FileSystemFileHandle>}
 *
 * @param {string} name
 */
export async function privateFile(name) {
  holdFolder();
  const root = await navigator.storage.getDirectory();
  return (await root.getDirectoryHandle(FOLDER, { create: true })).getFileHandle(name, { create: true });
}

/** Whether there is such a file system, and one that can be written from a page. */
export function hasPrivateFiles() {
  const hasFiles = typeof navigator.storage?.getDirectory === 'function';
  return hasFiles && typeof globalThis.FileSystemFileHandle?.prototype.createWritable === 'function';
}

/** Removes a file that will not be handed on. @param {string} name */
export async function removePrivate(name) {
  const root = await navigator.storage.getDirectory();
  await (await root.getDirectoryHandle(FOLDER)).removeEntry(name).catch(() => {});
}

/**
 * Removes what earlier visits left: nobody tells when the browser has copied a file to its place, so that it stays until
 * the next visit. Another page of ours that still needs its files holds the lock.
 */
export async function clearPrivate() {
  if (!hasPrivateFiles() || !navigator.locks) return;
  await navigator.locks
    .request(FOLDER, { ifAvailable: true }, async (lock) => {
      if (!lock) return;
      const root = await navigator.storage.getDirectory();
      await root.removeEntry(FOLDER, { recursive: true });
    })
    .catch(() => {}); // there was nothing, or a private window has no such file system
}

/** Keeps other pages from clearing the folder as long as this one lives. */
function holdFolder() {
  if (isHeld) return;
  isHeld = true;
  navigator.locks?.request(FOLDER, { mode: 'shared' }, () => new Promise(() => {}));
}

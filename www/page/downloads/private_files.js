/**
 * The origin's private file system (OPFS), for files too large for memory where the browser cannot ask the user for a place: a file
 * is streamed there and saved from there.
 */

const FOLDER = 'hexcast-downloads';

let isHeld = false;

/** Opens a file for writing; its handle returns the file once that is closed. @param {string} name */
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

/** Removes a file that will not be saved. @param {string} name */
export async function removePrivate(name) {
  const root = await navigator.storage.getDirectory();
  await (await root.getDirectoryHandle(FOLDER)).removeEntry(name).catch(() => {});
}

/**
 * Removes the files of earlier visits: the browser does not report when it has copied a file to its place, so the file stays until
 * the next visit. Another page that still needs its files holds the lock.
 */
export async function clearPrivate() {
  if (!hasPrivateFiles() || !navigator.locks) return;
  await navigator.locks
    .request(FOLDER, { ifAvailable: true }, async (lock) => {
      if (!lock) return;
      const root = await navigator.storage.getDirectory();
      await root.removeEntry(FOLDER, { recursive: true });
    })
    .catch(() => {}); // the folder does not exist, or a private window has no such file system
}

/** Keeps other pages from clearing the folder while this page is open. */
function holdFolder() {
  if (isHeld) return;
  isHeld = true;
  navigator.locks?.request(FOLDER, { mode: 'shared' }, () => new Promise(() => {}));
}

/**
 * The session: files and settings of this visit, kept in the origin's private file system (OPFS). The next visit asks whether
 * to open them again; who says yes is not asked any more, until they say forget. Where a browser has no such file system, or the files are too large for it, it asks before the page is left.
 */
import { debounce } from '../elements/dom.js';
import { addFiles } from '../geometries/files.js';
import { showError, showNotice } from '../elements/messages.js';
import { hasPrivateFiles } from '../downloads/private_files.js';
import { hashOf, openHash } from '../settings/share.js';
import { on, state } from '../state/state.js';

/** @typedef {{ key: string, name: string }[]} Kept what `session.json` holds */

/** Folder of the files, and key of the settings: these are few, and written at once. */
const FOLDER = 'hexcast-session';
const LIST = 'session.json';
/** Key of the answer in the browser's storage. */
const ANSWER = `${FOLDER}-opens`;
/** More bytes of files are not kept: writing and reading them again would take the memory that meshing needs. */
const MAX_BYTES = 250e6;

/** Keys of the files in the folder. @type {Set<string>} */
const stored = new Set();
/** @type {Promise<unknown>} */
let queue = Promise.resolve();

/** Asks for the last session, and keeps this one. @param {boolean} hasSample whether the address names a sample */
export async function startSession(hasSample) {
  addEventListener('beforeunload', (event) => {
    if ((!hasPrivateFiles() || isTooLarge()) && ownFiles().length > 0) event.preventDefault();
  });
  if (!hasPrivateFiles()) return;
  if (!hasSample) await ask().catch(() => {});
  const keepLater = debounce(() => (queue = queue.then(keep).catch(() => {})), 300);
  on('geometries', () => (state.geometries.length > 0 || stored.size > 0) && keepLater());
  const keepSettingsToo = () => state.geometries.length > 0 && keepSettings();
  on(['geometries', 'settings', 'colours'], keepSettingsToo);
  on(['look', 'legend'], debounce(keepSettingsToo, 200));
}

function keepSettings() {
  try {
    localStorage.setItem(FOLDER, hashOf());
  } catch {
    // the user forbids it, or it is full: the files are kept without their settings
  }
}

/** Geometries that the page cannot make by itself. */
function ownFiles() {
  return state.geometries.filter(({ sample }) => !sample);
}

/** Whether the files of this visit are too large to be kept. */
function isTooLarge() {
  return ownFiles().reduce((sum, { source }) => sum + source.size, 0) > MAX_BYTES;
}

async function folder(create = false) {
  const root = await navigator.storage.getDirectory();
  return root.getDirectoryHandle(FOLDER, { create });
}

/** Offers the files of the last visit. */
async function ask() {
  const place = await folder();
  const list = await (await place.getFileHandle(LIST)).getFile();
  /** @type {Kept} */
  const files = JSON.parse(await list.text());
  if (files.length === 0) return;
  const names =
    files.length > 3 ? `${files[0].name} and ${files.length - 1} other files` : files.map(({ name }) => name).join(', ');
  const open = async () => {
    try {
      const sources = await Promise.all(
        files.map(async ({ key, name }) => {
          const file = await (await place.getFileHandle(key)).getFile();
          // its copy here may be removed while it is used
          return { source: new File([await file.arrayBuffer()], name) };
        }),
      );
      openHash(localStorage.getItem(FOLDER) ?? '');
      await addFiles(sources);
    } catch (error) {
      showError(error, 'The last visit');
    }
  };
  const toForget = {
    label: 'Forget',
    act: () => {
      remember(false);
      forget();
    },
  };
  // a link has settings of its own
  const isSame = ['', localStorage.getItem(FOLDER)].includes(location.hash.slice(1));
  if (localStorage.getItem(ANSWER) === 'yes' && isSame) {
    await open();
    return showNotice(`the last visit had ${names}, which are open again`, 'opened', toForget);
  }
  const toOpen = {
    label: 'Open again',
    act: () => {
      remember(true);
      open();
    },
  };
  return showNotice(`the last visit had ${names}`, 'session', toOpen, toForget);
}

/** Keeps the answer: whether files are opened without a question. @param {boolean} isYes */
function remember(isYes) {
  try {
    if (isYes) localStorage.setItem(ANSWER, 'yes');
    else localStorage.removeItem(ANSWER);
  } catch {
    // it is asked again
  }
}

async function forget() {
  const root = await navigator.storage.getDirectory();
  stored.clear();
  localStorage.removeItem(FOLDER);
  await root.removeEntry(FOLDER, { recursive: true }).catch(() => {});
}

/** Writes what is new and removes what is gone. */
async function keep() {
  const own = ownFiles();
  if (own.length === 0 || isTooLarge()) return forget();
  // the question is answered by other files
  for (const box of document.querySelectorAll('[data-about=session]')) box.remove();
  const place = await folder(true);
  // only arrays have no hash, and nobody drops those
  const files = own.map(({ info, source }) => ({ key: /** @type {string} */ (info.blake3), name: source.name }));
  for (const [at, { key }] of files.entries()) {
    if (stored.has(key)) continue;
    await write(place, key, own[at].source);
    stored.add(key);
  }
  await write(place, LIST, JSON.stringify(files));
  for await (const name of place.keys()) {
    if (name !== LIST && !files.some(({ key }) => key === name)) await place.removeEntry(name);
  }
  for (const key of stored) if (!files.some((file) => file.key === key)) stored.delete(key);
  return undefined;
}

/** @param {FileSystemDirectoryHandle} place @param {string} name @param {Blob | string} content */
async function write(place, name, content) {
  const stream = await (await place.getFileHandle(name, { create: true })).createWritable();
  await stream.write(content);
  await stream.close();
}

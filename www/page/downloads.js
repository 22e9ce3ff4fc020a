/** Files out: streamed to disk where the browser lets the user pick a place, through its private file system or a Blob elsewhere. */
import { byId, make } from './dom.js';
import { bytes } from './format.js';
import { showError } from './messages.js';
import { hasPrivateFiles, privateFile, removePrivate } from './private_files.js';
import { baseName } from './share.js';
import { on, state } from './state.js';

/** Files from this size on go through the private file system rather than through memory. */
const BLOB_BYTES = 256e6;

/**
 * A file that the page makes; one without a format is a description.
 *
 * @typedef {object} FileKind
 * @property {string} id
 * @property {string} extension
 * @property {import('hexcast').Format} [format]
 * @property {import('hexcast').WriteOptions} [options]
 * @property {string} label
 * @property {string} note
 *
 * @typedef {import('hexcast').Mesh} Mesh
 */

/** @type {FileKind[]} */
const FILES = [
  { id: 'vti', extension: 'vti', format: 'vti', label: 'VTK image', note: 'ParaView, VisIt' },
  {
    id: 'vtiz',
    extension: 'vti',
    format: 'vti',
    options: { compress: 6 },
    label: 'VTK image, compressed',
    note: 'ParaView, VisIt',
  },
  { id: 'npy', extension: 'npy', format: 'npy', label: 'NumPy', note: 'shape nz, ny, nx' },
  { id: 'raw', extension: 'raw', format: 'raw', label: 'Raw', note: 'one byte a cell, x fastest' },
  { id: 'sidecar', extension: 'raw.json', label: 'Raw: description', note: 'dims, lines, names' },
  {
    id: 'npy-bits',
    extension: 'bits.npy',
    format: 'npy',
    options: { bits: true },
    label: 'NumPy, packed',
    note: 'eight cells a byte',
  },
  {
    id: 'raw-bits',
    extension: 'bits.raw',
    format: 'raw',
    options: { bits: true },
    label: 'Raw, packed',
    note: 'eight cells a byte',
  },
  {
    id: 'sidecar-bits',
    extension: 'bits.raw.json',
    options: { bits: true },
    label: 'Packed: description',
    note: 'dims, lines, names',
  },
  { id: 'hxc', extension: 'hxc', format: 'hxc', label: 'Column file', note: 'small; opens here again' },
];

/** Draws the list of files whenever there is a mesh. */
export function startDownloads() {
  on('mesh', show);
}

function show() {
  const { mesh } = state;
  // a bit tells one flag from the background, no more
  const files = FILES.filter((file) => !file.options?.bits || mesh?.report.flags.length === 1);
  byId('downloads').replaceChildren(...(mesh ? files.map((file) => entry(mesh, file)) : []));
}

/** @param {Mesh} mesh @param {FileKind} file */
function entry(mesh, file) {
  const size = file.format ? mesh.size(file.format, file.options) : null;
  const text = size !== null ? bytes(size) : guess(mesh, file);
  const button = make('button', {
    type: 'button',
    id: `download-${file.id}`,
    on: { click: () => download(mesh, file, button, status) },
  });
  const status = make('span', { className: 'note', role: 'status' });
  const label = make('span', {}, file.label, make('small', {}, `.${file.extension}: ${file.note}`));
  button.append(label, make('span', { className: 'size', 'data-bytes': size }, text));
  return make('li', {}, button, status);
}

/** Sizes that depend on the flags, and on the digits of the mesh lines. @param {Mesh} mesh @param {FileKind} file */
function guess(mesh, { id }) {
  if (id.startsWith('sidecar')) return `about ${bytes(700 + 20 * mesh.dims.reduce((sum, n) => sum + n + 1, 0))}`;
  if (id === 'hxc') return `up to ${bytes(columnBytes(mesh))}`;
  // a mesh that was read back has no estimate
  return state.expected ? `up to ${bytes(state.expected.file_bytes.vti_zlib)}` : `less than ${bytes(mesh.size('vti') ?? 0)}`;
}

/** @param {Mesh} mesh @param {FileKind} file @param {HTMLButtonElement} button @param {HTMLElement} status */
async function download(mesh, file, button, status) {
  const name = `${baseName(state.job)}.${file.extension}`;
  const stop = new AbortController();
  const cancel = make('button', { type: 'button', className: 'small', on: { click: () => stop.abort() } }, 'Cancel');
  button.disabled = true;
  try {
    // the picker must be asked while the click is fresh: before anything is awaited
    const handle = await pick(name);
    status.after(cancel);
    const onProgress = (/** @type {import('hexcast').Progress} */ { done, total }) =>
      (status.textContent = `${bytes(done)}${total > done ? ` of ${bytes(total)}` : ''}`);
    const options = { ...file.options, signal: stop.signal, onProgress };
    if (!file.format) await saveTo(handle, new Blob([await mesh.sidecar(options)], { type: 'application/json' }), name);
    else if (handle) await mesh.stream(file.format, options).pipeTo(await handle.createWritable(), { signal: stop.signal });
    else if (sizeAtMost(mesh, file.format, options) >= BLOB_BYTES && hasPrivateFiles())
      await throughPrivate(mesh, file.format, options, name);
    else saveAs(await mesh.blob(file.format, options), name);
    status.textContent = 'Saved.';
  } catch (error) {
    status.textContent = error instanceof DOMException && error.name === 'AbortError' ? 'Cancelled.' : '';
    showError(error, name);
  } finally {
    cancel.remove();
    button.disabled = false;
  }
}

/**
 * Bytes of a file, or more where they depend on the flags: compressed flags are smaller than the others.
 *
 * @param {Mesh} mesh
 * @param {import('hexcast').Format} format
 * @param {import('hexcast').WriteOptions} options
 */
function sizeAtMost(mesh, format, options) {
  return mesh.size(format, options) ?? (format === 'hxc' ? columnBytes(mesh) : 0);
}

/** Bytes of the columns, in memory and spilled. @param {Mesh} mesh */
function columnBytes({ columns, report }) {
  return columns.bytes + spilledBytes(report);
}

/** Bytes of the columns that spilled. @param {import('hexcast').Report} report */
export function spilledBytes(report) {
  const { aside } = /** @type {{ aside?: number }} */ (report.peak_bytes ?? {});
  return aside ?? 0;
}

/** Asks for a place, or null where the browser has no such dialogue. @param {string} name */
async function pick(name) {
  return (await globalThis.showSaveFilePicker?.({ suggestedName: name })) ?? null;
}

/**
 * Streams into the origin's private file system and hands the file on from there: memory holds a few pieces only.
 *
 * @param {Mesh} mesh
 * @param {import('hexcast').Format} format
 * @param {import('hexcast').WriteOptions} options
 * @param {string} name
 */
async function throughPrivate(mesh, format, options, name) {
  try {
    const handle = await privateFile(name);
    await mesh.stream(format, options).pipeTo(await handle.createWritable(), { signal: options.signal });
    saveAs(await handle.getFile(), name);
  } catch (error) {
    await removePrivate(name);
    throw error;
  }
}

/** @param {FileSystemFileHandle | null} handle @param {Blob} blob @param {string} name */
async function saveTo(handle, blob, name) {
  if (!handle) return saveAs(blob, name);
  const writable = await handle.createWritable();
  await writable.write(blob);
  return writable.close();
}

/** Saves a small file, such as a picture or the report. @param {Blob} blob @param {string} name */
export function save(blob, name) {
  saveAs(blob, name);
}

/** @param {Blob} blob @param {string} name */
function saveAs(blob, name) {
  const url = URL.createObjectURL(blob);
  const link = make('a', { href: url, download: name });
  document.body.append(link);
  link.click();
  link.remove();
  // the browser reads the file after the click; a minute is ample even for a slow dialogue
  setTimeout(() => URL.revokeObjectURL(url), 60_000);
}

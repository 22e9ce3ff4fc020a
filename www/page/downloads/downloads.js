/** Downloads: streamed to disk where the browser lets the user pick a place, through its private file system or a Blob elsewhere. */
import { formats } from 'hexcast';
import { make } from '../elements/dom.js';
import { bytes } from '../text/format.js';
import { showError } from '../elements/messages.js';
import { hasPrivateFiles, privateFile, removePrivate } from './private_files.js';
import { holding } from '../state/held.js';
import { baseName } from '../settings/share.js';
import { state } from '../state/state.js';

/** Files from this size on go through the private file system rather than through memory. */
const BLOB_BYTES = 256e6;

/**
 * A file that the page offers; one without a format is a description.
 *
 * @typedef {object} FileKind
 * @property {string} id
 * @property {string} extension
 * @property {import('hexcast').Format} [format]
 * @property {import('hexcast').WriteOptions} [options]
 * @property {string} label
 * @property {string} note
 * @property {string} [name] that the file must have, whatever the model
 *
 * @typedef {import('hexcast').Mesh} Mesh
 */

/** A file of a list: its button and what becomes of it. @param {Mesh} mesh @param {FileKind} file */
export function entry(mesh, file) {
  const size = file.format ? mesh.size(file.format, file.options) : null;
  const text = size !== null ? bytes(size) : guess(mesh, file);
  const button = make('button', {
    type: 'button',
    id: `download-${file.id}`,
    on: { click: () => download(mesh, file, button, status) },
  });
  const status = make('span', { className: 'note', role: 'status' });
  const label = make('span', {}, `${file.label} `, make('small', {}, `.${file.extension}: ${file.note}`));
  button.append(label, make('span', { className: 'size', 'data-bytes': size }, text));
  return make('li', {}, button, status);
}

/** Sizes that depend on the flags, and on the digits of the mesh lines. @param {Mesh} mesh @param {FileKind} file */
function guess(mesh, { id, format }) {
  if (!format) return `about ${bytes(700 + 20 * mesh.dims.reduce((sum, n) => sum + n + 1, 0))}`;
  if (formats[format].kind === 'export') return '';
  if (id in PER_ENTRY) return `up to ${bytes(PER_ENTRY[id] * entriesOf(mesh, id))}`;
  if (id === 'hxc') return `up to ${bytes(columnBytes(mesh))}`;
  const nLines = mesh.dims.reduce((sum, n) => sum + n + 1, 0);
  // a store says twice what it is
  const ofStore = 20_000 + 80 * nLines;
  if (format === 'zarr') return `less than ${bytes(mesh.report.cells + ofStore)}`;
  if (format.startsWith('distance.')) return `less than ${bytes(8 * mesh.report.cells + ofStore)}`;
  if (format.startsWith('fractions.')) return `less than ${bytes(4 * mesh.report.cells + ofStore)}`;
  // the lines are 8 bytes each
  const lines = mesh.lines.spacing && format !== 'npz' ? 0 : 1500 + 8 * nLines;
  // a mesh that was read back has no estimate
  return state.expected
    ? `up to ${bytes(state.expected.file_bytes.vti_zlib + lines)}`
    : `less than ${bytes(mesh.size('vti', { compress: 0 }) ?? 0)}`;
}

/** Bytes of an entry of what was measured, before it is compressed. @type {Record<string, number>} */
const PER_ENTRY = { links: 24, 'links-hdf5': 24, fractions: 220, staggered: 7, conformal: 48, tensors: 144 };

/** @param {Mesh} mesh @param {string} of */
function entriesOf({ report }, of) {
  // few cells that are cut have more than three flags
  if (of.startsWith('links')) return report.links?.links ?? 0;
  return { fractions: 3 * (report.fractions?.cut_cells ?? 0) }[of] ?? 1.2 * report.cells;
}

/** What a file is called. @param {FileKind} file */
export function nameOf({ name, extension }) {
  return name ?? `${baseName(state.job)}.${extension}`;
}

/** Saves a file, with what becomes of it beside the button. @param {Mesh} mesh @param {FileKind} file @param {HTMLButtonElement} button @param {HTMLElement} status */
export function download(mesh, file, button, status) {
  return holding(mesh, () => write(mesh, file, button, status));
}

/** @param {Mesh} mesh @param {FileKind} file @param {HTMLButtonElement} button @param {HTMLElement} status */
async function write(mesh, file, button, status) {
  const name = nameOf(file);
  const stop = new AbortController();
  const cancel = make('button', { type: 'button', className: 'small', on: { click: () => stop.abort() } }, 'Cancel');
  button.disabled = true;
  try {
    // the picker must be asked while the click is fresh: before anything is awaited
    const handle = await pick(name);
    status.after(cancel);
    const onProgress = (/** @type {import('hexcast').Progress} */ { done, total }) =>
      (status.textContent = `${bytes(done)}${total > done ? ` of ${bytes(total)}` : ''}`);
    /** @type {string[]} */
    const lacks = [];
    const { format } = file;
    const onLack = (/** @type {string} */ lack) => lacks.push(lack);
    const options = { ...file.options, signal: stop.signal, onProgress, ...(format && { onLack }) };
    const blob = async () =>
      format ? mesh.blob(format, options) : new Blob([await mesh.sidecar(options)], { type: 'application/json' });
    if (handle) {
      const stream = format ? mesh.stream(format, options) : (await blob()).stream();
      await stream.pipeTo(await handle.createWritable(), { signal: stop.signal });
    } else if (format && sizeAtMost(mesh, format, options) >= BLOB_BYTES && hasPrivateFiles()) {
      await throughPrivate(mesh, format, options, name);
    } else save(await blob(), name);
    status.textContent = ['Saved.', ...lacks.map((lack) => `It lacks something: ${lack}.`)].join(' ');
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
  const export_ = formats[format].kind === 'export' ? EXPORT_BYTES * mesh.report.cells : 0;
  return mesh.size(format, options) ?? (format === 'hxc' ? columnBytes(mesh) : export_);
}

/** Bytes of a cell in the longest files for solvers, about. */
const EXPORT_BYTES = 200;

/** Bytes of the columns, in memory and spilled. @param {Mesh} mesh */
function columnBytes({ columns, report }) {
  return columns.bytes + spilledBytes(report);
}

/** Bytes of the columns that spilled. @param {import('hexcast').Report} report */
export function spilledBytes(report) {
  return report.peak_bytes?.spilled ?? 0;
}

/** Asks for a place, or null where the browser has no such dialogue. @param {string} name */
async function pick(name) {
  return (await globalThis.showSaveFilePicker?.({ suggestedName: name })) ?? null;
}

/**
 * Streams a file into the origin's private file system and saves it from there: memory holds a few pieces only.
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
    save(await handle.getFile(), name);
  } catch (error) {
    await removePrivate(name);
    throw error;
  }
}

/** Hands a file to the browser, which saves it. @param {Blob} blob @param {string} name */
export function save(blob, name) {
  const url = URL.createObjectURL(blob);
  const link = make('a', { href: url, download: name });
  document.body.append(link);
  link.click();
  link.remove();
  // the browser reads the file after the click; a minute is ample even for a slow dialogue
  setTimeout(() => URL.revokeObjectURL(url), 60_000);
}

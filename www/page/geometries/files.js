/** Files that are opened: dropped anywhere on the page, chosen, or a sample. Those of lines end in `.json`. */
import { settingsOf, warnOfSize } from './cad.js';
import { byId, make, onInput, pause } from '../elements/dom.js';
import { clearMessages, showError, showNotice } from '../elements/messages.js';
import { realFiles } from './real_models.js';
import { SAMPLES } from './samples.js';
import { takeLines } from '../settings/lines.js';
import { takeExpected } from '../settings/share.js';
import { endUpdate } from '../run/run.js';
import { release } from '../state/held.js';
import { currentJob, keyOfCells } from '../state/job.js';
import { PLAIN, change, freeFlag, isSame, set, state } from '../state/state.js';
import { readSurface } from './surfaces.js';

/**
 * @typedef {Partial<import('../state/state.js').Geometry>} GeometrySettings
 * @typedef {{ source: File, settings?: GeometrySettings }} FileIn a file, and settings of its geometry
 */

/** What the page shows to who comes without a file. */
const ARRIVAL = { sample: 'gear', words: 'a gear' };

let nextId = 1;
/** @type {Promise<void>} */
let queue = Promise.resolve();

/** Connects the drop zone, the choosers and the samples. */
export function startFiles() {
  const choose = (/** @type {string} */ input, /** @type {string} */ button) => {
    byId(button).addEventListener('click', () => byId(input).click());
    onInput(input, 'change', (target) => {
      addFiles(withoutSettings(target.files ?? []), { isFolder: input === 'folder-input' });
      target.value = '';
    });
  };
  choose('file-input', 'choose');
  choose('folder-input', 'choose-folder');
  choose('lines-input', 'choose-lines');
  for (const list of document.querySelectorAll('.samples')) {
    for (const { id, title } of SAMPLES) {
      list.append(make('button', { type: 'button', 'data-sample': id, on: { click: () => addSample(id) } }, title));
    }
  }
  startDropping();
}

/** @param {Iterable<File>} files */
const withoutSettings = (files) => Array.from(files, (source) => ({ source }));

function startDropping() {
  let depth = 0;
  const over = (/** @type {boolean} */ isOver) => document.body.classList.toggle('dropping', isOver);
  // not where a card is dragged
  const hasFiles = (/** @type {DragEvent} */ event) => event.dataTransfer?.types.includes('Files');
  addEventListener('dragenter', (event) => hasFiles(event) && over(++depth > 0));
  addEventListener('dragleave', (event) => hasFiles(event) && over(--depth > 0));
  addEventListener('dragover', (event) => event.preventDefault());
  addEventListener('drop', async (event) => {
    // where it was dropped took it
    const isTaken = event.defaultPrevented;
    event.preventDefault();
    depth = 0;
    over(false);
    if (isTaken) return;
    // entries must be taken before the first await: the list is emptied after the event
    const entries = [...(event.dataTransfer?.items ?? [])]
      .filter((item) => item.kind === 'file')
      .map((item) => item.webkitGetAsEntry?.() ?? item.getAsFile());
    try {
      const isFolder = entries.some((entry) => entry && 'isDirectory' in entry && entry.isDirectory);
      addFiles(withoutSettings((await Promise.all(entries.map(filesOf))).flat()), { isFolder });
    } catch (error) {
      showError(error);
    }
  });
}

/** All files of an entry, folders opened. @param {FileSystemEntry | File | null} entry @returns {Promise<File[]>} */
async function filesOf(entry) {
  if (!entry) return [];
  if (entry instanceof File) return [entry];
  if (entry.isFile) {
    const ofFile = /** @type {FileSystemFileEntry} */ (entry);
    return [await new Promise((resolve, reject) => ofFile.file(resolve, reject))];
  }
  const reader = /** @type {FileSystemDirectoryEntry} */ (entry).createReader();
  /** @type {FileSystemEntry[]} */
  const entries = [];
  for (;;) {
    // a call gives at most a hundred
    /** @type {FileSystemEntry[]} */
    const some = await new Promise((resolve, reject) => reader.readEntries(resolve, reject));
    if (some.length === 0) break;
    entries.push(...some);
  }
  return (await Promise.all(entries.map(filesOf))).flat();
}

/** @param {string} id @returns {Promise<FileIn[]>} */
async function sampleFiles(id) {
  const real = await realFiles(id);
  return real.length > 0 ? real : (await import('./sample_models.js')).sampleFiles(id);
}

/** Replaces all geometries by a sample. @param {string} id */
export function addSample(id) {
  return addFiles(sampleFiles(id), { sample: id });
}

/** Shows a real part to who comes without a file; it goes as soon as others are added. */
export function arrive() {
  return addFiles(sampleFiles(ARRIVAL.sample), { sample: ARRIVAL.sample, isArrival: true });
}

/**
 * Reads files one after another and adds their geometries; those of a sample replace all others. A file that cannot be read is
 * reported, and changes nothing.
 *
 * @param {FileIn[] | Promise<FileIn[]>} files
 * @param {{ isFolder?: boolean, sample?: string | null, isArrival?: boolean }} [options]
 */
export function addFiles(files, { isFolder = false, sample = null, isArrival = false } = {}) {
  const read = async () => {
    // somebody was faster
    if (isArrival && state.geometries.length > 0) return;
    await readFiles(await files, { isFolder, sample, isArrival });
    if (isArrival) showArrival();
  };
  queue = queue.then(read).catch((error) => showError(error));
  return queue;
}

/** @param {FileIn[]} files @param {{ isFolder: boolean, sample: string | null, isArrival: boolean }} how */
async function readFiles(files, { isFolder, sample, isArrival }) {
  if (files.length === 0) return;
  await isQuiet();
  const { mesher } = state;
  if (!mesher) return;
  clearMessages();
  const replaces = state.isArrival && files.some(({ source }) => !/\.json$/i.test(source.name));
  if (sample || replaces) {
    for (const geometry of state.geometries) geometry.surface.dispose();
    change('geometries', { geometries: [], isArrival });
  }
  const wanted = isFolder
    ? files.filter(({ source }) => /\.(stl|obj|ply|off|3mf|glb|step|stp|iges|igs|hxc)(\.gz)?$/i.test(source.name))
    : files;
  if (wanted.length === 0) showNotice('the folder has no file of a surface (STL, OBJ, PLY, OFF, 3MF, GLB, STEP, IGES)');
  change('phase', { phase: 'reading' });
  for (const file of wanted) await addFile(mesher, file, sample);
  change('phase', { phase: 'idle' });
}

/** Says that what is shown is a sample. */
function showArrival() {
  if (state.geometries.length === 0) return;
  showNotice(`this is a sample, ${ARRIVAL.words}: drop your own files anywhere on the page`, 'arrival');
}

/** Resolves once no mesher starts and no mesh is made. */
export async function isQuiet() {
  await endUpdate();
  while (['starting', 'meshing', 'updating'].includes(state.phase)) await pause(50);
}

/** @param {import('hexcast').Mesher} mesher @param {FileIn} file @param {string | null} sample */
async function addFile(mesher, { source, settings = {} }, sample) {
  byId('status').textContent = `Reading ${source.name} …`;
  try {
    if (/\.hxc$/i.test(source.name)) {
      const mesh = await mesher.open(source);
      release(state.mesh);
      // until something changes, the page keeps it
      const left = { key: keyOfCells(currentJob()), mesher };
      change('mesh', { mesh, job: { geometries: [{ file: source.name }] }, runs: null, expected: null, left });
    } else if (/\.json$/i.test(source.name)) {
      await takeLines(source);
    } else {
      await warnOfSize(source);
      const read = await readSurface(mesher, source);
      takeUnit(read.info.unit);
      addGeometry(read, source, sample, settings);
    }
    byId('status').textContent = `Read ${source.name}.`;
  } catch (error) {
    const isCancelled = error instanceof DOMException && error.name === 'AbortError';
    byId('status').textContent = isCancelled ? `Cancelled; ${source.name} was not read.` : '';
    showError(error, source.name);
  }
}

/** The unit of the first file is that of the settings, if it says one and they do not. @param {string | null} unit */
function takeUnit(unit) {
  if (!unit || state.settings.unit || state.geometries.length > 0) return;
  set({ unit: unit === 'um' ? 'µm' : unit });
}

/**
 * @param {Awaited<ReturnType<typeof readSurface>>} read
 * @param {File} source
 * @param {string | null} sample
 * @param {GeometrySettings} given
 */
function addGeometry(read, source, sample, given) {
  const { colour, ...linked } = takeExpected(source.name);
  // commas and colons separate the settings of a file on the command line
  const name = source.name.replace(/\.[^.]*$/, '').replace(/[,:]/g, ' ');
  const isLinked = Object.keys(linked).length > 0;
  const unsaid = { ...PLAIN, name, flag: freeFlag(), ...settingsOf(read.cad, isLinked) };
  const geometry = { id: nextId++, source, sample, ...read, ...unsaid, ...given, ...linked };
  for (const [at, body] of (geometry.split ? (read.cad?.bodies ?? []) : []).entries())
    if (body.colour) state.colours.set(geometry.flag + at, body.colour);
  if (colour) state.colours.set(geometry.flag, colour);
  const twin = state.geometries.find((other) => isSame(other, geometry));
  change('geometries', { geometries: [...state.geometries, geometry] });
  if (!twin) return;
  const text = `the surface of ${source.name} is that of ${twin.source.name}, at the same place: the later gets all cells of both`;
  showNotice(text, 'files', { label: 'Remove the copy', act: () => removeGeometry(geometry.id) });
}

/** Puts a file in the place of some geometries; it has the settings of the first. @param {import('../state/state.js').Geometry[]} parts @param {File} source */
export async function replaceGeometries(parts, source) {
  const { mesher } = state;
  if (!mesher) return;
  const read = await readSurface(mesher, source);
  const { flag, priority, scale, rotate, about, translate } = parts[0];
  const name = source.name.replace(/\.[^.]*$/, '');
  const joined = { ...PLAIN, id: nextId++, source, sample: null, ...read, name, flag, priority, scale, rotate, about, translate };
  for (const { surface } of parts) surface.dispose();
  change('geometries', {
    geometries: state.geometries.flatMap((geometry) => {
      if (geometry === parts[0]) return [joined];
      return parts.includes(geometry) ? [] : [geometry];
    }),
  });
}

/** Reads all files again into a new mesher; the settings stay. @param {import('hexcast').Mesher} mesher */
export async function readAgain(mesher) {
  const kept = [];
  for (const geometry of state.geometries) {
    try {
      kept.push({ ...geometry, ...(await readSurface(mesher, geometry.source)) });
    } catch (error) {
      showError(error, geometry.source.name);
    }
  }
  change('geometries', { geometries: kept });
  byId('status').textContent = '';
}

/**
 * Goes back to geometries that were there before; those that were removed meanwhile are read again.
 *
 * @param {import('../state/state.js').Geometry[]} wanted
 */
export async function restoreGeometries(wanted) {
  const { mesher } = state;
  if (!mesher) return;
  const live = new Map(state.geometries.map((geometry) => [geometry.id, geometry]));
  change('phase', { phase: 'reading' });
  const geometries = [];
  for (const geometry of wanted) {
    const there = live.get(geometry.id);
    const { surface, info, corners, cad } = there ?? (await readSurface(mesher, geometry.source));
    geometries.push({ ...geometry, surface, info, corners, cad });
  }
  for (const { id, surface } of live.values()) if (!wanted.some((geometry) => geometry.id === id)) surface.dispose();
  change('geometries', { geometries, revision: state.revision + 1 });
  change('phase', { phase: 'idle' });
}

/** Removes one geometry. @param {number} id */
export function removeGeometry(id) {
  // a mesh of it, which nobody asked for, would be shown for a moment
  endUpdate();
  state.geometries.find((geometry) => geometry.id === id)?.surface.dispose();
  change('geometries', { geometries: state.geometries.filter((geometry) => geometry.id !== id) });
  if (state.geometries.length === 0) set({ domain: null });
}

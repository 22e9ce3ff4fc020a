/** All files that the mesh can be, in one list that is searched, and the options that they have. */
import { formats } from 'hexcast';
import { byId, inputOf, onInput, selectOf } from '../elements/dom.js';
import { entry } from './downloads.js';
import { PROGRAMS } from './programs.js';
import { numbersOf } from '../text/format.js';
import { on, state } from '../state/state.js';

/** @typedef {import('./downloads.js').FileKind} FileKind @typedef {import('hexcast').Mesh} Mesh @typedef {import('hexcast').Format} Format */

/** Cell sizes that differ by less are equal. */
const ROUNDING = 1e-9;
const [BITS, PLAIN, PACKED] = [{ bits: true }, { compress: 0 }, { compress: 6 }];

/** @type {(id: string, extension: string, label: string, note: string, more?: Partial<FileKind>) => FileKind} */
const file = (id, extension, label, note, more) => ({ id, extension, label, note, ...more });
const FILES = [
  file('vti', 'vti', 'VTK image', 'ParaView, VisIt', { format: 'vti', options: PLAIN }),
  file('vtiz', 'zlib.vti', 'VTK image, compressed', 'ParaView, VisIt', { format: 'vti', options: PACKED }),
  file('vtr', 'vtr', 'VTK rectilinear grid', 'ParaView, VisIt', { format: 'vtr', options: PLAIN }),
  file('vtrz', 'zlib.vtr', 'VTK rectilinear grid, compressed', 'ParaView, VisIt', { format: 'vtr', options: PACKED }),
  file('npz', 'npz', 'NumPy, with lines', 'flags and lines, compressed', { format: 'npz', options: PACKED }),
  file('npy', 'npy', 'NumPy', 'an array of flags', { format: 'npy' }),
  file('raw', 'raw', 'Raw', 'one byte a cell', { format: 'raw' }),
  file('sidecar', 'raw.json', 'Raw: description', 'dims, lines, names'),
  file('npy-bits', 'bits.npy', 'NumPy, packed', 'eight cells a byte', { format: 'npy', options: BITS }),
  file('raw-bits', 'bits.raw', 'Raw, packed', 'eight cells a byte', { format: 'raw', options: BITS }),
  file('sidecar-bits', 'bits.raw.json', 'Packed: description', 'dims, lines, names', { options: BITS }),
  file('hxc', 'hxc', 'Column file', 'small; this page opens it again', { format: 'hxc' }),
  file('zarr', 'zarr.zip', 'Zarr', 'a store in an archive: zarr-python, xarray', { format: 'zarr', options: PACKED }),
  file('links', 'links.npz', 'Links to walls', 'NumPy, compressed', { format: 'links.npz', options: PACKED }),
  file('links-hdf5', 'links.h5', 'Links to walls, as HDF5', 'compressed', { format: 'links.h5', options: PACKED }),
  file('links-records', 'links', 'Links to walls, as records', '24 bytes each', { format: 'links' }),
  file('fractions', 'fractions.npz', 'Fractions of cells', 'NumPy, compressed', { format: 'fractions.npz', options: PACKED }),
  ...['vti', 'vtr', 'npy', 'zarr'].map((ending) => {
    const format = /** @type {Format} */ (`fractions.${ending}`);
    const [extension, options] = [ending === 'zarr' ? 'zarr.zip' : ending, ending === 'npy' ? {} : PACKED];
    return file(`solid-${ending}`, `solid.${extension}`, 'Solid fraction', 'of every cell', { format, options });
  }),
  file('staggered', 'staggered.npz', 'Staggered grid', 'NumPy, compressed', { format: 'staggered.npz', options: PACKED }),
  file('conformal', 'conformal.npz', 'Edges and faces outside metal', 'NumPy, compressed', {
    format: 'conformal.npz',
    options: PACKED,
  }),
  ...['npz', 'h5', 'vti', 'vtr'].map((ending) => {
    const [id, format] = [`distance-${ending}`, /** @type {Format} */ (`distance.${ending}`)];
    return file(id, format, 'Signed distances', 'of every cell', { format, options: PACKED });
  }),
  file('tensors', 'tensors.npz', 'Smoothed permittivity', 'NumPy, compressed', { format: 'tensors.npz', options: PACKED }),
  ...Object.entries(formats).flatMap(([name, { kind, program = '', about = '', file: named = '' }]) => {
    if (kind !== 'export') return [];
    const isArchive = named.endsWith('.zip');
    // archives of many files are packed fast
    const options = isArchive ? { compress: 1 } : {};
    const more = { format: /** @type {Format} */ (name), options, ...(named.startsWith('NAME') ? {} : { name: named }) };
    return [
      file(name.replace('.', '-'), named.replace('NAME.', ''), program, isArchive ? `${about}; to be unpacked` : about, more),
    ];
  }),
];

/** Draws the list whenever there is a mesh, its options change, or somebody searches. */
export function startFileList() {
  on('mesh', () => {
    // flags of another mesh
    inputOf('export-flags').value = '';
    show();
  });
  for (const id of ['export-flags', 'export-map']) {
    onInput(id, 'input', show);
    onInput(id, 'change', (input) => input.reportValidity());
  }
  onInput('export-ascii', 'change', show);
  selectOf('export-order').addEventListener('change', show);
  onInput('file-search', 'input', find);
  byId('all-files').addEventListener('keydown', moveByKey);
}

function show() {
  const { mesh } = state;
  const [flags, map] = [flagsToExport(), mapOfField()];
  const rows = mesh ? FILES.filter((kind) => isPossible(kind, mesh)).map((kind) => row(kind, mesh, flags, map)) : [];
  byId('downloads').replaceChildren(...rows);
  find();
}

/** @param {FileKind} kind @param {Mesh} mesh @param {number[] | null} flags @param {ReturnType<typeof mapOfField>} map */
function row(kind, mesh, flags, map) {
  const element = entry(mesh, withOptions(kind, flags ?? [], map ?? undefined));
  const programs = PROGRAMS.filter(({ files }) => files.includes(kind.id)).map(({ name }) => name);
  element.dataset.words = [kind.label, `.${kind.extension}`, kind.note, ...programs].join(' ').toLowerCase();
  const isWrong = isExport(kind) ? flags === null : isArray(kind) && map === null;
  for (const button of element.querySelectorAll('button')) button.disabled = isWrong;
  if (kind.format && formats[kind.format].unit && !mesh.report.unit) {
    for (const size of element.querySelectorAll('.size')) size.textContent = 'asks for the unit';
    const ask = (/** @type {Event} */ event) => {
      event.stopPropagation();
      selectOf('program').value = programs[0];
      selectOf('program').dispatchEvent(new Event('change'));
      byId('leave').scrollIntoView();
      (byId('program-unit-field').hidden ? byId('program') : byId('program-unit')).focus();
    };
    element.addEventListener('click', ask, { capture: true });
  }
  return element;
}

/** Shows the files that have every word that is searched for. */
function find() {
  const words = inputOf('file-search').value.toLowerCase().split(/\s+/);
  const rows = [.../** @type {NodeListOf<HTMLElement>} */ (byId('downloads').querySelectorAll('li'))];
  for (const row of rows) row.hidden = !words.every((word) => row.dataset.words?.includes(word));
  const n_found = rows.filter(({ hidden }) => !hidden).length;
  byId('files-found').textContent = n_found < rows.length ? `${n_found || 'None'} of ${rows.length} formats` : '';
}

/** The arrow keys go from the search to the files, and from one to the next. @param {KeyboardEvent} event */
function moveByKey(event) {
  const step = { ArrowDown: 1, ArrowUp: -1 }[event.key];
  const stops = [
    inputOf('file-search'),
    .../** @type {NodeListOf<HTMLElement>} */ (byId('downloads').querySelectorAll('li:not([hidden]) > button:first-child')),
  ];
  const at = stops.findIndex((stop) => stop.matches(':focus'));
  if (!step || at < 0) return;
  event.preventDefault();
  stops[Math.min(Math.max(at + step, 0), stops.length - 1)].focus();
}

/** The file of an id, with the options of the fields; undefined where the mesh cannot be that. @param {string} id @param {Mesh} mesh */
export function fileOf(id, mesh) {
  const kind = FILES.find((one) => one.id === id && isPossible(one, mesh));
  return kind && withOptions(kind, flagsToExport() ?? [], undefined);
}

/** What the field says is written for flags: undefined where it is empty; null where it is wrong, which it says. */
function mapOfField() {
  const input = inputOf('export-map');
  const pairs = input.value.split(/[\s,;]+/).filter((pair) => pair !== '');
  const read = pairs.map((pair) => /^(\d+)=(\d+)$/.exec(pair)?.slice(1).map(Number) ?? []);
  const flags = new Set(read.map(([flag]) => flag));
  const isRight =
    flags.size === pairs.length && read.flat().every((number) => number < 256) && read.flat().length === 2 * pairs.length;
  input.setCustomValidity(isRight ? '' : 'such as 1=0, 0=1: flags, once each, and what is written for them, 0 to 255');
  if (!isRight) return null;
  return pairs.length > 0 ? Object.fromEntries(read) : undefined;
}

/** The flags of the field, none for all but 0; null where it has others than flags of the mesh, which it says. */
function flagsToExport() {
  const input = inputOf('export-flags');
  const flags = input.value.trim() === '' ? [] : numbersOf(input.value);
  const inUse = [0, ...(state.mesh?.report.flags ?? []).filter(({ cells }) => cells > 0).map(({ flag }) => flag)];
  const isRight = flags?.every((flag) => inUse.includes(flag)) ?? false;
  input.setCustomValidity(isRight ? '' : `these are flags of the mesh: ${inUse.join(', ')}`);
  return isRight ? (flags ?? []) : null;
}

/** @param {FileKind} kind */
const isExport = ({ format }) => format !== undefined && formats[format].kind === 'export';
/** Whether the order of axes, and the numbers for flags, can be chosen. @param {FileKind} kind */
const isArray = ({ id }) => ['npy', 'npz', 'raw', 'sidecar'].includes(id);

/** Whether the mesh can be such a file, once it has a unit. @param {FileKind} kind @param {Mesh} mesh */
function isPossible({ format, options }, { lines, report }) {
  // a bit distinguishes one flag from the background
  if (options?.bits && report.flags.length !== 1) return false;
  if (!format) return true;
  const { kind, spacing } = formats[format];
  // links have their name last where it is all of it
  if (kind === 'measured' && !report[format.split('.')[0]]) return false;
  if (format === 'eb' && !report.job?.cut_cells) return false;
  if (format.endsWith('vtr')) return lines.spacing === null;
  if (!lines.spacing) return spacing === 'any';
  const [x, ...others] = lines.spacing;
  return spacing !== 'cubes' || others.every((size) => Math.abs(size / x - 1) <= ROUNDING);
}

/** @param {FileKind} kind @param {number[]} exportFlags @param {Record<number, number> | undefined} map @returns {FileKind} */
function withOptions({ options, ...kind }, exportFlags, map) {
  const format = kind.format ?? 'raw';
  const axisOrder = selectOf('export-order').value;
  const ascii = inputOf('export-ascii').checked && formats[format].ascii;
  const only = exportFlags.length > 0 && isExport(kind) && format !== 'nrrd';
  return {
    ...kind,
    options: {
      ...options,
      ...(ascii ? { ascii } : {}),
      ...(only ? { exportFlags } : {}),
      ...(isArray(kind) && axisOrder === 'xyz' ? { axisOrder } : {}),
      ...(isArray(kind) && map ? { map } : {}),
    },
  };
}

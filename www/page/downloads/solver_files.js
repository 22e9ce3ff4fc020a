/** Files for solvers: those that the mesh can be, of the cells of some flags. */
import { formats } from 'hexcast';
import { byId, inputOf, selectOf } from '../elements/dom.js';
import { entry, file } from './downloads.js';
import { numbersOf } from '../text/format.js';
import { on, state } from '../state/state.js';

/** @typedef {import('./downloads.js').FileKind} FileKind */

/** Cell sizes that differ by less are equal. */
const ROUNDING = 1e-9;
/** The formats of other programs, each as a file. */
const FILES = Object.entries(formats).flatMap(([name, { kind, program = '', about = '', file: named = '' }]) => {
  if (kind !== 'export') return [];
  const format = /** @type {import('hexcast').Format} */ (name);
  const more = named.startsWith('NAME') ? {} : { name: named };
  // archives of many files are packed fast
  const options = named.endsWith('.zip') ? { compress: 1 } : {};
  const note = named.endsWith('.zip') ? `${about}; to be unpacked` : about;
  return [file(name.replace('.', '-'), named.replace('NAME.', ''), program, note, { format, options, ...more })];
});

/** Arrays, whose order of axes and numbers are those of the fields. */
const ARRAYS = [
  file('array-npy', 'npy', 'NumPy', '', { format: 'npy' }),
  file('array-npz', 'npz', 'NumPy, with lines', '', { format: 'npz', options: { compress: 6 } }),
  file('array-raw', 'raw', 'Raw', '', { format: 'raw' }),
  file('array-sidecar', 'raw.json', 'Raw: description', 'dims, lines, names'),
];
/** What the arrays are like in each order. */
const SHAPES = { zyx: 'shape nz, ny, nx: x fastest', xyz: 'shape nx, ny, nz: x slowest' };

/** Draws the list whenever there is a mesh, or its options change. */
export function startExports() {
  on('mesh', () => {
    // flags of another mesh
    inputOf('export-flags').value = '';
    show();
  });
  inputOf('export-flags').addEventListener('input', show);
  inputOf('export-flags').addEventListener('change', () => inputOf('export-flags').reportValidity());
  inputOf('export-ascii').addEventListener('change', show);
  selectOf('export-order').addEventListener('change', show);
  inputOf('export-map').addEventListener('input', show);
  inputOf('export-map').addEventListener('change', () => inputOf('export-map').reportValidity());
}

function show() {
  const { mesh } = state;
  const flags = flagsToExport();
  const offered = mesh
    ? FILES.filter((kind) => isOffered(kind, mesh)).map((kind) => entry(mesh, withOptions(kind, flags ?? [])))
    : [];
  byId('exports-list').replaceChildren(...offered);
  for (const button of byId('exports-list').querySelectorAll('button')) button.disabled = flags === null;
  showArrays();
  byId('exports-unit').hidden = !mesh || mesh.report.unit !== null;
}

function showArrays() {
  const { mesh } = state;
  const map = mapOfField();
  const axisOrder = /** @type {keyof SHAPES} */ (selectOf('export-order').value);
  const files = mesh ? ARRAYS : [];
  byId('arrays-list').replaceChildren(
    ...files.map((kind) => {
      const options = { ...kind.options, axisOrder, ...(map ? { map } : {}) };
      return entry(/** @type {import('hexcast').Mesh} */ (mesh), { ...kind, note: kind.note || SHAPES[axisOrder], options });
    }),
  );
  for (const button of byId('arrays-list').querySelectorAll('button')) button.disabled = map === null;
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

/** @param {FileKind} kind @param {import('hexcast').Mesh} mesh */
function isOffered({ format = 'nrrd' }, { lines, report }) {
  const { unit, spacing } = formats[format];
  if (unit && report.unit === null) return false;
  if (!lines.spacing) return spacing === 'any';
  const [x, ...others] = lines.spacing;
  return spacing !== 'cubes' || others.every((size) => Math.abs(size / x - 1) <= ROUNDING);
}

/** @param {FileKind} kind @param {number[]} exportFlags @returns {FileKind} */
function withOptions({ options, ...kind }, exportFlags) {
  const format = kind.format ?? 'nrrd';
  const ascii = inputOf('export-ascii').checked && formats[format].ascii;
  const only = exportFlags.length > 0 && format !== 'nrrd';
  return { ...kind, options: { ...options, ...(ascii ? { ascii } : {}), ...(only ? { exportFlags } : {}) } };
}

/** Files for solvers: those that the mesh can be, of the cells of some flags. */
import { byId, inputOf } from './dom.js';
import { entry, file } from './downloads.js';
import { numbersOf } from './format.js';
import { on, state } from './state.js';

/** @typedef {import('./downloads.js').FileKind} FileKind */

/** Cell sizes that differ by less are equal. */
const ROUNDING = 1e-9;
/** Formats with a form in text besides the binary one, those that need the unit of lengths, and those of cells of one size. */
const IN_TEXT = ['foam', 'msh'];
const WITH_UNIT = ['foam', 'inp', 'csx.xml', 'geometry.xml'];
const OF_EQUAL = ['geometry.xml', 'nrrd', 'vox', 'binvox'];

const FILES = [
  file('foam', 'foam.zip', 'OpenFOAM', 'to be unpacked into a case', { format: 'foam', options: { compress: 1 } }),
  file('inp', 'inp', 'Abaqus, CalculiX', 'bricks, sets, surfaces', { format: 'inp' }),
  file('msh', 'msh', 'Gmsh', 'MSH 4.1, hexahedra', { format: 'msh' }),
  file('csx', 'csx.xml', 'openEMS', 'boxes; needs the material of each part', { format: 'csx.xml' }),
  file('openmc', 'geometry.xml', 'OpenMC', 'lattice', { format: 'geometry.xml', name: 'geometry.xml' }),
  file('nrrd', 'nrrd', 'NRRD', '3D Slicer, ITK', { format: 'nrrd', options: { compress: 6 } }),
  file('vox', 'vox', 'MagicaVoxel', 'to look at', { format: 'vox' }),
  file('binvox', 'binvox', 'binvox', 'a cube of bits', { format: 'binvox' }),
];

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
}

function show() {
  const { mesh } = state;
  const flags = flagsToExport();
  const offered = mesh
    ? FILES.filter((kind) => isOffered(kind, mesh)).map((kind) => entry(mesh, withOptions(kind, flags ?? [])))
    : [];
  byId('exports-list').replaceChildren(...offered);
  for (const button of byId('exports-list').querySelectorAll('button')) button.disabled = flags === null;
  byId('exports-unit').hidden = !mesh || mesh.report.unit !== null;
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
  if (report.unit === null && WITH_UNIT.includes(format)) return false;
  if (!lines.spacing) return !OF_EQUAL.includes(format);
  const [x, ...others] = lines.spacing;
  return format !== 'binvox' || others.every((size) => Math.abs(size / x - 1) <= ROUNDING);
}

/** @param {FileKind} kind @param {number[]} exportFlags @returns {FileKind} */
function withOptions({ options, ...kind }, exportFlags) {
  const format = kind.format ?? 'nrrd';
  const ascii = inputOf('export-ascii').checked && IN_TEXT.includes(format);
  const only = exportFlags.length > 0 && format !== 'nrrd';
  return { ...kind, options: { ...options, ...(ascii ? { ascii } : {}), ...(only ? { exportFlags } : {}) } };
}

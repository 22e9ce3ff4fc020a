/** "For which program?": asks for what the file of a program lacks, writes it, and shows what is typed next. */
import { formats } from 'hexcast';
import { buttonOf, byId, inputOf, make, selectOf } from '../elements/dom.js';
import { download, nameOf } from './downloads.js';
import { fileOf } from './file_list.js';
import { Materials } from './materials.js';
import { PROGRAMS } from './programs.js';
import { currentJob } from '../state/job.js';
import { comesByItself, hasSources, isShown } from '../run/live_rule.js';
import { on, set, state } from '../state/state.js';

/** What the chosen program needed when it was chosen: its questions stay, so that answers can be changed. */
const asked = { unit: false, materials: false };
const materials = new Materials();

/** Connects the choice. */
export function startLeave() {
  const choice = selectOf('program');
  choice.append(...PROGRAMS.map(({ name }) => make('option', { value: name }, name)));
  choice.addEventListener('change', () => {
    Object.assign(asked, { unit: false, materials: false });
    byId('program-status').textContent = '';
    show();
  });
  const unit = selectOf('program-unit');
  unit.append(...[...selectOf('unit').options].map(({ value }) => make('option', { value }, value || 'choose')));
  unit.addEventListener('change', () => set({ unit: unit.value }));
  byId('program-save').addEventListener('click', () => {
    const { mesh } = state;
    const chosen = mesh && chosenFile(mesh);
    if (chosen) download(mesh, chosen.file, buttonOf('program-save'), byId('program-status')).then(show);
  });
  for (const id of ['export-flags', 'export-ascii']) byId(id).addEventListener('input', show);
  on(['mesh', 'geometries', 'settings', 'phase', 'estimate', 'colours'], show);
}

/** The program that is chosen, and its file. @param {import('hexcast').Mesh} mesh */
function chosenFile(mesh) {
  const program = PROGRAMS.find(({ name }) => name === selectOf('program').value);
  const file = program && fileFor(program, mesh);
  return file ? { program, file: { ...file, options: { ...file.options, ...program.options?.(mesh.report) } } } : null;
}

/** @param {import('./programs.js').Program} program @param {import('hexcast').Mesh} mesh */
function fileFor({ files }, mesh) {
  return files.map((id) => fileOf(id, mesh)).find((file) => file);
}

function show() {
  const { mesh } = state;
  if (!mesh) return;
  for (const [at, program] of PROGRAMS.entries()) {
    const option = selectOf('program').options[at + 1];
    option.disabled = !fileFor(program, mesh);
    option.text = option.disabled ? `${program.name}: for cells of one size` : program.name;
  }
  const chosen = chosenFile(mesh);
  byId('program-panel').hidden = !chosen;
  if (!chosen) return;
  const { program, file } = chosen;
  const missing = ask(program, file, mesh);
  if (!inputOf('export-flags').validity.valid) missing.push('flags of the mesh, in the options below');
  // what was answered gets to the mesh without a click
  const job = currentJob();
  const isComing = missing.length === 0 && !isShown(job) && comesByItself(job);
  byId('program-missing').textContent = missing.length > 0 ? `Still to say: ${missing.join(', and ')}.` : '';
  const save = buttonOf('program-save');
  save.textContent = isComing ? 'Meshing …' : `Save ${nameOf(file)}`;
  save.disabled = missing.length > 0 || isComing || state.phase === 'meshing';
  byId('program-where').textContent = `${program.where}:`;
  byId('program-next').textContent = program.next(nameOf(file), mesh.dims).join('\n');
}

/**
 * Asks for what the program needs and nobody said, and says what of it is still missing.
 *
 * @param {import('./programs.js').Program} program
 * @param {import('./downloads.js').FileKind} file
 * @param {import('hexcast').Mesh} mesh
 */
function ask({ materials: kind, name }, { format }, mesh) {
  const needsUnit = Boolean(format && formats[format].unit);
  // a column file says what it says
  if (!state.job || !hasSources(state.job) || state.geometries.length === 0) {
    Object.assign(asked, { unit: false, materials: false });
    byId('program-unit-field').hidden = byId('materials').hidden = true;
    return needsUnit && !mesh.report.unit ? [`a unit, without which ${name} has no lengths, when its models are meshed`] : [];
  }
  const { unit } = state.settings;
  const hasUnit = Boolean(unit || mesh.report.unit);
  asked.unit ||= needsUnit && !hasUnit;
  byId('program-unit-field').hidden = !asked.unit;
  if (selectOf('program-unit').value !== unit) selectOf('program-unit').value = unit;
  const n_without = kind ? materials.show(kind) : 0;
  asked.materials ||= n_without > 0;
  byId('materials').hidden = !kind || !asked.materials;
  const parts = n_without === 1 ? 'one part is' : `${n_without} parts are`;
  return [needsUnit && !hasUnit ? 'the unit' : '', kind === 'field' && n_without > 0 ? `what ${parts} made of` : ''].filter(
    Boolean,
  );
}

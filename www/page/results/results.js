/** The result: facts, legend, the report. */
import { byId, make } from '../elements/dom.js';
import { spilledBytes, save } from '../downloads/downloads.js';
import { bytes, count, duration, measure, roughly, times } from '../text/format.js';
import { showError } from '../elements/messages.js';
import { cellFacts } from '../text/cell_facts.js';
import { holding } from '../state/held.js';
import { offerLook, takeLook } from '../settings/looks.js';
import { baseName } from '../settings/share.js';
import { change, colourOf, on, state } from '../state/state.js';

/** The flags of the last mesh. */
let listed = '';

/** Connects the panel. */
export function startResults() {
  on('mesh', () => {
    const flags = String(state.mesh?.report.flags.map(({ flag }) => flag));
    // other parts are seen
    if (flags !== listed) state.hidden.clear();
    listed = flags;
    for (const flag of takeLook('hidden')?.split(' ') ?? []) state.hidden.add(Number(flag));
    show();
  });
  offerLook('hidden', () => [...state.hidden].join(' '));
  on('colours', () => state.mesh && showLegend());
  on('legend', () => {
    for (const box of byId('legend').querySelectorAll('input')) box.checked = !state.hidden.has(Number(box.value));
  });
  byId('save-report').addEventListener('click', () => {
    save(new Blob([reportText()], { type: 'application/json' }), `${baseName(state.job)}.report.json`);
  });
  byId('hash').addEventListener('click', hash);
}

function reportText() {
  return `${JSON.stringify(state.mesh?.report, null, 2)}\n`;
}

function show() {
  const { mesh } = state;
  byId('results').hidden = !mesh;
  document.body.classList.toggle('has-mesh', Boolean(mesh));
  if (!mesh) return;
  const { report } = mesh;
  const list = byId('result-facts');
  list.replaceChildren();
  const fact = (/** @type {string} */ id, /** @type {string} */ term, /** @type {string} */ value) =>
    value && list.append(make('dt', {}, term), make('dd', { id }, value));
  fact('result-dims', 'Cells', `${times(mesh.dims, String)} = ${roughly(report.cells)}`);
  for (const one of cellFacts('result', report, report.unit)) fact(...one);
  const spilled = spilledBytes(report);
  fact('result-spilled', 'Stored', spilled > 0 ? `${bytes(spilled)} in the browser's private files` : '');
  fact(
    'result-time',
    'Time',
    report.seconds.total ? `${duration(report.seconds.total)}, ${roughly(report.cells_per_second ?? 0)} cells/s` : '',
  );
  fact('result-backend', 'Meshed by', report.adapter ?? (report.backend === 'cpu' ? 'the processor' : (report.backend ?? '')));
  showLegend();
  byId('report').textContent = reportText();
  byId('result-hash').textContent = report.flags_sha256 ?? '';
}

/** One row a flag: on or off, colour, name, cells, volume compared with that of its facets. */
function showLegend() {
  if (!state.mesh) return;
  const { report } = state.mesh;
  byId('legend').replaceChildren(...report.flags.map((entry) => row(entry, report.unit)));
}

/** @param {import('hexcast').FlagReport} entry @param {string | null} unit */
function row({ flag, name, cells, volume, mesh_volume: meshVolume }, unit) {
  const box = make('input', {
    type: 'checkbox',
    value: flag,
    checked: !state.hidden.has(flag),
    'aria-label': `Show flag ${flag}, ${name}`,
    on: {
      change: ({ target }) => {
        const others = [...state.hidden].filter((one) => one !== flag);
        change('legend', { hidden: new Set(target.checked ? others : [...others, flag]) });
      },
    },
  });
  const swatch = make('span', { className: 'swatch' });
  swatch.style.background = colourOf(flag);
  const difference = comparison({ name, cells, volume, mesh_volume: meshVolume });
  return make(
    'tr',
    { 'data-flag': flag },
    make('td', {}, box),
    make('th', { scope: 'row' }, swatch, make('span', { className: 'number' }, String(flag)), ` ${name}`),
    make('td', { className: 'number cells', 'data-cells': cells }, count(cells)),
    make(
      'td',
      { className: 'number', title: meshVolume ? `volume of the facets: ${measure(meshVolume, unit, 3)}` : null },
      measure(volume, unit, 3),
      make('small', {}, difference),
    ),
  );
}

/**
 * How the volume of the cells differs from that of the facets, where nothing but the size of the cells makes them differ: not where
 * another geometry has some of the cells. Overlaps that are known are named.
 *
 * @param {Pick<import('hexcast').FlagReport, 'name' | 'cells' | 'volume' | 'mesh_volume'>} entry
 */
function comparison({ name, cells, volume, mesh_volume: meshVolume }) {
  const { certificate, geometries = [] } = /** @type {import('hexcast').Mesh} */ (state.mesh).report;
  const isOfFlag = (/** @type {string} */ geometry) => name.split(' + ').includes(geometry);
  if (certificate) {
    const lost = certificate.overlaps.filter(({ loser }) => isOfFlag(loser));
    if (lost.length > 0) return lost.map(({ cells, winner }) => `${count(cells)} more in ${winner}`).join(', ');
  } else {
    const mayLose = (/** @type {GeometryReport} */ mine, /** @type {number} */ at) =>
      isOfFlag(mine.name) &&
      geometries.some(
        (other, index) =>
          !isOfFlag(other.name) &&
          (other.priority === mine.priority ? index > at : other.priority > mine.priority) &&
          boxesOverlap(mine.bounding_box, other.bounding_box),
      );
    if (geometries.some(mayLose)) return '';
  }
  if (!meshVolume || cells === 0) return '';
  return `${percent((100 * (volume - meshVolume)) / meshVolume)} vs facets`;
}

/** @typedef {import('hexcast').GeometryReport} GeometryReport @typedef {GeometryReport['bounding_box']} Box */

/** @param {Box} one @param {Box} other */
function boxesOverlap(one, other) {
  return [0, 1, 2].every((axis) => one[0][axis] < other[1][axis] && other[0][axis] < one[1][axis]);
}

/** A difference with its sign, if it has one once it is rounded. @param {number} off */
function percent(off) {
  const digits = Math.abs(off).toFixed(Math.abs(off) < 1 ? 2 : 1);
  const sign = off > 0 ? '+' : '−';
  return `${Number(digits) === 0 ? '' : sign}${digits} %`;
}

async function hash() {
  const { mesh } = state;
  if (!mesh) return;
  const output = byId('result-hash');
  try {
    const onProgress = (/** @type {import('hexcast').Progress} */ { done, total }) =>
      (output.textContent = `${Math.floor((100 * done) / Math.max(total, 1))} %`);
    const sha256 = await holding(mesh, () => mesh.sha256({ onProgress }));
    if (mesh === state.mesh) output.textContent = sha256;
  } catch (error) {
    showError(error);
  }
}

/**
 * Who claims a cell: the column of the cell is meshed once for each part that may reach it, with that part first of all. The cells that it has
 * then are the cells that it claims, decided as in the mesh itself; in the mesh a part of higher rank may have them.
 */
import { buttonOf, byId, make } from '../elements/dom.js';
import { showError } from '../elements/messages.js';
import { task } from '../elements/tasks.js';
import { jobOfMesh } from '../state/job.js';
import { MEASURED, on, state } from '../state/state.js';
import { endText, lengthOf, placeAt, placedBox } from '../text/places.js';
import { crosshair } from './crosshair.js';

/** @typedef {import('hexcast').Mesh} Mesh @typedef {import('hexcast').Job} Job @typedef {import('../state/state.js').Geometry} Geometry */
/** @typedef {{ geometry: Geometry, runs: number[][], isIn: boolean }} Claim the first and the end of each run of cells on the column, and whether the cell is in one */

/** Connects the button: what it found goes with the cell. */
export function startClaims() {
  byId('claims-find').addEventListener('click', find);
  on(['crosshair', 'mesh', 'geometries'], () => {
    byId('claims').hidden = true;
    byId('claims-find').hidden = !jobOfMesh();
  });
}

async function find() {
  const { mesh, mesher } = state;
  const job = jobOfMesh();
  if (!mesh || !mesher || !job) return;
  const { cell } = crosshair;
  const parts = job.geometries.flatMap(({ source }, at) => {
    const geometry = state.geometries.find(({ surface }) => surface === source);
    return geometry && mayReach(mesh, geometry, cell, job.close_gaps ?? 0) ? [{ geometry, at }] : [];
  });
  buttonOf('claims-find').disabled = true;
  try {
    /** @type {Claim[]} */
    const claims = [];
    await task('Meshing the column of each part', async ({ signal }) => {
      for (const { geometry, at } of parts) {
        const alone = await mesher.mesh(columnOf(job, at, mesh, cell), { signal });
        try {
          const { flags } = await alone.box([0, 0, 0], alone.dims, { signal });
          claims.push({ geometry, ...runsOf(flags, cell[mesh.columns.axis]) });
        } finally {
          alone.dispose();
        }
      }
    });
    if (mesh === state.mesh && cell === crosshair.cell) show(mesh, claims);
  } catch (error) {
    if (!(error instanceof DOMException && error.name === 'AbortError')) showError(error);
  } finally {
    buttonOf('claims-find').disabled = false;
  }
}

/** Whether a part may have a cell of the column: its box, and as many cells around it as are filled or closed. @param {Mesh} mesh @param {Geometry} geometry @param {number[]} cell @param {number} closed */
function mayReach({ lines, columns }, { info, ...placing }, cell, closed) {
  const [low, high] = placedBox(info.bounding_box, placing);
  return cell.every((at, axis) => {
    const around = (1 + closed) * lengthOf(lines, axis, at);
    const [from, to] = [placeAt(lines, axis, at) - around, placeAt(lines, axis, at + 1) + around];
    return axis === columns.axis || (high[axis] >= from && low[axis] <= to);
  });
}

/** The job of one column in which one part has flags of its own, and all that it claims. @param {Job} job @param {number} first number of the part @param {Mesh} mesh @param {number[]} cell @returns {Job} */
function columnOf(job, first, { dims, columns: { axis } }, cell) {
  const start = cell.map((at, other) => (other === axis ? 0 : at));
  const end = cell.map((at, other) => (other === axis ? dims[axis] : at + 1));
  const priority = 1 + Math.max(...job.geometries.map((geometry) => geometry.priority ?? 0));
  const geometries = job.geometries.map((geometry, at) =>
    at === first ? { ...geometry, flag: 2, priority } : { ...geometry, flag: 1, split: false },
  );
  /** @type {Record<string, unknown>} */
  const only = { ...job, geometries, window: [...start, ...end] };
  // of the cells alone
  for (const key of [...MEASURED, 'certify', 'thin_cells', 'stencil', 'fluid']) delete only[key];
  return /** @type {Job} */ (/** @type {unknown} */ (only));
}

/** Runs of the cells that have flags of the part. @param {Uint8Array} flags @param {number} cell */
function runsOf(flags, cell) {
  /** @type {number[][]} */
  const runs = [];
  for (const [at, flag] of flags.entries()) {
    if (flag < 2) continue;
    const last = runs.at(-1);
    if (last && last[1] === at) last[1] = at + 1;
    else runs.push([at, at + 1]);
  }
  return { runs, isIn: flags[cell] >= 2 };
}

/** @param {Mesh} mesh @param {Claim[]} claims in meshing order */
function show(mesh, claims) {
  const { lines, dims, report, columns } = mesh;
  const { axis } = columns;
  const place = (/** @type {number} */ line) =>
    endText(placeAt(lines, axis, line), lengthOf(lines, axis, Math.min(line, dims[axis] - 1)));
  const ranked = claims.filter(({ isIn }) => isIn).sort((a, b) => a.geometry.priority - b.geometry.priority);
  const winner = ranked.at(-1);
  byId('claims-answer').textContent = winner
    ? `${ranked.length === 1 ? 'One part claims' : `${ranked.length} parts claim`} this cell: ${nameOf(winner.geometry)} has it${reason(ranked)}.`
    : 'No part claims this cell: it is background.';
  byId('claims-rows').replaceChildren(
    ...claims
      .filter(({ runs }) => runs.length > 0)
      .map(({ geometry, runs, isIn }) => {
        const where = runs.map(([from, end]) => `${place(from)} to ${place(end)}`).join('; ');
        const part = make('th', { scope: 'row' }, nameOf(geometry));
        return make(
          'tr',
          isIn ? { 'aria-current': 'true' } : {},
          part,
          make('td', {}, String(geometry.priority)),
          make('td', {}, where),
        );
      }),
  );
  byId('claims-where').textContent = `From and to, ${'xyz'[axis]}${report.unit ? ` in ${report.unit}` : ''}`;
  byId('claims').hidden = false;
}

/** @param {Geometry} geometry */
function nameOf({ name, source }) {
  return name ?? source.name;
}

/** Why the last of some claims wins. @param {Claim[]} ranked by priority, then in meshing order */
function reason(ranked) {
  const [second, first] = ranked.slice(-2).map(({ geometry }) => geometry);
  if (!first) return '';
  if (first.priority > second.priority)
    return `, as its priority ${first.priority} is above ${second.priority} of ${nameOf(second)}`;
  return `, as it comes after ${nameOf(second)}, which has the same priority ${first.priority}`;
}

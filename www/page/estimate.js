/** What the mesh would cost, live, and whether it will fit. */
import { byId, later, make } from './dom.js';
import { bytes, cellSize, duration, roughly, times } from './format.js';
import { wrongField } from './fields.js';
import { currentJob } from './job.js';
import { sentence } from './messages.js';
import { change, on, state } from './state.js';

/** Columns beyond this do not fit into what a mesh takes of the 4 GB that wasm can address, with what it needs beside them. */
const COLUMNS_LIMIT = 2.8e9;
/** Columns from here on are much for a machine with little memory. */
const COLUMNS_MUCH = 5e8;

/** @type {AbortController | null} */
let running = null;

/** Estimates anew whenever the job changes. */
export function startEstimate() {
  on(['settings', 'geometries', 'mesher'], later(estimate, 60));
  on(['mesh'], estimate);
  // what was set meanwhile
  on(['phase'], () => state.phase === 'idle' && estimate());
  on(['estimate', 'fields'], show);
}

async function estimate() {
  running?.abort();
  const stop = new AbortController();
  running = stop;
  if (!state.mesher || state.geometries.length === 0) return change('estimate', { estimate: null });
  // the worker meshes; the numbers on the page are those of the job that runs
  if (state.phase === 'meshing') return undefined;
  const [estimate, room] = await Promise.all([
    state.mesher.estimate(currentJob(), { signal: stop.signal }).then(
      (result) => ({ result }),
      (error) => ({ error }),
    ),
    roomForSpill(),
  ]);
  if (!stop.signal.aborted) change('estimate', { estimate: { ...estimate, room } });
  return undefined;
}

/** Bytes that the browser's private files may still take: 0 where there are none, Infinity where the browser does not say. */
async function roomForSpill() {
  if (!navigator.storage?.getDirectory) return 0;
  /** @type {StorageEstimate} */
  const { quota = Infinity, usage = 0 } = await navigator.storage.estimate().catch(() => ({}));
  return Math.max(quota - usage, 0);
}

function show() {
  const box = byId('estimate');
  const { estimate } = state;
  box.hidden = !estimate;
  box.replaceChildren();
  if (!estimate) return;
  const wrong = wrongField();
  if (wrong) return box.append(make('p', { className: 'warn', id: 'field-error' }, wrong));
  if (estimate.error) {
    return box.append(
      make('p', { className: 'warn', id: 'estimate-error', 'data-code': estimate.error.code }, problem(estimate.error)),
    );
  }
  const { result } = estimate;
  if (!result) return;
  const list = make('dl', { className: 'facts' });
  const fact = (/** @type {string} */ id, /** @type {string} */ term, /** @type {string} */ value) =>
    list.append(make('dt', {}, term), make('dd', { id }, value));
  fact('estimate-cells', 'Cells', `${roughly(result.cells)} (${times(result.dims, String)})`);
  fact('estimate-size', 'Cell', cellSize(result.spacing, state.settings.unit));
  const onGpu = state.mesher?.backend === 'gpu' ? `, GPU ${bytes(result.device_bytes)}` : '';
  fact('estimate-memory', 'Memory', `about ${bytes(result.host_bytes)}${onGpu}`);
  fact('estimate-file', 'File', `${bytes(result.file_bytes.raw)}, a byte a cell`);
  fact('estimate-time', 'Time', result.seconds === null ? 'known after the first mesh' : `about ${duration(result.seconds)}`);
  box.append(list);
  const warning = fits(result, estimate.room);
  if (warning) box.append(make('p', { className: 'warn', id: 'estimate-warning' }, warning));
  return undefined;
}

/** @param {import('hexcast').HexcastError} error */
function problem({ message, hint }) {
  return hint ? `${sentence(message)} ${sentence(hint)}` : sentence(message);
}

/**
 * A sentence where it will not fit, or may not; else null. `room` is that of the browser's private files, in bytes.
 *
 * @param {import('hexcast').Estimate} estimate
 * @param {number} room
 */
function fits({ column_bytes: columns }, room) {
  const device = (navigator.deviceMemory ?? 8) * 1e9;
  if (columns > COLUMNS_LIMIT && columns <= room) {
    return `A page has no room in memory for ${bytes(columns)}: the mesh is kept in the browser's private files, which takes as much of the disk and is slower to look at.`;
  }
  if (columns > COLUMNS_LIMIT) {
    return `This will not fit: it needs about ${bytes(columns)}, and a page has room for ${bytes(COLUMNS_LIMIT)} in memory${room > 0 ? `, or ${bytes(room)} on the disk` : ''}. Take larger cells, or mesh it with the command line.`;
  }
  if (columns > COLUMNS_MUCH || columns > device / 4) {
    return `This is much for a page: about ${bytes(columns)} of memory. Close other tabs, or take larger cells.`;
  }
  return null;
}

/** What the mesh would cost, updated with every change, and whether it fits. */
import { byId, inTurn, make, pause } from '../elements/dom.js';
import { bytes, count, duration, roughly, times } from '../text/format.js';
import { wrongField } from '../settings/wrong_fields.js';
import { currentJob, keyOfCells } from '../state/job.js';
import { sentence } from '../elements/messages.js';
import { cellFacts } from '../text/cell_facts.js';
import { change, on, state } from '../state/state.js';

/** Largest columns, in bytes, that a mesh can hold in the 4 GB that wasm can address: the rest is for facets and files. */
const COLUMNS_LIMIT = 2.8e9;
/** Columns from this size on fill a machine with little memory. */
const COLUMNS_MUCH = 5e8;

/** Milliseconds after which an estimate is ended where the job has changed meanwhile. */
const PATIENCE = 200;
/** Milliseconds that an estimate waits for a mesh that the page makes by itself: on one thread it would hold that up. */
const COURTESY = 300;
/** Milliseconds between two looks at whether it is made. */
const STEP = 10;

/** The estimate that is made. @type {{ stop: AbortController, since: number } | null} */
let running = null;
const again = inTurn(estimate);

/** Estimates anew whenever the job changes. */
export function startEstimate() {
  on(['settings', 'geometries', 'mesher', 'mesh'], update);
  // settings may have changed while meshing
  on(['phase'], () => state.phase === 'idle' && update());
  on(['estimate', 'fields'], show);
}

/** One after another, however fast the job changes; a long one is not waited for. */
function update() {
  if (running && performance.now() - running.since > PATIENCE) running.stop.abort();
  return again();
}

async function estimate() {
  for (let waited = 0; state.phase === 'updating' && waited < COURTESY; waited += STEP) await pause(STEP);
  if (!state.mesher || state.geometries.length === 0) return change('estimate', { estimate: null });
  // the page keeps the numbers of the job that runs
  if (state.phase === 'meshing') return undefined;
  const job = currentJob();
  const stop = new AbortController();
  running = { stop, since: performance.now() };
  const [estimate, freeBytes] = await Promise.all([
    state.mesher.estimate(job, { signal: stop.signal }).then(
      (result) => ({ result }),
      (error) => ({ error }),
    ),
    freeBytesForSpill(),
  ]);
  running = null;
  const isOf = keyOfCells(job) === keyOfCells(currentJob());
  // a surface that was removed meanwhile fails an estimate that nobody asks for any more
  if (!stop.signal.aborted && (isOf || !('error' in estimate))) change('estimate', { estimate: { job, ...estimate, freeBytes } });
  return undefined;
}

/** Free bytes of the browser's private file system: 0 where there is none, Infinity where the browser does not report them. */
async function freeBytesForSpill() {
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
  const { sizing, cells, domain } = state.settings;
  const most = Math.max(...result.dims);
  if (sizing === 'cells' && !domain && most > cells)
    fact('estimate-padding', '', `${count(cells)} along the parts, ${count(most)} with the padding`);
  for (const one of cellFacts('estimate', result, state.settings.unit)) fact(...one);
  const onGpu = state.mesher?.backend === 'gpu' ? `, GPU ${bytes(result.device_bytes)}` : '';
  fact('estimate-memory', 'Memory', `about ${bytes(result.host_bytes)}${onGpu}`);
  fact('estimate-file', 'File', `${bytes(result.file_bytes.raw)}, a byte a cell`);
  fact(
    'estimate-time',
    'Time',
    result.seconds === null ? `known after ${state.mesh ? 'a larger' : 'the first'} mesh` : `about ${duration(result.seconds)}`,
  );
  box.append(list);
  const warning = fits(result, estimate.freeBytes);
  if (warning) box.append(make('p', { className: 'warn', id: 'estimate-warning' }, warning));
  return undefined;
}

/** Names of the keys of geometries on the page. @type {Record<string, string>} */
const FIELDS = {
  scale: 'scale',
  rotate: 'rotation',
  about: 'centre of rotation',
  translate: 'move',
  flag: 'flag',
  priority: 'priority',
  name: 'name',
  split: 'split',
  max_size: 'largest cell',
  min_cells: 'fewest cells',
  metal: 'metal',
};

/** A sentence about an error of the job, in the words of the page. @param {import('hexcast').HexcastError} error */
function problem({ message: said, hint }) {
  const message = said.replace(/geometries\[(\d+)\]\.(\w+)/g, (all, index, key) => {
    const geometry = state.geometries[Number(index)];
    return geometry && FIELDS[key] ? `the ${FIELDS[key]} of ${geometry.name ?? geometry.source.name}` : all;
  });
  return hint ? `${sentence(message)} ${sentence(hint)}` : sentence(message);
}

/**
 * A sentence where the mesh does not fit, or may not; else null. `freeBytes` are those of the browser's private file system.
 *
 * @param {import('hexcast').Estimate} estimate
 * @param {number} freeBytes
 */
function fits({ column_bytes: columns }, freeBytes) {
  const device = (navigator.deviceMemory ?? 8) * 1e9;
  if (columns > COLUMNS_LIMIT && columns <= freeBytes) {
    return `A page cannot hold ${bytes(columns)} in memory: the mesh is stored in the browser's private files. It takes as much disk space, and slices are slower.`;
  }
  if (columns > COLUMNS_LIMIT) {
    return `This will not fit: it needs about ${bytes(columns)}, and a page can hold ${bytes(COLUMNS_LIMIT)} in memory${freeBytes > 0 ? ` or ${bytes(freeBytes)} on disk` : ''}. Take larger cells, or use the command line.`;
  }
  if (columns > COLUMNS_MUCH || columns > device / 4) {
    return `This needs about ${bytes(columns)}; the tab may run out of memory. Close other tabs, or take larger cells.`;
  }
  return null;
}

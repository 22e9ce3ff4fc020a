/** Undo and redo of every edit: of files, of their settings, colours and what is hidden, and of the fields. */
import { buttonOf, byId, debounce } from '../elements/dom.js';
import { restoreGeometries } from '../geometries/files.js';
import { endUpdate } from '../run/run.js';
import { change, on, state } from '../state/state.js';

/**
 * @typedef {Pick<import('../state/state.js').State, 'geometries' | 'settings' | 'colours' | 'hidden'>} Snapshot
 */

/** Edits that can be undone. */
const LIMIT = 100;
/** Milliseconds after which what is typed is an edit of its own. */
const PAUSE = 400;

/** @type {Snapshot[]} */
const past = [];
/** @type {Snapshot[]} */
const future = [];
let present = snapshot();
let isRestoring = false;

/** Connects buttons and keys. */
export function startHistory() {
  present = snapshot();
  on(['geometries', 'settings', 'colours', 'legend'], debounce(record, PAUSE));
  on(['phase', 'geometries'], showButtons);
  // a mesh of other flags shows all of them: no edit
  on('mesh', () => {
    present = { ...present, hidden: new Set(state.hidden) };
  });
  byId('undo').addEventListener('click', () => go(past, future, 'Undone.'));
  byId('redo').addEventListener('click', () => go(future, past, 'Done again.'));
  document.addEventListener('keydown', (event) => {
    if (!(event.ctrlKey || event.metaKey) || event.altKey || isText(event.target)) return;
    const key = event.key.toLowerCase();
    if (key === 'y' || (key === 'z' && event.shiftKey)) go(future, past, 'Done again.');
    else if (key === 'z') go(past, future, 'Undone.');
    else return;
    event.preventDefault();
  });
  showButtons();
}

/** A field undoes what is typed in it by itself. @param {EventTarget | null} target */
function isText(target) {
  const isInput = target instanceof HTMLInputElement && !['checkbox', 'radio', 'range', 'color'].includes(target.type);
  return isInput || target instanceof HTMLTextAreaElement;
}

/** @returns {Snapshot} */
function snapshot() {
  return {
    geometries: state.geometries,
    settings: state.settings,
    colours: new Map(state.colours),
    hidden: new Set(state.hidden),
  };
}

/** What of a snapshot can be edited. @param {Snapshot} of */
function keyOf({ geometries, settings, colours, hidden }) {
  const edited = geometries.map(({ source: _, surface: _surface, info: _info, corners: _corners, cad: _cad, ...rest }) => rest);
  return JSON.stringify([edited, settings, [...colours], [...hidden].sort()]);
}

function record() {
  const now = snapshot();
  if (isRestoring || keyOf(now) === keyOf(present)) return;
  past.push(present);
  past.splice(0, past.length - LIMIT);
  future.length = 0;
  present = now;
  showButtons();
}

/** Goes to the last snapshot of one list; the present goes to the other. @param {Snapshot[]} from @param {Snapshot[]} to @param {string} said */
async function go(from, to, said) {
  // what was typed just now is an edit, too
  record();
  await endUpdate();
  const next = state.phase === 'idle' && !isRestoring ? from.pop() : undefined;
  if (!next) return;
  isRestoring = true;
  to.push(present);
  try {
    await restoreGeometries(next.geometries);
    change('colours', { colours: new Map(next.colours) });
    change('settings', { settings: next.settings });
    change('legend', { hidden: new Set(next.hidden) });
    present = snapshot();
    byId('status').textContent = said;
  } finally {
    isRestoring = false;
    showButtons();
  }
}

function showButtons() {
  const isBusy = state.phase !== 'idle' && state.phase !== 'updating';
  buttonOf('undo').disabled = isBusy || past.length === 0;
  buttonOf('redo').disabled = isBusy || future.length === 0;
}

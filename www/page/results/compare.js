/** The mesh compared with that of a column file: which cells differ, by pairs of flags, a button that flies to the first of each. */
import { buttonOf, byId, make, onInput } from '../elements/dom.js';
import { save } from '../downloads/downloads.js';
import { count } from '../text/format.js';
import { showError } from '../elements/messages.js';
import { centreOf, placeText } from '../text/places.js';
import { baseName } from '../settings/share.js';
import { moveTo } from '../view/crosshair.js';
import { isShown, showPanes } from '../view/panes.js';
import { change, on, state } from '../state/state.js';
import { task } from '../elements/tasks.js';
import { lookAt } from '../view/view3d.js';

/** @typedef {import('hexcast').Report} Report @typedef {import('hexcast').FlagPair} FlagPair */

/** Connects the chooser and the place for files to be dropped on. */
export function startCompare() {
  byId('compare-choose').addEventListener('click', () => byId('compare-input').click());
  onInput('compare-input', 'change', (input) => {
    const [file] = input.files ?? [];
    input.value = '';
    if (file) compare(file);
  });
  // before the page, which would open it in place of its mesh
  byId('compare').addEventListener('drop', (event) => {
    const [file] = event.dataTransfer?.files ?? [];
    if (!file) return;
    event.preventDefault();
    compare(file);
  });
  byId('compare-save').addEventListener('click', saveMask);
  byId('compare-clear').addEventListener('click', () => {
    forget();
    byId('compare-choose').focus();
  });
  on('mesh', forget);
}

/** Lets go of what was found. */
function forget() {
  state.difference?.mask.dispose();
  byId('compare-result').hidden = true;
  byId('compare-answer').textContent = '';
  byId('compare-pairs').replaceChildren();
  change('difference', { difference: null });
}

/** @param {File} file */
async function compare(file) {
  const { mesh, mesher } = state;
  if (!mesh || !mesher) return;
  forget();
  const choose = buttonOf('compare-choose');
  choose.disabled = true;
  try {
    await task(`Comparing with ${file.name}`, async ({ signal }) => {
      const other = await mesher.open(file, { signal });
      try {
        const found = await mesh.diff(other, { signal });
        // another mesh may have been made meanwhile
        if (mesh !== state.mesh) return found.mask.dispose();
        change('difference', { difference: { ...found, file: file.name } });
        show(found, mesh, other.report);
      } finally {
        other.dispose();
      }
      return undefined;
    });
  } catch (error) {
    showError(error, file.name);
  } finally {
    choose.disabled = false;
    byId('compare-choose').focus({ preventScroll: true });
  }
}

/** @param {import('hexcast').Difference} found @param {import('hexcast').Mesh} mesh @param {Report} other */
function show({ cells, n_cells, are_lines_equal, pairs }, mesh, other) {
  const lines = are_lines_equal ? '' : ' The meshes have other lines: cells were compared by their indices.';
  const answer =
    cells === 0
      ? `All ${count(n_cells)} cells have the same flags.`
      : `${count(cells)} of ${count(n_cells)} cells differ; slices mark them.`;
  byId('compare-answer').textContent = answer + lines;
  byId('compare-result').hidden = cells === 0;
  byId('compare-pairs').replaceChildren(...pairs.map((pair) => row(pair, mesh, other)));
}

/** @param {FlagPair} pair @param {import('hexcast').Mesh} mesh @param {Report} other */
function row({ one, other, cells, first, bounds }, mesh, { flags }) {
  const [here, there] = [named(one, mesh.report.flags), named(other, flags)];
  const [low, high] = bounds.map((corner) => corner.join(', '));
  const place = centreOf(mesh.lines, first);
  const fly = () => {
    if (!(/** @type {const} */ (['x', 'y', 'z']).some(isShown))) showPanes('z');
    lookAt(place);
    moveTo(first, { isPicked: true });
  };
  const name = `Show the first cell of ${here} that is ${there} in the file, at ${placeText(place, mesh.lines)}`;
  const button = make('button', { type: 'button', className: 'small', 'aria-label': name, on: { click: fly } }, 'Show');
  return make(
    'tr',
    { 'data-pair': `${one} ${other}` },
    make('th', { scope: 'row' }, here),
    make('td', {}, there),
    make('td', { className: 'number', title: `in the box of cells ${low} to ${high}` }, count(cells)),
    make('td', {}, button),
  );
}

/** A flag with its name. @param {number} flag @param {Report['flags']} flags */
function named(flag, flags) {
  const name = flags.find((entry) => entry.flag === flag)?.name;
  return flag === 0 ? '0 background' : `${flag}${name ? ` ${name}` : ''}`;
}

async function saveMask() {
  const { difference } = state;
  if (!difference) return;
  try {
    save(await difference.mask.blob('hxc'), `${baseName(state.job)}-differs.hxc`);
  } catch (error) {
    showError(error);
  }
}

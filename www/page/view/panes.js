/** The panes of the view: the 3-D view or a slice has the whole of it, or all four share it. */
import { byId, inputOf } from '../elements/dom.js';
import { offerLook, takeLook } from '../settings/looks.js';
import { change, on } from '../state/state.js';

/** @typedef {'3d' | 'x' | 'y' | 'z' | 'four'} Panes slices are named for the axis across them */

/** In the order of their keys, 1 to 4. */
const PANES = /** @type {const} */ (['z', 'y', 'x', '3d']);
/** @type {readonly Panes[]} */
const CHOICES = [...PANES, 'four'];
/** Fields into which people type; a key there is no command. */
const TYPED = 'input:not([type="radio"], [type="checkbox"], [type="range"], [type="color"]), select, textarea, dialog';

/** @type {Panes} */
let shown = '3d';
/** Whether the pane that is shown alone was one of four. */
let isEnlarged = false;

/** Connects the choice of panes, its keys and double clicks. */
export function startPanes() {
  for (const name of CHOICES) inputOf(`panes-${name}`).addEventListener('change', () => showPanes(name));
  for (const name of PANES)
    byId(`pane-${name}`).addEventListener('dblclick', ({ target }) => target instanceof HTMLCanvasElement && enlarge(name));
  document.addEventListener('keydown', takeKey);
  const phone = matchMedia('(max-width: 760px)');
  // four have no room there
  phone.addEventListener('change', () => phone.matches && shown === 'four' && showPanes('3d'));
  offerLook('panes', () => (shown === '3d' ? '' : shown));
  on('mesh', () => {
    const asked = takeLook('panes');
    const known = CHOICES.find((name) => name === asked);
    if (known) showPanes(known);
  });
}

/** Shows one pane or all four. @param {Panes} name */
export function showPanes(name) {
  if (name === 'four' && byId('four').offsetParent === null) return;
  isEnlarged = shown === 'four' && name !== 'four';
  shown = name;
  inputOf(`panes-${name}`).checked = true;
  byId('panes').classList.toggle('four', name === 'four');
  for (const pane of PANES) byId(`pane-${pane}`).hidden = name !== 'four' && name !== pane;
  change('panes');
  change('look');
}

/** Whether all four are shown. */
export function areFour() {
  return shown === 'four';
}

/** Whether a pane is shown. @param {Panes} name */
export function isShown(name) {
  return shown === name || shown === 'four';
}

/** Gives a pane the whole view, or the view back to all four. @param {Panes} name */
function enlarge(name) {
  showPanes(shown === name ? 'four' : name);
}

/** @param {KeyboardEvent} event */
function takeKey({ key, target, ctrlKey, metaKey, altKey, defaultPrevented }) {
  if (defaultPrevented || ctrlKey || metaKey || altKey || (target instanceof Element && target.closest(TYPED))) return;
  if (/^[1-4]$/.test(key)) enlarge(PANES[Number(key) - 1]);
  else if (key === 'Escape' && isEnlarged && document.body.dataset.phase !== 'meshing') showPanes('four');
}

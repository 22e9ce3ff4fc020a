/** The line below the panes: which cell a pointer or the crosshair is on, and what to do next. */
import { byId } from '../elements/dom.js';
import { state } from '../state/state.js';
import { cellText } from '../text/cell_facts.js';

/** Says a cell, its place and its flag. @param {number[] | null} cell null for none @param {number} [flag] @param {'off' | 'polite'} [live] */
export function nameCell(cell, flag = 0, live = 'off') {
  const output = byId('readout');
  const { mesh } = state;
  output.ariaLive = live;
  const text = cell && mesh ? cellText(mesh, cell, flag) : '';
  if (output.textContent !== text) output.textContent = text;
}

/** Says what is to be done, or with an empty text nothing. @param {string} text */
export function prompt(text) {
  byId('view-prompt').textContent = text;
}

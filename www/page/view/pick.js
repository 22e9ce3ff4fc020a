/** What becomes of a cell that people click, tap or press Enter on. */
import { inspect } from './inspector.js';
import { isMeasuring, takePoint } from './measure.js';
import { prompt } from './readout.js';
import { byId } from '../elements/dom.js';

/** Receives the cell that is picked next. @type {((cell: number[]) => void) | null} */
let picker = null;

/** Lets the next cell that is picked go to a listener; null ends that. @param {((cell: number[]) => void) | null} listener @param {string} [text] what to do */
export function pickNext(listener, text = '') {
  picker = listener;
  prompt(text);
  byId('panes').classList.toggle('picking', listener !== null);
}

/** Takes a cell that was picked. @param {number[]} cell */
export function picked(cell) {
  const listener = picker;
  if (listener) {
    pickNext(null);
    listener(cell);
  } else if (isMeasuring()) takePoint(cell);
  else inspect(cell);
}

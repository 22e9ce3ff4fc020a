/** Measures between two cells that are picked: their distance, and how many cells they are apart. */
import { byId, buttonOf, make } from '../elements/dom.js';
import { measure, times } from '../text/format.js';
import { cellAt, centreOf, many, placeAt } from '../text/places.js';
import { change, on, state } from '../state/state.js';
import { prompt } from './readout.js';

const FIRST = 'Measure: click the first cell, or Enter at the crosshair';
const SECOND = 'Measure: click the second cell, or Enter at the crosshair';

/** Whether picked cells are measured. */
let isOn = false;
/** Places of the cells, in world lengths: none, one or two. @type {number[][]} */
let points = [];

/** Connects the button, and Escape. */
export function startMeasure() {
  byId('measure').addEventListener('click', () => turn(!isOn));
  byId('measure-close').addEventListener('click', () => {
    turn(false);
    byId('measure').focus();
  });
  document.addEventListener('keydown', (event) => {
    if (event.key !== 'Escape' || !isOn || event.defaultPrevented) return;
    event.preventDefault();
    turn(false);
  });
  on('mesh', () => {
    const { mesh } = state;
    // they stay in the cells that hold them now
    const isWithin = mesh && points.every((place) => mesh.dims.every((n, axis) => isIn(mesh.lines, axis, n, place[axis])));
    buttonOf('measure').disabled = !mesh;
    if (!mesh && isOn) turn(false);
    if (!isWithin) points = [];
    show();
  });
}

/** @param {import('hexcast').Lines} lines @param {number} axis @param {number} n @param {number} at */
function isIn(lines, axis, n, at) {
  return at >= lines.origin[axis] && at < placeAt(lines, axis, n);
}

/** @param {boolean} now */
function turn(now) {
  isOn = now;
  points = [];
  byId('measure').ariaPressed = String(isOn);
  prompt('');
  show();
}

/** Whether the cells that are picked are measured. */
export function isMeasuring() {
  return isOn;
}

/** Takes a cell that was picked. @param {number[]} cell */
export function takePoint(cell) {
  const { mesh } = state;
  if (!mesh) return;
  points = [...(points.length === 2 ? [] : points), centreOf(mesh.lines, cell)];
  show();
}

/** Cells that are measured. */
function cells() {
  const { mesh } = state;
  return mesh ? points.map((place) => cellAt(mesh.lines, place)) : [];
}

/** The centres of the cells that are measured: none, one or two. */
export function measured() {
  const { mesh } = state;
  return mesh ? cells().map((cell) => centreOf(mesh.lines, cell)) : [];
}

function show() {
  const { mesh } = state;
  if (isOn) prompt([FIRST, SECOND, ''][points.length]);
  const found = mesh && points.length === 2 ? facts(mesh) : [];
  byId('measured').hidden = found.length === 0;
  byId('measured-facts').replaceChildren(...found.flatMap(([term, value]) => [make('dt', {}, term), make('dd', {}, value)]));
  change('measure');
}

/** @param {import('hexcast').Mesh} mesh @returns {[string, string][]} */
function facts({ lines, report: { unit } }) {
  const [from, to] = cells();
  const [a, b] = [from, to].map((cell) => centreOf(lines, cell));
  const by = b.map((at, axis) => at - a[axis]);
  const apart = to.map((at, axis) => Math.abs(at - from[axis]));
  // from the lower face of one to the upper face of the other
  const outer = to.map(
    (at, axis) => placeAt(lines, axis, Math.max(at, from[axis]) + 1) - placeAt(lines, axis, Math.min(at, from[axis])),
  );
  const of = unit ? ` ${unit}` : '';
  return [
    ['From cell', from.join(', ')],
    ['To cell', to.join(', ')],
    ['Between their centres', measure(Math.hypot(...by), unit)],
    ...by.map(
      (length, axis) =>
        /** @type {[string, string]} */ ([`d${'xyz'[axis]}`, `${measure(length, unit)}, ${many(apart[axis], 'cell')}`]),
    ),
    ['With both cells', `${times(outer)}${of}`],
    ['', `${times(apart.map((n) => n + 1))} cells`],
  ];
}

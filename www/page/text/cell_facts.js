/** What the estimate and the result say of cells: their size or, where they differ, the lines. */
import { cellSize, short } from './format.js';
import { centreOf, placeText } from './places.js';

/** @typedef {import('hexcast').Grading} Grading */

/**
 * Facts as an id, a term and a value each.
 *
 * @param {string} prefix of the ids
 * @param {{ dims: number[], spacing: [number, number, number] | null, grading: Grading | null }} of
 * @param {string | null} unit
 * @returns {[string, string, string][]}
 */
export function cellFacts(prefix, { dims, spacing, grading }, unit) {
  if (spacing) return [[`${prefix}-size`, 'Cell', cellSize(spacing, unit ?? '')]];
  if (!grading) return [];
  const of = unit ? ` ${unit}` : '';
  const [least, most] = [Math.min(...grading.smallest), Math.max(...grading.largest)];
  const seconds = grading.courant_seconds === null ? '' : `, ${short3(grading.courant_seconds)} s`;
  return [
    [`${prefix}-size`, 'Cells from', `${short(least)} to ${short(most)}${of}`],
    [`${prefix}-lines`, 'Lines', dims.map((n) => n + 1).join(', ')],
    [`${prefix}-ratio`, 'Growth', `at most ${short3(Math.max(...grading.ratio))} times`],
    [`${prefix}-courant`, 'Courant step', `${short3(grading.courant_length)}${of} / c${seconds}`],
  ];
}

/** Three digits. @param {number} number */
function short3(number) {
  return String(Number(number.toPrecision(3)));
}

/** A flag with its name, such as `1 copper`. @param {import('hexcast').Report} report @param {number} flag not 0 */
export function nameOf({ flags }, flag) {
  const name = flags.find((entry) => entry.flag === flag)?.name;
  return name ? `${flag} ${name}` : String(flag);
}

/** A cell, its place and its flag in words. @param {import('hexcast').Mesh} mesh @param {number[]} cell @param {number} flag */
export function cellText({ lines, report }, cell, flag) {
  const { unit } = report;
  const place = `${placeText(centreOf(lines, cell), lines)}${unit ? ` ${unit}` : ''}`;
  return `cell ${cell.join(', ')} at ${place}: ${flag === 0 ? 'background' : `flag ${nameOf(report, flag).replace(' ', ', ')}`}`;
}

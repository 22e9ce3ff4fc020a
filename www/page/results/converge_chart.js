/** Errors of volume and area against cells, both axes logarithmic, as SVG that needs no style sheet. */
import { count } from '../text/format.js';
import { colourOf } from '../state/state.js';

/** @typedef {import('hexcast').Level} Level @typedef {[number, number][]} Points */

const [WIDTH, HEIGHT] = [360, 276];
/** The frame of the chart. */
const [LEFT, TOP, RIGHT, BOTTOM] = [58, 14, WIDTH - 12, HEIGHT - 58];
const MARK = 3;

/** @param {string} tag @param {Record<string, string | number>} attributes @param {...(Node | string)} children */
function svg(tag, attributes, ...children) {
  const element = document.createElementNS('http://www.w3.org/2000/svg', tag);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, String(value));
  element.append(...children);
  return element;
}

/** Draws the size of all errors; those of 0 have no place. @param {Level[]} levels */
export function convergeChart(levels) {
  const lines = levels[0].flags.flatMap(({ flag }, index) => [
    { flag, dash: '', points: pointsOf(levels, (level) => level.flags[index].volume_error) },
    { flag, dash: '4 3', points: pointsOf(levels, (level) => level.flags[index].area_error) },
  ]);
  const all = lines.flatMap(({ points }) => points);
  const sizes = levels.map(longest);
  const x = scale([Math.min(...sizes) * 0.9, Math.max(...sizes) * 1.1], [LEFT, RIGHT]);
  const errors = all.map(([, error]) => error);
  const y = scale(all.length > 0 ? [Math.min(...errors) * 0.6, Math.max(...errors) * 1.6] : [1e-3, 1], [BOTTOM, TOP]);
  const label = 'Errors of volume and of area as seen along the axes, against cells along the longest side';
  const chart = svg('svg', {
    xmlns: 'http://www.w3.org/2000/svg',
    viewBox: `0 0 ${WIDTH} ${HEIGHT}`,
    role: 'img',
    'aria-label': label,
    'font-family': 'sans-serif',
    'font-size': 11,
    fill: 'currentColor',
  });
  chart.append(svg('title', {}, label), ...axes(x, y, sizes));
  for (const { flag, dash, points } of lines) {
    const colour = colourOf(flag);
    const places = points.map(([size, error]) => [x.at(size), y.at(error)]);
    const path = places.map((place) => place.map((number) => number.toFixed(1)).join(' ')).join(' L ');
    if (places.length > 0)
      chart.append(
        svg('path', { d: `M ${path}`, fill: 'none', stroke: colour, 'stroke-width': 2, 'stroke-dasharray': dash || 'none' }),
      );
    for (const [cx, cy] of places) chart.append(svg('circle', { cx, cy, r: MARK, fill: colour }));
  }
  const dashes = [
    ['volume', 'none', LEFT + 76],
    ['area', '4 3', LEFT + 156],
  ];
  for (const [name, dash, from] of /** @type {[string, string, number][]} */ (dashes)) {
    const at = {
      x1: from,
      x2: from + 18,
      y1: HEIGHT - 9,
      y2: HEIGHT - 9,
      stroke: 'currentColor',
      'stroke-width': 2,
      'stroke-dasharray': dash,
    };
    chart.append(svg('line', at), svg('text', { x: from + 23, y: HEIGHT - 5 }, name));
  }
  return chart;
}

/** @param {Level} level */
function longest({ dims }) {
  return Math.max(...dims);
}

/** @param {Level[]} levels @param {(level: Level) => number | null} errorOf @returns {Points} */
function pointsOf(levels, errorOf) {
  return levels
    .map((level) => /** @type {[number, number]} */ ([longest(level), Math.abs(errorOf(level) ?? 0)]))
    .filter(([, error]) => error > 0);
}

/** A logarithmic scale. @param {number[]} ends @param {number[]} places */
function scale([least, most], [from, to]) {
  const [low, high] = [Math.log10(least), Math.log10(most)];
  return { least, most, at: (/** @type {number} */ value) => from + ((Math.log10(value) - low) / (high - low)) * (to - from) };
}

/** @typedef {ReturnType<typeof scale>} Scale @param {Scale} x @param {Scale} y @param {number[]} sizes */
function axes(x, y, sizes) {
  const frame = { fill: 'none', stroke: 'currentColor', 'stroke-opacity': 0.5 };
  const parts = [svg('rect', { x: LEFT, y: TOP, width: RIGHT - LEFT, height: BOTTOM - TOP, ...frame })];
  for (const size of sizes) {
    const at = x.at(size);
    parts.push(svg('line', { x1: at, x2: at, y1: BOTTOM, y2: BOTTOM + 4, stroke: 'currentColor' }));
    parts.push(svg('text', { x: at, y: BOTTOM + 16, 'text-anchor': 'middle' }, count(size)));
  }
  for (let power = Math.ceil(Math.log10(y.least)); 10 ** power <= y.most; power += 1) {
    const at = y.at(10 ** power);
    parts.push(svg('line', { x1: LEFT, x2: RIGHT, y1: at, y2: at, stroke: 'currentColor', 'stroke-opacity': 0.2 }));
    parts.push(svg('text', { x: LEFT - 6, y: at + 4, 'text-anchor': 'end' }, `${Number((100 * 10 ** power).toPrecision(3))} %`));
  }
  parts.push(svg('text', { x: (LEFT + RIGHT) / 2, y: HEIGHT - 26, 'text-anchor': 'middle' }, 'cells along the longest side'));
  return parts;
}

// A plot of points with both axes logarithmic, as SVG without fonts or scripts from elsewhere.

/**
 * @typedef {[number, number]} Point
 * @typedef {{ name: string, points: Point[], marked?: Point[] }} Series
 * @typedef {(number: number) => number} Scale
 */

const WIDTH = 640;
const HEIGHT = 440;
const BOX = { left: 72, right: 616, top: 44, bottom: 316 };
const DASHES = ' stroke-dasharray="6 5"';
const COLOURS = ['#0b6e99', '#c2571a', '#6b7280', '#4d7c0f'];

/**
 * Draws series of points.
 *
 * @param {{title: string, x: string, y: string, series: Series[]}} plot
 *   `x` and `y` name the axes with their units; all numbers are greater than 0; a series with `marked` is drawn dashed, with
 *   marks at these points alone
 * @returns {string} the SVG
 */
export function logLogPlot({ title, x, y, series }) {
  const points = series.flatMap((one) => one.points);
  const across = scale(
    points.map((point) => point[0]),
    BOX.left,
    BOX.right,
  );
  const up = scale(
    points.map((point) => point[1]),
    BOX.bottom,
    BOX.top,
  );
  const middle = (BOX.top + BOX.bottom) / 2;
  return [
    `<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 ${WIDTH} ${HEIGHT}" font-family="system-ui, sans-serif" font-size="13" fill="#1f2937">`,
    `<title>${escapeXml(title)}</title>`,
    `<rect width="${WIDTH}" height="${HEIGHT}" fill="#ffffff"/>`,
    text(BOX.left, 28, title, 'font-size="15" font-weight="600"'),
    ...across.ticks.map((tick) => line([tick.at, BOX.top], [tick.at, BOX.bottom], tick.label ? '#d1d5db' : '#f0f1f3')),
    ...up.ticks.map((tick) => line([BOX.left, tick.at], [BOX.right, tick.at], tick.label ? '#d1d5db' : '#f0f1f3')),
    ...across.ticks.map((tick) => text(tick.at, BOX.bottom + 18, tick.label, 'text-anchor="middle"')),
    ...up.ticks.map((tick) => text(BOX.left - 8, tick.at + 4, tick.label, 'text-anchor="end"')),
    text((BOX.left + BOX.right) / 2, BOX.bottom + 36, x, 'text-anchor="middle"'),
    text(18, middle, y, `text-anchor="middle" transform="rotate(-90 18 ${middle})"`),
    ...series.flatMap((one, index) => drawn(one, COLOURS[index % COLOURS.length], across.to, up.to)),
    ...legend(series),
    '</svg>\n',
  ]
    .filter(Boolean)
    .join('\n');
}

/** The slope of the line through points in log-log, least squares: 1 means proportional. @param {Point[]} points */
export function slope(points) {
  const logs = points.map((point) => point.map(Math.log));
  const mean = (/** @type {number} */ axis) => logs.reduce((sum, log) => sum + log[axis], 0) / logs.length;
  const [mx, my] = [mean(0), mean(1)];
  const sum = (/** @type {(log: number[]) => number} */ term) => logs.reduce((total, log) => total + term(log), 0);
  return sum(([x, y]) => (x - mx) * (y - my)) / sum(([x]) => (x - mx) ** 2);
}

/**
 * A logarithmic scale over numbers with some room: where each falls, and ticks at 1, 2, ... 9 of every decade.
 *
 * @param {number[]} numbers
 * @param {number} from
 * @param {number} to
 */
function scale(numbers, from, to) {
  const [low, high] = [Math.log10(Math.min(...numbers)) - 0.12, Math.log10(Math.max(...numbers)) + 0.12];
  const at = (/** @type {number} */ number) => round(from + ((Math.log10(number) - low) / (high - low)) * (to - from));
  /** @type {{ at: number, label: string }[]} */
  const ticks = [];
  for (let decade = Math.floor(low); decade <= high; decade++) {
    for (let digit = 1; digit < 10; digit++) {
      const log = decade + Math.log10(digit);
      // between decades, labels only where few decades leave room for them
      const isNamed = digit === 1 || (high - low < 2.2 && (digit === 2 || digit === 5));
      if (log >= low && log <= high) ticks.push({ at: at(10 ** log), label: isNamed ? numeral(digit, decade) : '' });
    }
  }
  return { to: at, ticks };
}

/** @param {number} digit @param {number} decade */
const numeral = (digit, decade) => (decade >= -3 && decade < 4 ? String(Number(`${digit}e${decade}`)) : `${digit}e${decade}`);
/** @param {number} number */
const round = (number) => Math.round(10 * number) / 10;

/** @param {Series} series @param {string} colour @param {Scale} x @param {Scale} y */
function drawn({ points, marked }, colour, x, y) {
  const [places, marks] = [points, marked ?? points].map((list) => list.map((point) => [x(point[0]), y(point[1])]));
  const path = `<polyline points="${places.join(' ')}" fill="none" stroke="${colour}" stroke-width="2"${marked ? DASHES : ''}/>`;
  return [path, ...marks.map(([cx, cy]) => `<circle cx="${cx}" cy="${cy}" r="4.5" fill="${colour}"/>`)];
}

/** Names under the plot, one line each. @param {Series[]} series */
function legend(series) {
  return series.flatMap(({ name, marked }, index) => {
    const [colour, y] = [COLOURS[index % COLOURS.length], BOX.bottom + 58 + 18 * index];
    const stroke = `<path d="M${BOX.left} ${y - 4}h30" stroke="${colour}" stroke-width="2"${marked ? DASHES : ''}/>`;
    return [stroke, text(BOX.left + 40, y, name)];
  });
}

/** @param {Point} from @param {Point} to @param {string} colour */
const line = ([x1, y1], [x2, y2], colour) => `<path d="M${x1} ${y1}L${x2} ${y2}" stroke="${colour}"/>`;
/** @param {number} x @param {number} y @param {string} words */
const text = (x, y, words, attributes = '') => words && `<text x="${x}" y="${y}" ${attributes}>${escapeXml(words)}</text>`;
/** @param {string} words */
const escapeXml = (words) => words.replaceAll('&', '&amp;').replaceAll('<', '&lt;');

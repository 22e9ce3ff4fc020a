/** The legend of a saved picture of the 3-D view: a strip below it with the flags that are seen, and the sizes of the mesh. */
import { cellFacts } from '../text/cell_facts.js';
import { count, times } from '../text/format.js';
import { domainOf } from '../settings/settings.js';
import { colourOf, state } from '../state/state.js';

/** Pixels: the file has two of each pixel of the screen. */
const [LETTERS, LINE, MARGIN] = [26, 40, 24];
/** A file is looked at on paper, whatever colours the page has. */
const [PAPER, INK] = ['#ffffff', '#17202a'];

/**
 * Adds the strip; of models without a mesh there is none.
 *
 * @param {Blob} picture
 * @param {import('hexcast').Mesh | null} mesh whose cells are seen
 * @returns {Promise<Blob>}
 */
export async function withLegend(picture, mesh) {
  if (!mesh) return picture;
  const bitmap = await createImageBitmap(picture);
  const canvas = new OffscreenCanvas(bitmap.width, bitmap.height);
  const context = /** @type {OffscreenCanvasRenderingContext2D} */ (canvas.getContext('2d'));
  const font = `${LETTERS}px ${getComputedStyle(document.documentElement).fontFamily}`;
  context.font = font;
  const seen = mesh.report.flags.filter(({ flag, cells }) => cells > 0 && !state.hidden.has(flag));
  const entries = seen.map(({ flag, name, cells }) => ({ flag, text: `${flag} ${name}: ${count(cells)} cells` }));
  const swatch = LETTERS + 10;
  const widest = Math.max(0, ...entries.map(({ text }) => swatch + context.measureText(text).width + 2 * MARGIN));
  const n_columns = Math.max(1, Math.floor((canvas.width - MARGIN) / widest));
  const top = bitmap.height;
  canvas.height = top + 2 * MARGIN + LINE * (1 + Math.ceil(entries.length / n_columns));
  context.drawImage(bitmap, 0, 0);
  // a canvas of another size has forgotten them
  Object.assign(context, { font, textBaseline: 'middle', fillStyle: PAPER });
  context.fillRect(0, top, canvas.width, canvas.height - top);
  for (const [at, { flag, text }] of entries.entries()) {
    const [x, y] = [MARGIN + (at % n_columns) * widest, top + MARGIN + LINE * (Math.floor(at / n_columns) + 0.5)];
    context.fillStyle = colourOf(flag);
    context.fillRect(x, y - LETTERS / 2, LETTERS, LETTERS);
    context.fillStyle = INK;
    context.fillText(text, x + swatch, y);
  }
  context.fillStyle = INK;
  context.fillText(sizes(mesh), MARGIN, canvas.height - MARGIN - LINE / 2, canvas.width - 2 * MARGIN);
  return canvas.convertToBlob({ type: 'image/png' });
}

/** The box and a cell in words. @param {import('hexcast').Mesh} mesh */
function sizes({ report }) {
  const box = domainOf(report);
  const unit = report.unit ? ` ${report.unit}` : '';
  const [[, term, value] = ['', '', '']] = cellFacts('', report, report.unit);
  return `Box ${times([0, 1, 2].map((axis) => box[axis + 3] - box[axis]))}${unit}; ${term.toLowerCase()} ${value}`;
}

/** The cells of a slice that differ from those of another mesh: hatched, so that the colours of flags are seen, too; small ones filled. */

/** CSS pixels from a stripe to the next, and of the least cell that is hatched: of smaller ones some would lie between stripes. */
const STRIPES = 8;

/** The mask of a plane as pixels, white where cells differ; rows are downwards. @param {import('hexcast').Slice} mask */
export function maskBitmap({ width, height, flags }) {
  const bitmap = new OffscreenCanvas(width, height);
  const image = new ImageData(width, height);
  const pixels = new Uint32Array(image.data.buffer);
  for (const [at, flag] of flags.entries()) {
    const [column, row] = [at % width, Math.floor(at / width)];
    if (flag > 0) pixels[column + width * (height - 1 - row)] = 0xffffffff;
  }
  bitmap.getContext('2d')?.putImageData(image, 0, 0);
  return bitmap;
}

/**
 * Marks what a bitmap covers.
 *
 * @param {CanvasRenderingContext2D} context
 * @param {(context: OffscreenCanvasRenderingContext2D) => void} cover draws the bitmap where its cells are
 * @param {number} ratio pixels of the screen a CSS pixel
 * @param {number} least pixels of the smallest cell
 */
export function markCells(context, cover, ratio, least) {
  const { width, height } = context.canvas;
  const layer = new OffscreenCanvas(width, height);
  const within = layer.getContext('2d');
  if (!within) return;
  within.imageSmoothingEnabled = false;
  cover(within);
  // only what is covered stays
  within.globalCompositeOperation = 'source-in';
  const size = Math.round(STRIPES * ratio);
  within.fillStyle = (least >= size && stripes(within, size)) || getComputedStyle(context.canvas).getPropertyValue('--mark');
  within.fillRect(0, 0, width, height);
  context.drawImage(layer, 0, 0);
}

/** Black and white stripes at 45 degrees, with what is below between them. @param {OffscreenCanvasRenderingContext2D} context @param {number} size */
function stripes(context, size) {
  const tile = new OffscreenCanvas(size, size);
  const image = new ImageData(size, size);
  const pixels = new Uint32Array(image.data.buffer);
  for (let at = 0; at < pixels.length; at += 1) {
    const step = ((at % size) + Math.floor(at / size)) % size;
    if (step < size / 4) pixels[at] = 0xff000000;
    else if (step < size / 2) pixels[at] = 0xffffffff;
  }
  tile.getContext('2d')?.putImageData(image, 0, 0);
  return context.createPattern(tile, 'repeat');
}

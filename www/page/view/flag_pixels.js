/** Flags as pixels. */
import { colourOf, rgb } from '../state/state.js';

/** Colours of all flags as bytes red, green, blue and alpha, the last 0 for the background and hidden ones. @param {Set<number>} hidden */
export function flagColours(hidden) {
  const bytes = new Uint8Array(4 * 256);
  for (let flag = 1; flag < 256; flag += 1) if (!hidden.has(flag)) bytes.set([...rgb(colourOf(flag)), 255], 4 * flag);
  return new Uint32Array(bytes.buffer);
}

/**
 * Paints a slice, one pixel a sample; background and hidden flags stay transparent. The second axis is upwards, as pictures have rows
 * downwards.
 *
 * @param {import('../../hexcast.js').Slice} slice
 * @param {Set<number>} hidden
 * @returns {ImageData}
 */
export function paint({ width, height, flags }, hidden) {
  const image = new ImageData(width, height);
  const pixels = new Uint32Array(image.data.buffer);
  const table = flagColours(hidden);
  for (let row = 0; row < height; row += 1) {
    const from = width * (height - 1 - row);
    for (let column = 0; column < width; column += 1) pixels[width * row + column] = table[flags[from + column]];
  }
  return image;
}

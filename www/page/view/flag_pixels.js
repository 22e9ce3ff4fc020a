/** Flags as pixels. */
import { colourOf, rgb } from '../state/state.js';

/**
 * Paints a slice, one pixel a sample; background and hidden flags stay transparent.
 *
 * @param {import('../../hexcast.js').Slice} slice
 * @param {{isUp: boolean, hidden: Set<number>}} options `isUp` puts the second axis upwards, as pictures have rows downwards
 * @returns {ImageData}
 */
export function paint({ width, height, flags }, { isUp, hidden }) {
  const image = new ImageData(width, height);
  const pixels = new Uint32Array(image.data.buffer);
  const table = new Uint32Array(256);
  for (let flag = 1; flag < 256; flag += 1) {
    if (hidden.has(flag)) continue;
    const [red, green, blue] = rgb(colourOf(flag));
    table[flag] = new Uint32Array(new Uint8Array([red, green, blue, 255]).buffer)[0];
  }
  for (let row = 0; row < height; row += 1) {
    const from = width * (isUp ? height - 1 - row : row);
    for (let column = 0; column < width; column += 1) pixels[width * row + column] = table[flags[from + column]];
  }
  return image;
}

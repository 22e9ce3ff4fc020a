// The page's samples, made here.

import { sampleFiles } from '../../www/page/geometries/sample_models.js';

/**
 * The files of a sample as `[name, text]`: each byte is a letter of the text, which is how a page is handed bytes. There,
 * `Uint8Array.from(text, (letter) => letter.charCodeAt(0))` has them again.
 *
 * @param {string} id
 * @returns {Promise<[string, string][]>}
 */
export function sampleTexts(id) {
  const text = async ({ source }) => [source.name, Buffer.from(await source.arrayBuffer()).toString('latin1')];
  return Promise.all(sampleFiles(id).map(text));
}

/** The text of the sample that most tests mesh. */
export async function knotText() {
  const [[, text]] = await sampleTexts('knot');
  return text;
}

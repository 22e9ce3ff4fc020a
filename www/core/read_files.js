/** Files into the wasm in slices: a Blob is never read as a whole. */
import { cancelled, pause } from '../protocol/call.js';

const SLICE_BYTES = 4 << 20;

/**
 * Reads a surface.
 *
 * @param {import('./core.js').Glue} glue
 * @param {string} file its name
 * @param {Blob | Uint8Array} source
 * @param {import('../protocol/call.js').Listener} progress
 * @param {import('../protocol/call.js').State} state
 */
export async function readSurface(glue, file, source, progress, state) {
  const isBlob = source instanceof Blob;
  const total = isBlob ? source.size : source.byteLength;
  const reader = new glue.WebReader(file, total);
  // of a Blob the next slice comes while one is read
  const slice = (/** @type {number} */ at) => (isBlob ? source.slice(at, at + SLICE_BYTES).arrayBuffer() : null);
  let next = slice(0);
  try {
    for (let at = 0; at < total; at += SLICE_BYTES) {
      const end = Math.min(at + SLICE_BYTES, total);
      const bytes = await next;
      next = end < total ? slice(end) : null;
      // a failure counts when its slice is asked for
      next?.catch(() => {});
      reader.push(isBlob ? new Uint8Array(/** @type {ArrayBuffer} */ (bytes)) : source.subarray(at, end));
      progress({ stage: 'read', done: end, total });
      // a slice that was there already came without a wait in which a message could
      await pause();
      if (state.cancelled) throw cancelled();
    }
  } catch (error) {
    reader.free();
    throw error;
  }
  return reader.finish();
}

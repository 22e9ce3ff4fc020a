/** Files into the wasm in slices: a Blob is never read as a whole. */
import { cancelled, pause } from './call.js';
import { WebReader } from './hexcast_wasm.js';

const SLICE_BYTES = 4 << 20;

/**
 * Reads a surface.
 *
 * @param {string} file its name
 * @param {Blob | Uint8Array} source
 * @param {import('./call.js').Listener} progress
 * @param {import('./call.js').State} state
 */
export async function readSurface(file, source, progress, state) {
  const isBlob = source instanceof Blob;
  const total = isBlob ? source.size : source.byteLength;
  const reader = new WebReader(file, total);
  for (let at = 0; at < total; at += SLICE_BYTES) {
    const end = Math.min(at + SLICE_BYTES, total);
    reader.push(isBlob ? new Uint8Array(await source.slice(at, end).arrayBuffer()) : source.subarray(at, end));
    progress({ stage: 'read', done: end, total });
    // bytes in memory come without a wait in which a message could
    if (!isBlob) await pause();
    if (state.cancelled) throw cancelled();
  }
  return reader.finish();
}

/** SHA-256 of the raw file of a mesh, in steps between which messages arrive. */
import { cancelled, pause } from '../protocol/call.js';

/**
 * @param {import('../hexcast_wasm.js').WebMesh} mesh
 * @param {string} options those of the file, as JSON
 * @param {import('../protocol/call.js').Listener} progress
 * @param {import('../protocol/call.js').State} state
 */
export async function sha256(mesh, options, progress, state) {
  const total = mesh.size('raw', Boolean(JSON.parse(options).bits)) ?? 0;
  const hash = mesh.hash(options);
  try {
    while (hash.step()) {
      progress({ stage: 'write', done: hash.nBytes(), total });
      await pause();
      if (state.cancelled) throw cancelled();
    }
  } catch (error) {
    hash.free();
    throw error;
  }
  return hash.finish();
}

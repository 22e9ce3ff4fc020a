/**
 * zlib, in a wasm of its own: the library is a third of the size of all the rest, and only compressed files need it. It is
 * loaded before the first of them is written or read, and lent to the wasm that meshes.
 */
import init, { deflate, inflate } from './hexcast_zlib_wasm.js';

let loading = null;

/**
 * Loads it, once a thread; a failure may be tried again.
 *
 * @param source where it is, its bytes, the compiled module, or a function that gets one of these
 * @returns {Promise<{deflate, inflate}>} functions that throw a sentence
 */
export function loadZlib(source) {
  loading ??= load(source).catch((error) => {
    loading = null;
    throw JSON.stringify({ code: 'io', message: `zlib cannot be loaded: ${error?.message ?? error}`, hint: HINT });
  });
  return loading;
}

const HINT = 'leave out compress: files that are not compressed need no zlib; else see that hexcast_zlib_bg.wasm is beside the package\'s scripts, or say where with the option zlib';

async function load(source) {
  await init({ module_or_path: typeof source === 'function' ? await source() : source });
  return { deflate, inflate };
}

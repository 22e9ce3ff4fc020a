/** Threads of the wasm: workers that share its memory. Each waits in `threads/` until all are there. */

/**
 * A worker that was started: it answers once, when it waits.
 *
 * @typedef {{ ready: Promise<unknown>, end: () => void }} Thread
 * @typedef {{ module: WebAssembly.Module, memory: WebAssembly.Memory, failures?: string }} Shared a wasm, its memory, and the name of the
 *   channel on which a thread says that it failed
 * @typedef {(shared: Shared) => Thread} StartThread
 * @typedef {Omit<typeof import('../hexcast_wasm.js'), 'default' | 'initSync'> & { default: Load, startThreads?: (n: number) => boolean }} Glue
 *   of a wasm: that with threads can start them
 * @typedef {(given: { module_or_path: any }) => Promise<{ memory: WebAssembly.Memory }>} Load
 */

/** How many threads each glue has: a wasm has one pool, which the first mesher starts. @type {WeakMap<Glue, Promise<number>>} */
const pools = new WeakMap();

/**
 * Starts the threads of a wasm that is loaded; returns how many there are: 1 where the work is done on the calling thread, as one cannot
 * be started.
 *
 * @param {Glue} glue
 * @param {Shared} shared
 * @param {StartThread} start
 * @param {number} n
 */
export function startThreads(glue, shared, start, n) {
  const pool = pools.get(glue) ?? startPool(glue, shared, start, n);
  pools.set(glue, pool);
  return pool;
}

/** @param {Glue} glue @param {Shared} shared @param {StartThread} start @param {number} n */
async function startPool(glue, shared, start, n) {
  /** @type {Thread[]} */
  const threads = [];
  try {
    for (let index = 0; index < n; index++) threads.push(start(shared));
    await Promise.all(threads.map(({ ready }) => ready));
    if (glue.startThreads?.(n)) return n;
  } catch {
    // such as a worker that its page does not let start
  }
  for (const thread of threads) thread.end();
  return 1;
}

/** Compiles a wasm, which its threads run too. @param {any} source its address, bytes or module @returns {Promise<WebAssembly.Module>} */
export async function compiled(source) {
  if (source instanceof WebAssembly.Module) return source;
  return typeof source === 'string' ? WebAssembly.compileStreaming(fetch(source)) : WebAssembly.compile(source);
}

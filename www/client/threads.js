/**
 * Threads of the wasm: workers that share its memory. Whoever asks for a mesher starts them, not the worker of its core: in Firefox a worker
 * that starts another waits until that is registered, and may miss the only time that it is told.
 */
import { startWorker } from '../start_worker.js';

/**
 * @typedef {import('./connection.js').Connection} Connection
 * @typedef {{ module: WebAssembly.Module, memory: WebAssembly.Memory }} Shared a wasm and its memory
 * @typedef {(shared: Shared, connection: Connection) => Promise<unknown>} StartThread starts a thread, which waits for work when it resolves
 */

/** How many threads a wasm has: it has one pool, which the first mesher starts. @type {WeakMap<WebAssembly.Memory, Promise<number>>} */
const pools = new WeakMap();

/**
 * Starts the threads of a wasm that is loaded; returns how many there are.
 *
 * @param {Connection} connection
 * @param {Shared} shared
 * @param {number} n
 * @param {StartThread} [start]
 */
export function startThreads(connection, shared, n, start = startThread) {
  const pool = pools.get(shared.memory) ?? startPool(connection, shared, n, start);
  pools.set(shared.memory, pool);
  return pool;
}

/** @param {Connection} connection @param {Shared} shared @param {number} n @param {StartThread} start */
async function startPool(connection, shared, n, start) {
  await Promise.all(Array.from({ length: n }, () => start(shared, connection)));
  await connection.call('startThreads', { n });
  return n;
}

/** A thread of a page: it ends and fails with the connection. @type {StartThread} */
function startThread(shared, connection) {
  const worker = startWorker();
  connection.attach(worker);
  return new Promise((resolve, reject) => {
    worker.onmessage = ({ data }) => (data === null ? resolve(data) : connection.fail(data));
    worker.onerror = reject;
    worker.postMessage(shared);
  });
}

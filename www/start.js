/** Starts a mesher: checks its options, connects to a core and opens a backend there. */
import { MESHER, gpuDevice, kindOf, oneOf, optionsOf, wholeNumber, wrongValue } from './client/check.js';
import { Connection, localPort, workerPort } from './client/connection.js';
import { Mesher } from './client/mesher.js';
import { fileOf } from './client/source.js';
import { startThreads } from './client/threads.js';
import { packageFolder } from './platform/own_files.js';
import { HexcastError } from './protocol/error.js';
import { startWorker } from './start_worker.js';

/** @typedef {import('./hexcast.js').MesherOptions} MesherOptions */
/** @typedef {import('./core/core.js').Core} Core */

/** Most threads that are started where nobody says how many: each takes some MB, and waits for memory as the others do. */
export const MOST_THREADS = 16;
/** Most threads that can be asked for. */
const MAX_THREADS = 256;

/**
 * Checks the options of `createMesher`, before anything is loaded.
 *
 * @param {MesherOptions | undefined} options
 */
export function checked(options) {
  const given = optionsOf(options, MESHER);
  const { backend = 'auto', threads, wasm, worker, device } = given;
  oneOf('backend', backend, ['auto', 'gpu', 'cpu']);
  if (threads !== undefined) wholeNumber('threads', threads, 1, MAX_THREADS);
  checkWorker(worker);
  if (wasm !== undefined) checkWasm(wasm);
  if (device !== undefined) checkDevice(device, backend, worker);
  return { ...given, backend, device: /** @type {GPUDevice | undefined} */ (device) };
}

/**
 * A core on this thread and where its wasm is: that of many threads, or that of one.
 *
 * @typedef {(hasThreads: boolean) => Promise<{ core: Core, source: string | URL | BufferSource, startThread?: StartThread }>} LocalCore
 * @typedef {import('./client/threads.js').StartThread} StartThread
 */

/**
 * Starts a mesher; `gpu` takes the place of `navigator.gpu` on this thread.
 *
 * @param {MesherOptions | undefined} options
 * @param {GPU | null} [gpu]
 * @param {LocalCore} [local] where this thread may wait for others, as in Node
 */
export async function start(options, gpu, local) {
  const { backend, device, signal, ...given } = checked(options);
  signal?.throwIfAborted();
  const worker = device ? false : given.worker;
  const [connection, threads] = await connected({ ...given, worker, signal }, local);
  try {
    const facts = await connection.call('open', { backend, device, gpu }, { signal });
    return new Mesher(connection, { ...facts, threads });
  } catch (error) {
    connection.close();
    throw error;
  }
}

/**
 * Connects to a core that has loaded its wasm: that of many threads where this can be had, and else that of one.
 *
 * @param {Pick<MesherOptions, 'threads' | 'wasm' | 'worker' | 'signal'>} options
 * @param {LocalCore} [local]
 * @returns {Promise<[Connection, number]>} and how many threads it has
 */
async function connected({ threads, wasm, worker, signal }, local) {
  const canShare = local || (worker === undefined && globalThis.crossOriginIsolated && typeof Worker !== 'undefined');
  const hasThreads = wasm === undefined && Boolean(canShare);
  if (threads !== undefined && threads > 1 && !hasThreads) {
    const hint = 'serve the page with the headers that isolate it, and leave out wasm, worker and device';
    throw new HexcastError('job-conflict', `${threads} threads are asked for, and this page can have one`, { hint });
  }
  const n = threads ?? Math.min(globalThis.navigator?.hardwareConcurrency ?? 1, MOST_THREADS);
  if (hasThreads && n > 1) {
    try {
      return await loaded(true, n, { worker, signal }, local);
    } catch {
      // such as a bundler that leaves out a file, or memory that cannot be shared: one thread does the same
      signal?.throwIfAborted();
    }
  }
  return loaded(false, 1, { wasm, worker, signal }, local);
}

/**
 * Connects to a core, in a worker or on this thread, and loads its wasm.
 *
 * @param {boolean} hasThreads
 * @param {number} threads
 * @param {Pick<MesherOptions, 'wasm' | 'worker' | 'signal'>} options
 * @param {LocalCore} [local]
 * @returns {Promise<[Connection, number]>}
 */
async function loaded(hasThreads, threads, { wasm, worker, signal }, local) {
  const isLocal = local || worker === false || typeof Worker === 'undefined';
  const { core, source, startThread } = isLocal
    ? await (local ?? ownCore)(hasThreads)
    : { core: null, source: ownWasm(hasThreads), startThread: undefined };
  const connection = new Connection(core ? localPort(core) : workerPort(startWorker(worker || undefined)));
  try {
    const from = wasm ?? source;
    // a URL cannot be sent to a worker
    const args = { wasm: from instanceof URL ? from.href : from, hasThreads };
    const shared = /** @type {import('./client/threads.js').Shared | null} */ (await connection.call('load', args, { signal }));
    return [connection, shared ? await startThreads(connection, shared, threads, startThread) : 1];
  } catch (error) {
    connection.close();
    throw error;
  }
}

/** A core on this thread, which may not wait for others in a page. @type {LocalCore} */
async function ownCore() {
  const [{ Core }, glue] = await Promise.all([import('./core/core.js'), import('./hexcast_wasm.js')]);
  return { core: new Core(glue), source: ownWasm(false) };
}

/** The wasm of this package, of one thread or of many; written so that bundlers find it. @param {boolean} hasThreads */
function ownWasm(hasThreads) {
  const folder = packageFolder(import.meta.url);
  if (hasThreads) {
    return folder ? new URL('hexcast_threads_bg.wasm', folder) : new URL('./hexcast_threads_bg.wasm', import.meta.url);
  }
  return folder ? new URL('hexcast_bg.wasm', folder) : new URL('./hexcast_bg.wasm', import.meta.url);
}

/** @param {unknown} worker */
function checkWorker(worker) {
  const isWorker = worker === undefined || worker === false || ['string', 'function'].includes(typeof worker);
  if (!isWorker && !['URL', 'Worker'].includes(kindOf(worker)))
    throw wrongValue('worker', worker, 'a URL, a Worker, a function that makes one, or false');
}

/** @param {unknown} wasm */
function checkWasm(wasm) {
  if (typeof wasm === 'string' || ['URL', 'WebAssembly.Module'].includes(kindOf(wasm)) || fileOf('wasm', wasm)) return;
  throw wrongValue('wasm', wasm, 'a URL, bytes or a WebAssembly.Module');
}

/** @param {any} device @param {MesherOptions['backend']} backend @param {MesherOptions['worker']} worker */
function checkDevice(device, backend, worker) {
  gpuDevice('device', device);
  const hint = 'leave out one of them';
  if (backend === 'cpu') throw new HexcastError('job-conflict', 'a device is given, and the backend "cpu"', { hint });
  if (worker !== undefined && worker !== false) {
    const message = 'a device is given, and a worker: devices cannot leave their thread';
    throw new HexcastError('job-conflict', message, { hint });
  }
}

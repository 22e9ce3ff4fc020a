/** Starts a mesher: checks its options, connects to a core and opens a backend there. */
import { MESHER, gpuDevice, kindOf, oneOf, optionsOf, wrongValue } from './client/check.js';
import { Connection, localPort, workerPort } from './client/connection.js';
import { Mesher } from './client/mesher.js';
import { fileOf } from './client/source.js';
import { packageFolder } from './platform/own_files.js';
import { HexcastError } from './protocol/error.js';
import { startWorker } from './start_worker.js';

/** @typedef {import('./hexcast.js').MesherOptions} MesherOptions */

/**
 * Checks the options of `createMesher`, before anything is loaded.
 *
 * @param {MesherOptions | undefined} options
 */
export function checked(options) {
  const given = optionsOf(options, MESHER);
  const { backend = 'auto', wasm, worker, device } = given;
  oneOf('backend', backend, ['auto', 'gpu', 'cpu']);
  checkWorker(worker);
  if (wasm !== undefined) checkWasm(wasm);
  if (device !== undefined) checkDevice(device, backend, worker);
  return { ...given, backend, device: /** @type {GPUDevice | undefined} */ (device) };
}

/**
 * Starts a mesher; `gpu` takes the place of `navigator.gpu` on this thread.
 *
 * @param {MesherOptions | undefined} options
 * @param {GPU | null} [gpu]
 */
export async function start(options, gpu) {
  const { backend, wasm, worker, device, signal } = checked(options);
  signal?.throwIfAborted();
  const connection = await connect(device ? false : worker);
  try {
    const source = wasm ?? ownWasm();
    // a URL cannot be sent to a worker
    const from = source instanceof URL ? source.href : source;
    return new Mesher(connection, await connection.call('open', { backend, wasm: from, device, gpu }, { signal }));
  } catch (error) {
    connection.close();
    throw error;
  }
}

/**
 * Connects to a new worker, or to a core on this thread where `worker` is false.
 *
 * @param {MesherOptions['worker']} [worker]
 */
async function connect(worker) {
  if (worker === false || typeof Worker === 'undefined') {
    const { Core } = await import('./core/core.js');
    return new Connection(localPort(new Core()));
  }
  return new Connection(workerPort(startWorker(worker)));
}

/** The wasm of this package; written so that bundlers find it. */
function ownWasm() {
  const folder = packageFolder(import.meta.url);
  if (folder) return new URL('hexcast_bg.wasm', folder);
  return new URL('./hexcast_bg.wasm', import.meta.url);
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

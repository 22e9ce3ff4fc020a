/** Calls to the core: in a worker, or on this thread. `start.js` starts either. */
import { answer } from '../core/answer.js';
import { HexcastError, errorOf } from '../protocol/error.js';
import { NOT_FOUND } from '../platform/own_files.js';

/**
 * @typedef {import('../core/core.js').Core} Core
 * @typedef {import('../core/core.js').Operation} Operation
 * @typedef {import('../hexcast.js').Progress} Progress
 */

/**
 * @template {Operation} K
 * @typedef {Parameters<Core[K]>[0]} Arguments
 */

/**
 * What arrives: arrays have buffers of their own.
 *
 * @template T
 * @typedef {T extends Uint8Array ? Uint8Array<ArrayBuffer>
 *   : T extends Uint32Array ? Uint32Array<ArrayBuffer>
 *   : T extends Float32Array ? Float32Array<ArrayBuffer>
 *   : T extends object ? { [K in keyof T]: Arrived<T[K]> } : T} Arrived
 */

/**
 * @template {Operation} K
 * @typedef {Arrived<Awaited<ReturnType<Core[K]>>>} Result
 */

/** @typedef {{ id: number, operation: Operation, args: object } | { cancel: number }} Request what goes to the core */

/**
 * What comes from the core.
 *
 * @typedef {object} Answer
 * @property {number} id of the call
 * @property {any} [result] that of its operation
 * @property {import('../protocol/error.js').Failure} [failure]
 * @property {Progress} [progress]
 */

/**
 * A way to a core and back.
 *
 * @typedef {object} Port
 * @property {(request: Request) => void} send
 * @property {() => void} close
 * @property {(answer: Answer) => void} onanswer
 * @property {(message: string) => void} onfailure
 */

/**
 * @typedef {object} Call
 * @property {Operation} operation
 * @property {(result: any) => void} resolve
 * @property {(error: unknown) => void} reject
 * @property {((progress: Progress) => void) | undefined} onProgress
 */

export class Connection {
  /** @type {Port | null} */
  #port;
  /** @type {Map<number, Call>} */
  #calls = new Map();
  /** Operations of calls that were aborted and are not answered yet, by id. @type {Map<number, Operation>} */
  #abandoned = new Map();
  #next = 1;
  #hasAnswered = false;
  /** Threads of the core. @type {Worker[]} */
  #threads = [];

  /** @param {Port} port */
  constructor(port) {
    this.#port = port;
    port.onanswer = ({ id, result, failure, progress }) => {
      this.#hasAnswered = true;
      const call = this.#calls.get(id);
      if (!call) return progress ? undefined : this.#forget(id, result);
      if (progress) return this.#report(id, call, progress);
      this.#calls.delete(id);
      failure ? call.reject(errorOf(failure)) : call.resolve(result);
    };
    port.onfailure = (message) => this.#rejectAll(message);
  }

  /** Calls the caller's function; where it throws, the call is over. @param {number} id @param {Call} call @param {Progress} progress */
  #report(id, call, progress) {
    try {
      report(call.onProgress, progress);
    } catch (error) {
      this.#abandon(id, error);
    }
  }

  /** Ends a call before its answer. @param {number} id @param {unknown} reason */
  #abandon(id, reason) {
    const call = this.#calls.get(id);
    if (!call) return;
    this.#calls.delete(id);
    this.#abandoned.set(id, call.operation);
    this.#port?.send({ cancel: id });
    call.reject(reason);
  }

  /**
   * Calls an operation. An abort rejects with the signal's reason at once; the core stops when it next handles its messages.
   *
   * @template {Operation} K
   * @param {K} operation
   * @param {Arguments<K>} args
   * @param {import('../hexcast.js').CallOptions} [options]
   * @returns {Promise<Result<K>>}
   */
  async call(operation, args, { signal, onProgress } = {}) {
    signal?.throwIfAborted();
    if (!this.#port) throw new HexcastError('disposed', 'the mesher was disposed of', { hint: 'create another' });
    const id = this.#next++;
    const port = this.#port;
    const stop = () => this.#abandon(id, signal?.reason);
    try {
      /** @type {Promise<any>} */
      const result = new Promise((resolve, reject) => {
        this.#calls.set(id, { operation, resolve, reject, onProgress });
        signal?.addEventListener('abort', stop, { once: true });
        port.send({ id, operation, args });
      });
      return await result;
    } finally {
      signal?.removeEventListener('abort', stop);
    }
  }

  /**
   * Frees the result of a call that was aborted.
   *
   * @param {number} id
   * @param {any} result
   */
  #forget(id, result) {
    const operation = this.#abandoned.get(id);
    this.#abandoned.delete(id);
    if (operation === 'encode') this.send('release', { encoder: result });
    else if (result?.surface || result?.mesh)
      // what made a scene has a mesh
      this.send('release', { surface: result.surface, mesh: result.mesh, scene: result.scene });
  }

  /**
   * Calls an operation without waiting for its result.
   *
   * @template {Operation} K
   * @param {K} operation
   * @param {Arguments<K>} args
   */
  send(operation, args) {
    this.#port?.send({ id: this.#next++, operation, args });
  }

  /** A thread of the core, which ends with this connection. @param {Worker} worker */
  attach(worker) {
    this.#threads.push(worker);
  }

  /** Ends a core that waits for a thread which failed. @param {string} message */
  fail(message) {
    this.#rejectAll(message);
    this.close();
  }

  close() {
    for (const thread of this.#threads.splice(0)) thread.terminate();
    this.#port?.close();
    this.#port = null;
    this.#fail(new HexcastError('cancelled', 'the mesher was disposed of'));
  }

  /** @param {string} message */
  #rejectAll(message) {
    const hint = this.#hasAnswered ? 'make another mesher, and mesh in smaller pieces if it fails again' : NOT_FOUND;
    this.#fail(new HexcastError('device-failed', `the worker failed: ${message}`, { hint }));
  }

  /** @param {Error} error */
  #fail(error) {
    for (const call of this.#calls.values()) call.reject(error);
    this.#calls.clear();
    this.#abandoned.clear();
  }
}

/**
 * Calls the caller's function.
 *
 * @param {((progress: Progress) => void) | undefined} onProgress
 * @param {Progress} progress
 */
export function report(onProgress, progress) {
  try {
    onProgress?.(progress);
  } catch (cause) {
    const what = cause instanceof Error ? cause.message : String(cause);
    throw new HexcastError('callback', `onProgress threw: ${what}`, { hint: 'catch its errors in there', cause });
  }
}

/**
 * A way to a worker.
 *
 * @param {Worker} worker
 * @returns {Port}
 */
export function workerPort(worker) {
  /** @type {Port} */
  const port = { send: (request) => worker.postMessage(request), close: () => worker.terminate(), onanswer() {}, onfailure() {} };
  worker.onmessage = ({ data }) => port.onanswer(data);
  worker.onerror = (event) => port.onfailure(event.message ?? 'its script could not be loaded');
  return port;
}

/**
 * A core on this thread that answers like a worker.
 *
 * @param {Core} core
 */
export function localPort(core) {
  /** @type {Port} */
  const port = {
    async send(request) {
      if ('cancel' in request) return core.cancel(request.cancel);
      port.onanswer(await answer(core, request, (progress) => port.onanswer(progress)));
    },
    close: () => core.dispose(),
    onanswer() {},
    onfailure() {},
  };
  return port;
}

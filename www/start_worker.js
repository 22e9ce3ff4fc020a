/** Starts the worker where a page allows it: from its own script, through a policy of Trusted Types, or from a Blob. */
import { HexcastError } from './protocol/error.js';
import { packageFolder } from './platform/own_files.js';
import { replaced } from './platform/replaced_property.js';

/** @typedef {{ createScriptURL(url: string): string }} Policy */

/**
 * Starts a worker, or takes the caller's.
 *
 * @param {Exclude<import('./hexcast.js').MesherOptions['worker'], false>} [worker]
 * @returns {Worker}
 */
export function startWorker(worker) {
  try {
    if (worker instanceof Worker) return worker;
    if (typeof worker === 'function') return /** @type {Worker} */ (worker());
    if (worker === undefined) return started(ownWorker);
    const script = new URL(/** @type {string | URL} */ (worker), globalThis.location?.href);
    return started(() => new Worker(script, { type: 'module' }));
  } catch (cause) {
    const what = cause instanceof Error ? cause.message : String(cause);
    const hint = 'give the option worker the URL of hexcast/worker, or false';
    throw new HexcastError('device-failed', `the worker cannot be started: ${what}`, { hint, cause });
  }
}

/** The worker of this package; written so that bundlers find it. */
function ownWorker() {
  const folder = packageFolder(import.meta.url);
  if (folder) return new Worker(new URL('worker.js', folder), { type: 'module' });
  return new Worker(new URL('./worker.js', import.meta.url), { type: 'module' });
}

/**
 * Starts a worker; one that this page does not let start so, otherwise.
 *
 * @param {() => Worker} start calls `new Worker` once
 */
export function started(start) {
  const [script, options] = argumentsOf(start);
  const here = globalThis.location?.origin;
  // some browsers throw a SecurityError here, others tell of it later
  if (/^https?:/.test(script) && new URL(script).origin !== here) return blobWorker(script, options);
  try {
    return start();
  } catch (error) {
    if (error instanceof TypeError && policy()) return new Worker(trusted(script), options);
    throw error;
  }
}

/**
 * What `new Worker` is called with. A bundler puts a URL of its own there, which nothing else tells.
 *
 * @param {() => Worker} start
 * @returns {[string, WorkerOptions | undefined]}
 */
function argumentsOf(start) {
  /** @type {[string, WorkerOptions | undefined]} */
  const found = ['', undefined];
  const note = class {
    /** @param {string | URL} script @param {WorkerOptions} [options] */
    constructor(script, options) {
      [found[0], found[1]] = [new URL(script, globalThis.location?.href).href, options];
    }
  };
  replaced(globalThis, 'Worker', note, start);
  return found;
}

/** A worker of another origin, from a Blob that imports it. @param {string} script @param {WorkerOptions} [options] */
function blobWorker(script, options) {
  const blob = new Blob([`import ${JSON.stringify(script)};`], { type: 'text/javascript' });
  const url = URL.createObjectURL(blob);
  const worker = new Worker(trusted(url), { ...options, type: 'module' });
  worker.addEventListener('message', () => URL.revokeObjectURL(url), { once: true });
  return worker;
}

/** @type {Policy | null | undefined} */
let made;

/** The policy `hexcast`; null where there are no Trusted Types, or the page does not allow it. */
function policy() {
  const { trustedTypes } = /** @type {{ trustedTypes?: { createPolicy(name: string, rules: Policy): Policy } }} */ (globalThis);
  try {
    // the only URLs are those of this package, and what the caller gives as the option `worker`
    made ??= trustedTypes?.createPolicy('hexcast', { createScriptURL: (url) => url }) ?? null;
  } catch {
    made = null;
  }
  return made;
}

/** @param {string} url */
function trusted(url) {
  return policy()?.createScriptURL(url) ?? url;
}

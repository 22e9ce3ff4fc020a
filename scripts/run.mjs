// Runs commands and counts steps: a line with a time each, the slowest again at the end; the first failure prints its output and ends
// the run.

import { spawn, spawnSync } from 'node:child_process';
import { accessSync, constants } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { fileURLToPath } from 'node:url';

/** Root of the repository. */
export const ROOT = path.dirname(path.dirname(fileURLToPath(import.meta.url)));

// a layer of Mesa's Vulkan driver complains in every process that is started without one
process.env.XDG_RUNTIME_DIR ??= tmpdir();

/** Process groups of the commands that are running, ended with us. */
/** @type {Set<number>} */
const groups = new Set();

/** A command that failed, with all that it printed. */
export class CommandFailed extends Error {
  /** @param {string} command @param {string} reason @param {string} output all that it printed */
  constructor(command, reason, output) {
    super(`${command}: ${reason}`);
    this.output = output;
  }
}

/**
 * Runs a command in the repository and resolves to what it printed (stdout and stderr as they came).
 *
 * @param {string} command path or name
 * @param {string[]} args
 * @param {{env?: Record<string, string>, cwd?: string, silence?: number}} [options] `env` is added to ours; a command that prints
 *   nothing for this many minutes (20) is ended with all it has started. How long it takes in all depends on the machine, and on what
 *   else runs there
 * @returns {Promise<string>} rejects with CommandFailed
 */
export function run(command, args, { env = {}, cwd = ROOT, silence = 20 } = {}) {
  const line = [command, ...args].join(' ');
  return new Promise((resolve, reject) => {
    // a group of its own, so that a browser that hangs is ended with the test that started it
    const child = spawn(command, args, {
      cwd,
      env: { ...process.env, ...env },
      detached: true,
      stdio: ['ignore', 'pipe', 'pipe'],
    });
    const { pid } = child;
    /** @type {Buffer[]} */
    const chunks = [];
    /** @type {string | null} */
    let reason = null;
    const end = () => {
      reason = `printed nothing for ${silence} minutes`;
      if (pid) endGroup(pid);
    };
    let timer = setTimeout(end, silence * 60_000);
    const keep = (/** @type {Buffer} */ chunk) => {
      clearTimeout(timer);
      timer = setTimeout(end, silence * 60_000);
      chunks.push(chunk);
      if (process.env.HEXCAST_VERBOSE) process.stdout.write(chunk);
    };
    child.stdout.on('data', keep);
    child.stderr.on('data', keep);
    const settle = (/** @type {string | null} */ failure) => {
      clearTimeout(timer);
      if (pid) groups.delete(pid);
      const output = Buffer.concat(chunks).toString();
      if (failure) reject(new CommandFailed(line, failure, output));
      else resolve(output);
    };
    if (pid) groups.add(pid);
    child.on('error', (error) => settle(error.message));
    child.on('close', (code, signal) => settle(reason ?? (code === 0 ? null : `ended with ${signal ?? `code ${code}`}`)));
  });
}

/** @param {number} pid */
function endGroup(pid) {
  try {
    process.kill(-pid, 'SIGKILL');
  } catch {
    // it ended by itself
  }
}

process.on('exit', () => groups.forEach(endGroup));
for (const signal of ['SIGINT', 'SIGTERM']) process.on(signal, () => process.exit(130));

/** First line that a short command prints, or null if it fails or does not exist. @param {string} command @param {string[]} args */
export function ask(command, args) {
  const result = spawnSync(command, args, { cwd: ROOT, encoding: 'utf8' });
  return result.status === 0 ? result.stdout.split('\n')[0].trim() : null;
}

/** Path of the first of these commands that PATH has, or null. @param {...string} names */
export function which(...names) {
  const folders = (process.env.PATH ?? '').split(path.delimiter);
  return names.flatMap((name) => folders.map((folder) => path.join(folder, name))).find(isExecutable) ?? null;
}

/** Whether a path is a program. @param {string} file */
export function isExecutable(file) {
  try {
    accessSync(file, constants.X_OK);
    return true;
  } catch {
    return false;
  }
}

/** How many of the slowest steps are listed at the end. */
const N_SLOWEST = 10;

/** Steps, counted; several may run at the same time. */
export class Steps {
  /** Names and milliseconds of those that passed. @type {[string, number][]} */
  #passed = [];
  #start = Date.now();

  /**
   * Runs one step; a failure prints its output and ends the process with code 1.
   *
   * @param {string} name
   * @param {() => Promise<string | null | void>} action resolves to a remark for the step's line, such as a number of tests
   */
  async step(name, action) {
    const start = Date.now();
    console.log(`${name} ...`);
    try {
      const remark = await action();
      this.#passed.push([name, Date.now() - start]);
      console.log(`${name}: ${seconds(start)}${remark ? `, ${remark}` : ''}`);
    } catch (error) {
      console.log(`${name}: FAILED after ${seconds(start)}\n`);
      if (error instanceof Error && 'output' in error) console.log(error.output);
      console.log(error instanceof CommandFailed ? error.message : error);
      this.finish(1);
    }
  }

  /** Runs a command as a step. @param {string} name @param {string} command @param {string[]} args @param {Parameters<typeof run>[2]} [options] */
  command(name, command, args, options) {
    return this.step(name, async () => void (await run(command, args, options)));
  }

  /** Prints the slowest steps, and the counts as the last line, and ends the process. */
  finish(n_failed = 0) {
    const slowest = this.#passed.toSorted(([, one], [, other]) => other - one).slice(0, N_SLOWEST);
    console.log('\nThe slowest steps, of which two may run at the same time:');
    for (const [name, milliseconds] of slowest) console.log(`${(milliseconds / 1000).toFixed(1).padStart(8)} s  ${name}`);
    console.log(`\n${seconds(this.#start)} in all`);
    console.log(`${this.#passed.length} passed, ${n_failed} failed`);
    process.exit(n_failed);
  }
}

/** @param {number} start */
function seconds(start) {
  return `${((Date.now() - start) / 1000).toFixed(1)} s`;
}

/** A job whose geometries move, and its mesh, of which each update makes what changed. */
import { CALL, optionsOf } from './check.js';
import { HexcastError } from '../protocol/error.js';

/**
 * @typedef {import('../hexcast.js').CallOptions} CallOptions
 * @typedef {import('./connection.js').Result<'openColumns'>} Made what the core tells of a mesh
 * @typedef {import('./mesh.js').Mesh} Mesh
 */

export class Scene {
  #connection;
  /** @type {number | undefined} */
  #id;
  #withSurfaces;
  #meshOf;
  /** Whether the core's mesh is this one: an update that was aborted may have been made. */
  #isKnown = true;

  /**
   * @param {import('./connection.js').Connection} connection
   * @param {import('./connection.js').Result<'scene'>} made
   * @param {import('./mesh.js').WithSurfaces<import('../hexcast.js').Update>} withSurfaces
   * @param {(made: Made) => Mesh} meshOf
   */
  constructor(connection, { scene, ...made }, withSurfaces, meshOf) {
    this.#connection = connection;
    this.#id = scene;
    this.#withSurfaces = withSurfaces;
    this.#meshOf = meshOf;
    this.mesh = meshOf(made);
  }

  /** @param {import('../hexcast.js').Job} job @param {CallOptions} [options] */
  async update(job, options) {
    const call = optionsOf(options, CALL);
    const scene = this.#id;
    if (scene === undefined) throw new HexcastError('disposed', 'the scene was disposed of', { hint: 'make another' });
    return this.#withSurfaces(job, call, async (prepared) => {
      const wasKnown = this.#isKnown;
      this.#isKnown = false;
      const { update, changed, ...made } = await this.#connection.call('update', { scene, ...prepared }, call);
      this.#isKnown = true;
      const before = this.mesh;
      this.mesh = this.#meshOf(made);
      before.dispose();
      return { ...update, changed: wasKnown ? changed : null };
    });
  }

  dispose() {
    if (this.#id === undefined) return;
    this.#connection.send('release', { scene: this.#id });
    this.mesh.dispose();
    this.#id = undefined;
  }

  [Symbol.dispose]() {
    this.dispose();
  }
}

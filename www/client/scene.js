/** A job whose geometries move, and its mesh, of which each update makes what changed. */
import { CALL, optionsOf } from './check.js';
import { HexcastError } from '../protocol/error.js';

/**
 * @typedef {import('../hexcast.js').CallOptions} CallOptions
 * @typedef {import('./connection.js').Result<'openColumns'>} Made what the core tells of a mesh
 * @typedef {import('./mesh.js').Mesh} Mesh
 */

const disposed = () => new HexcastError('disposed', 'the scene was disposed of', { hint: 'make another' });

export class Scene {
  #connection;
  /** @type {number | undefined} */
  #id;
  #withSurfaces;
  #meshOf;
  /** How many updates the core had made for this mesh; not a number where one failed since: aborted here, it may be made there. */
  #n_made = 0;

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
    if (scene === undefined) throw disposed();
    return this.#withSurfaces(job, call, async (prepared) => {
      const { update, changed, n_made, ...made } = await this.#connection
        .call('update', { scene, ...prepared }, call)
        .catch((error) => {
          this.#n_made = Number.NaN;
          throw error;
        });
      const before = this.mesh;
      const follows = n_made === this.#n_made + 1;
      this.mesh = this.#meshOf(made);
      this.#n_made = n_made;
      before.dispose();
      // it was disposed of meanwhile
      if (this.#id === undefined) {
        this.mesh.dispose();
        throw disposed();
      }
      return { ...update, changed: follows ? changed : null };
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

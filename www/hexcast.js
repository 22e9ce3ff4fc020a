/** The package's entry: see `hexcast.d.ts` for everything public. */
import { start } from './start.js';

export { formats } from './client/formats.js';
export { HexcastError } from './protocol/error.js';
export const version = '0.1.0';

/** @type {typeof import('./hexcast.js').createMesher} */
export async function createMesher(options) {
  return start(options);
}

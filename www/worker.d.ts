/**
 * The worker script, for {@link MesherOptions.worker} where a bundler is to be told where it is. It exports nothing: importing
 * it makes the thread it runs on answer a mesher.
 */
import type { MesherOptions } from './hexcast.js';

export {};

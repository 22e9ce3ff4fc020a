/**
 * The worker script, for the option `worker` of `createMesher` where a bundler cannot find it by itself. It exports nothing; a thread
 * that imports it answers a mesher.
 */
export {};

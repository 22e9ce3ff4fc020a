/**
 * The worker script, for the option `worker` of `createMesher`, where a bundler is to be told where it is. It exports nothing: importing
 * it makes the thread it runs on answer a mesher.
 */
export {};

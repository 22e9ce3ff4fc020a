/** Where the worker and the wasm of this package lie: beside its scripts, but where a development server runs a copy of these. */

/** What to do where one of them is not found. */
export const NOT_FOUND =
  "for Vite add optimizeDeps: { exclude: ['hexcast'] } to its configuration; for other bundlers the README of the package has recipes; createMesher({ worker, wasm }) takes the addresses of both files";

/** The folder of the package in which neither lies: Vite 5 to 7 put a script of all modules there, and only that. */
const PREPARED = /\/node_modules\/\.vite[^/]*\/deps\/[^/]*$/;

/**
 * The package's folder where `script` is a copy of its modules without the files beside them, else undefined. Whoever addresses a file
 * writes the address beside the script literally, too, since bundlers look for that.
 *
 * @param {string} script `import.meta.url`
 */
export function packageFolder(script) {
  const { pathname } = new URL(script);
  return PREPARED.test(pathname) ? new URL('../../hexcast/dist/', script) : undefined;
}

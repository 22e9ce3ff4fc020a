// The page: from www/ into dist/, beside the package, which scripts/build.mjs puts there first and which the page imports by
// its name, as any other page would.

import { readFileSync, readdirSync } from 'node:fs';
import path from 'node:path';
import { defineConfig } from 'vite';

const WWW = path.join(import.meta.dirname, 'www');
/** What isolates a page from other origins, so that its workers may share memory. */
export const ISOLATED = { 'Cross-Origin-Opener-Policy': 'same-origin', 'Cross-Origin-Embedder-Policy': 'require-corp' };

/**
 * Writes the service worker with the names of all files of the page.
 *
 * @returns {import('vite').Plugin}
 */
function offline() {
  return {
    name: 'hexcast:offline',
    generateBundle: {
      // after index.html is there
      order: 'post',
      handler(_options, bundle) {
        // where there is no network, one thread does; Open CASCADE is loaded where a file needs it
        const kept = Object.keys(bundle).filter((name) => !/threads.*\.wasm$|\/occt\//.test(name));
        const files = JSON.stringify(['./', ...kept.sort()]);
        const worker = readFileSync(path.join(WWW, 'page/offline.js'), 'utf8');
        const source = worker.replace("const FILES = ['./'];", `const FILES = ${files};`);
        if (source === worker) throw new Error('the service worker has no list of files to replace');
        this.emitFile({ type: 'asset', fileName: 'offline.js', source });
      },
    },
  };
}

/**
 * Puts the licences of Open CASCADE beside it.
 *
 * @returns {import('vite').Plugin}
 */
function licences() {
  return {
    name: 'hexcast:licences',
    generateBundle() {
      const folder = path.join(import.meta.dirname, 'dist/cad/occt');
      for (const name of readdirSync(folder).filter((name) => name.endsWith('.txt')))
        this.emitFile({ type: 'asset', fileName: `assets/occt/${name}`, source: readFileSync(path.join(folder, name)) });
    },
  };
}

export default defineConfig({
  root: WWW,
  // any path of any host
  base: './',
  publicDir: false,
  // a file that is missing is an error, and not index.html
  appType: 'mpa',
  plugins: [licences(), offline()],
  build: {
    outDir: path.join(import.meta.dirname, 'dist'),
    // the package is there
    emptyOutDir: false,
    modulePreload: { polyfill: false },
    license: { fileName: 'licenses.md' },
    rolldownOptions: {
      output: {
        assetFileNames: ({ names: [name] }) => `assets/${/^occt-/.test(name) ? 'occt/' : ''}[name]-[hash][extname]`,
      },
    },
  },
  preview: { host: '127.0.0.1', port: 8080, strictPort: true, headers: ISOLATED },
});

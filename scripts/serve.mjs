// Serves a folder on this machine with Vite's preview server, for the tests; any other host does as well.

import { preview } from 'vite';

import { DIST } from './build.mjs';

/**
 * Serves a folder on this machine only.
 *
 * @param {object} [options]
 * @param {string} [options.root] the folder; dist
 * @param {string} [options.base] the path that it is under, with slashes at both ends; '/'
 * @param {boolean} [options.cors] lets pages of other origins read the files; false
 * @param {Record<string, string>} [options.headers] of every answer; none
 * @returns {Promise<{url: string, close: () => Promise<void>}>} `url` ends with `base`
 */
export async function serve({ root = DIST, base = '/', cors = false, headers = {} } = {}) {
  const server = await preview({
    configFile: false,
    root,
    base,
    // a missing file is an error, not index.html
    appType: 'mpa',
    logLevel: 'error',
    build: { outDir: root },
    preview: { host: '127.0.0.1', port: 0, cors, headers },
  });
  const [url] = server.resolvedUrls?.local ?? [];
  if (!url) throw new Error('the server has no address');
  return { url, close: () => server.close() };
}

// A static server for the page: npm start, and the tests. Any other host does as well.

import { createReadStream, statSync } from 'node:fs';
import { createServer } from 'node:http';
import path from 'node:path';
import { parseArgs } from 'node:util';
import { fileURLToPath } from 'node:url';

import { DIST, build } from './build.mjs';
import { ROOT } from './run.mjs';

const TYPES = {
  '.css': 'text/css; charset=utf-8',
  '.html': 'text/html; charset=utf-8',
  '.ico': 'image/x-icon',
  '.js': 'text/javascript; charset=utf-8',
  '.json': 'application/json',
  '.mjs': 'text/javascript; charset=utf-8',
  '.png': 'image/png',
  '.stl': 'model/stl',
  '.svg': 'image/svg+xml',
  '.wasm': 'application/wasm',
  '.webmanifest': 'application/manifest+json',
  '.wgsl': 'text/plain; charset=utf-8',
};

/**
 * Serves folders on this machine only.
 *
 * @param {object} [options]
 * @param {string[]} [options.roots] folders, the first that has a file wins; dist
 * @param {string} [options.base] the path that the page lives under, with slashes at both ends; '/'
 * @param {number} [options.port] 0 lets the system choose; 0
 * @param {boolean} [options.cors] lets pages of other origins read the files; false
 * @returns {Promise<{url: string, close: () => Promise<void>}>} `url` ends with `base`
 */
export async function serve({ roots = [DIST], base = '/', port = 0, cors = false } = {}) {
  const extra = cors ? { 'Access-Control-Allow-Origin': '*' } : {};
  const server = createServer((request, response) => answer(roots, base, extra, request, response));
  await new Promise((resolve, reject) => server.once('error', reject).listen(port, '127.0.0.1', resolve));
  const close = () =>
    new Promise((resolve) => {
      server.close(resolve);
      server.closeAllConnections();
    });
  return { url: `http://127.0.0.1:${server.address().port}${base}`, close };
}

function answer(roots, base, extra, request, response) {
  const refuse = (status, text) => response.writeHead(status, { 'Content-Type': 'text/plain' }).end(`${text}\n`);
  if (request.method !== 'GET' && request.method !== 'HEAD') return refuse(405, 'GET only');
  const file = fileOf(roots, base, request.url);
  if (!file) return refuse(404, 'not found');
  const type = TYPES[path.extname(file.path)] ?? 'application/octet-stream';
  response.writeHead(200, { 'Content-Type': type, 'Content-Length': file.size, 'Cache-Control': 'no-cache', ...extra });
  if (request.method === 'HEAD') return response.end();
  // a file that vanishes meanwhile breaks the connection, which is what the browser should see
  return createReadStream(file.path)
    .on('error', (error) => response.destroy(error))
    .pipe(response);
}

/** The file that a request means, or null; never one outside the folders. */
function fileOf(roots, base, url) {
  let name;
  try {
    name = decodeURIComponent(url.split('?')[0]);
  } catch {
    return null;
  }
  if (!name.startsWith(base) || name.includes('\0')) return null;
  const relative = name.slice(base.length);
  for (const root of roots) {
    const file = path.join(root, relative.endsWith('/') || relative === '' ? `${relative}index.html` : relative);
    const facts = file.startsWith(root + path.sep) ? statSync(file, { throwIfNoEntry: false }) : undefined;
    if (facts?.isFile()) return { path: file, size: facts.size };
  }
  return null;
}

async function main() {
  const { values } = parseArgs({ options: { build: { type: 'boolean' }, port: { type: 'string', default: '8080' } } });
  if (values.build) {
    console.log('building ...');
    console.log(`dist/: ${await build()}`);
  }
  // www/ first: an edited page shows on reload
  const { url } = await serve({ roots: [path.join(ROOT, 'www'), DIST], port: Number(values.port) });
  console.log(`hexcast is at ${url} (end with Ctrl-C)`);
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  main().catch((error) => {
    console.error([error.output, error.message].filter(Boolean).join('\n'));
    process.exitCode = 1;
  });
}

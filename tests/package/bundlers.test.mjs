// The installed package in apps of bundlers, with the recipes of its README and nothing else: each is built, served and meshes.

import assert from 'node:assert/strict';
import { execFileSync, spawn } from 'node:child_process';
import { once } from 'node:events';
import { cpSync, mkdirSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { connect, createServer } from 'node:net';
import path from 'node:path';
import { after, before, test } from 'node:test';
import { setTimeout } from 'node:timers/promises';

import { serve } from '../../scripts/serve.mjs';
import { ISOLATED } from '../../vite.config.mjs';
import { openChromium } from '../e2e/browsers.mjs';
import { assertMeshes } from './pages.mjs';
import { SPOT, installedProject, nativeOutcome, writePage } from './project.mjs';
import { TOOLS, ensureTools, recipe, writeRecipe } from './tools.mjs';

const LONG = { timeout: 300_000 };
/** Installing the tools and building the native command take minutes where neither was done before. */
const FIRST = { timeout: 1_200_000 };

let project;
let native;
let browser;
before(async () => {
  await ensureTools();
  project = installedProject(TOOLS);
  writePage(project.folder, { models: path.join(project.folder, 'public') });
  native = nativeOutcome(project.folder);
  browser = await openChromium();
}, FIRST);
after(async () => {
  await browser?.close();
  project?.remove();
});

/** Runs a program of the tools in the project. */
function runTool(file, ...args) {
  const env = { ...process.env, NEXT_TELEMETRY_DISABLED: '1', PARCEL_WORKERS: '0' };
  const program = path.join(TOOLS, 'node_modules', file);
  execFileSync(process.execPath, [program, ...args], { cwd: project.folder, env, stdio: ['ignore', 'pipe', 'pipe'] });
}

/** A page that starts a mesher and keeps why that failed. */
const STARTING_PAGE = '<!doctype html><link rel="icon" href="data:,"><script type="module" src="start.js"></script>';
const STARTING = `
import { createMesher } from 'hexcast';
const told = ({ message, hint }) => ({ message, hint });
globalThis.outcome = await createMesher(OPTIONS).then(() => ({ message: 'started' }), told);
`;

/** Serves a folder of the project and meshes on its page: on one thread, and where it is isolated from other origins on two. */
async function assertFolderMeshes(folder, { base, headers } = {}) {
  const root = path.join(project.folder, folder);
  cpSync(SPOT, path.join(root, 'spot.stl'));
  for (const threads of [1, 2]) {
    const server = await serve({ root, base, headers: { ...headers, ...(threads > 1 && ISOLATED) } });
    try {
      await assertMeshes(browser, server.url, native, [], ['cpu'], threads);
    } finally {
      await server.close();
    }
  }
}

for (const name of ['vite5', 'vite6', 'vite7']) {
  test(`${name} builds an app that meshes below a path, and one that meshes while it is developed`, LONG, async () => {
    const { build, createServer } = await import(path.join(TOOLS, 'node_modules', name, 'dist/node/index.js'));
    // no configuration but what keeps the three apart, and the path that the app is built for
    const settings = {
      root: project.folder,
      configFile: false,
      logLevel: 'error',
      base: './',
      cacheDir: `node_modules/.${name}`,
    };
    await build({ ...settings, build: { outDir: name, target: 'es2022' } });
    await assertFolderMeshes(name, { base: '/some/path/' });
    const server = await createServer({ ...settings, server: { host: '127.0.0.1' } });
    try {
      await server.listen();
      await assertMeshes(browser, server.resolvedUrls.local[0], native, [], ['cpu']);
    } finally {
      await server.close();
    }
  });
}

test('where an app does not find the worker or the wasm, the error says what to add, and that helps', LONG, async () => {
  const { createServer } = await import(path.join(TOOLS, 'node_modules/vite6/dist/node/index.js'));
  // a workspace whose packages lie in the folder above: what Vite prepares lies elsewhere than the package
  const all = path.join(project.folder, 'workspace');
  const root = path.join(all, 'app');
  mkdirSync(path.join(root, 'node_modules'), { recursive: true });
  cpSync(path.join(project.folder, 'node_modules/hexcast'), path.join(all, 'node_modules/hexcast'), { recursive: true });
  writeFileSync(path.join(all, 'package.json'), '{"private": true, "workspaces": ["app"]}');
  writeFileSync(path.join(root, 'package.json'), '{"private": true, "type": "module"}');
  writeFileSync(path.join(root, 'index.html'), STARTING_PAGE);
  const outcomes = async (config) => {
    const server = await createServer({ root, logLevel: 'error', server: { host: '127.0.0.1' }, ...config });
    await server.listen();
    const found = [];
    for (const options of ['', '{ worker: false }']) {
      writeFileSync(path.join(root, 'start.js'), STARTING.replace('OPTIONS', options));
      const page = await browser.newPage();
      await page.goto(server.resolvedUrls.local[0]);
      found.push(await (await page.waitForFunction(() => globalThis.outcome)).jsonValue());
      await page.close();
    }
    await server.close();
    return found;
  };
  const [worker, wasm] = await outcomes({ configFile: false });
  assert.match(worker.message, /^the worker failed: /);
  assert.match(wasm.message, /^the wasm of hexcast cannot be loaded from http/);
  for (const { hint } of [worker, wasm]) assert.match(hint, /optimizeDeps: \{ exclude: \['hexcast'\] \}.*recipes/);
  writeRecipe(root, 'vite.config.js');
  assert.deepEqual(await outcomes({}), [{ message: 'started' }, { message: 'started' }]);
});

test('an app meshes under the content security policies of the README, Trusted Types among them', LONG, async () => {
  // the page has an icon without bytes
  const csp = `${recipe('csp').trim()}; img-src data:`;
  await assertFolderMeshes('vite7', { headers: { 'content-security-policy': csp } });
  const server = await serve({
    root: path.join(project.folder, 'vite7'),
    headers: { 'content-security-policy': `${csp}; ${recipe('trusted-types').trim()}` },
  });
  const page = await browser.newPage();
  await page.goto(`${server.url}?backend=cpu`);
  const outcome = await (await page.waitForFunction(() => globalThis.outcome)).jsonValue();
  await page.close();
  await server.close();
  if (outcome.sha256 !== native.flags_sha256) throw new Error(JSON.stringify(outcome));
});

/** Bundlers that make a script: the page is put beside it. */
const SCRIPTS = {
  'webpack 5': ['webpack.config.js', 'webpack-cli/bin/cli.js'],
  Rollup: ['rollup.config.js', 'rollup/dist/bin/rollup', '-c', '--silent'],
  esbuild: ['esbuild.js', null],
};
for (const [name, [file, program, ...args]] of Object.entries(SCRIPTS)) {
  test(`${name} builds an app that meshes`, LONG, async () => {
    writeRecipe(project.folder, file);
    if (program) runTool(program, ...args);
    else execFileSync(process.execPath, [file], { cwd: project.folder });
    await assertScriptMeshes();
  });
}

/** Puts the page beside the script that was made, and meshes there, below a path. */
async function assertScriptMeshes() {
  const folder = path.join(project.folder, 'dist');
  cpSync(path.join(project.folder, 'index.html'), path.join(folder, 'index.html'));
  await assertFolderMeshes('dist', { base: '/some/path/' });
  rmSync(folder, { recursive: true });
}

test('webpack 5 makes an app for development that meshes', LONG, async () => {
  writeRecipe(project.folder, 'webpack.config.js');
  runTool('webpack-cli/bin/cli.js', '--mode', 'development');
  await assertScriptMeshes();
});

test('Parcel builds an app that meshes below a path', LONG, async () => {
  runTool('parcel/lib/bin.js', 'build', 'index.html', '--dist-dir', 'parcel', '--no-cache', '--public-url', './');
  await assertFolderMeshes('parcel', { base: '/some/path/' });
});

/** Starts a development server of a tool, meshes on its page, and ends it. */
async function assertServerMeshes(expected, file, ...args) {
  const env = { ...process.env, NEXT_TELEMETRY_DISABLED: '1', PARCEL_WORKERS: '0' };
  const program = path.join(TOOLS, 'node_modules', file);
  const port = await freePort();
  // a group of its own: these servers have processes of their own
  const options = { cwd: project.folder, env, detached: true, stdio: ['ignore', 'pipe', 'pipe'] };
  const server = spawn(process.execPath, [program, ...args, '--port', port], options);
  const said = [];
  for (const stream of [server.stdout, server.stderr]) stream.setEncoding('utf8').on('data', (text) => said.push(text));
  try {
    // not as soon as it says that it serves: Parcel says so before it listens
    while (!(await answers(port))) {
      const end = server.exitCode ?? server.signalCode;
      assert.equal(end, null, `ended with ${end}: ${said.join('')}`);
      await setTimeout(50);
    }
    await assertMeshes(browser, `http://127.0.0.1:${port}/`, expected, [], ['cpu']);
  } finally {
    if ((server.exitCode ?? server.signalCode) === null) process.kill(-server.pid);
  }
}

/** Whether something listens to a port. */
async function answers(port) {
  const socket = connect(Number(port), '127.0.0.1');
  try {
    await once(socket, 'connect');
    return true;
  } catch {
    return false;
  } finally {
    socket.destroy();
  }
}

/** A port that nothing listens to. */
async function freePort() {
  const server = createServer().listen(0, '127.0.0.1');
  await once(server, 'listening');
  const { port } = server.address();
  server.close();
  await once(server, 'close');
  return String(port);
}

test("Parcel's development server meshes", LONG, async () => {
  // it has no await outside of functions, which the lines of the documents use
  const main = readFileSync(path.join(project.folder, 'main.js'), 'utf8');
  const script = main.replace(/^import '\.\/.*\n/gm, '').replace(/^try \{/m, '(async () => {\ntry {');
  const folder = path.join(project.folder, 'parcel-dev');
  mkdirSync(folder);
  writeFileSync(path.join(project.folder, 'developed.js'), `${script}})();`);
  const page = readFileSync(path.join(project.folder, 'index.html'), 'utf8');
  writeFileSync(path.join(project.folder, 'developed.html'), page.replace('./main.js', './developed.js'));
  cpSync(SPOT, path.join(folder, 'spot.stl'));
  const args = ['--host', '127.0.0.1', '--no-cache', '--no-hmr', '--dist-dir', 'parcel-dev'];
  await assertServerMeshes({ ...native, cells: undefined }, 'parcel/lib/bin.js', 'serve', 'developed.html', ...args);
});

const LAYOUT =
  'export default ({ children }) => <html lang="en"><head><link rel="icon" href="data:," /></head><body>{children}</body></html>;';
const PAGE = `'use client';
import { useEffect } from 'react';
import { createMesher } from 'hexcast';
export default function Page() {
  useEffect(() => void (typeof createMesher === 'function' && import('../main.js')), []);
  return null;
}`;

test(
  'Next builds with Turbopack a page that meshes, and serves one in development; on the server it loads the entry of Node',
  LONG,
  async () => {
    mkdirSync(path.join(project.folder, 'app'));
    writeFileSync(path.join(project.folder, 'app/layout.js'), LAYOUT);
    writeFileSync(path.join(project.folder, 'app/page.js'), PAGE);
    writeRecipe(project.folder, 'next.config.js');
    runTool('next/dist/bin/next', 'build');
    await assertFolderMeshes('out');
    await assertServerMeshes(native, 'next/dist/bin/next', 'dev', '--hostname', '127.0.0.1');
    // below a path, by the option of Next for it
    writeFileSync(path.join(project.folder, 'next.config.js'), "export default { output: 'export', basePath: '/some/path' };");
    runTool('next/dist/bin/next', 'build');
    await assertFolderMeshes('out', { base: '/some/path/' });
  },
);

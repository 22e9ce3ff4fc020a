// The installed package in apps of bundlers, with the recipes of its README and nothing else: each is built, served and meshes.

import { execFileSync } from 'node:child_process';
import { cpSync, mkdirSync, writeFileSync } from 'node:fs';
import path from 'node:path';
import { after, before, test } from 'node:test';

import { serve } from '../../scripts/serve.mjs';
import { openChromium } from '../e2e/browsers.mjs';
import { assertMeshes } from './pages.mjs';
import { SPOT, installedProject, nativeReport, nativeVti, writePage } from './project.mjs';
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
  native = { ...nativeReport(), vti: nativeVti(project.folder) };
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

/** Serves a folder of the project and meshes on its page. */
async function assertFolderMeshes(folder, { base, headers } = {}) {
  const root = path.join(project.folder, folder);
  cpSync(SPOT, path.join(root, 'spot.stl'));
  const server = await serve({ root, base, headers });
  try {
    await assertMeshes(browser, server.url, native, [], ['cpu']);
  } finally {
    await server.close();
  }
}

for (const name of ['vite5', 'vite6', 'vite7']) {
  test(`${name} builds an app that meshes below a path, and one that meshes while it is developed`, LONG, async () => {
    writeRecipe(project.folder, 'vite.config.js');
    const { build, createServer } = await import(path.join(TOOLS, 'node_modules', name, 'dist/node/index.js'));
    const settings = { root: project.folder, logLevel: 'error', cacheDir: `node_modules/.${name}` };
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
    cpSync(path.join(project.folder, 'index.html'), path.join(project.folder, 'dist/index.html'));
    await assertFolderMeshes('dist');
    execFileSync('rm', ['-r', path.join(project.folder, 'dist')]);
  });
}

test('Parcel builds an app that meshes', LONG, async () => {
  runTool('parcel/lib/bin.js', 'build', 'index.html', '--dist-dir', 'parcel', '--no-cache', '--public-url', './');
  await assertFolderMeshes('parcel');
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

test('Next builds with Turbopack a page that meshes; on the server it loads the entry of Node', LONG, async () => {
  mkdirSync(path.join(project.folder, 'app'));
  writeFileSync(path.join(project.folder, 'app/layout.js'), LAYOUT);
  writeFileSync(path.join(project.folder, 'app/page.js'), PAGE);
  writeRecipe(project.folder, 'next.config.js');
  runTool('next/dist/bin/next', 'build');
  await assertFolderMeshes('out');
});

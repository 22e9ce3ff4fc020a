// The installed package in a Vite app without any configuration: the development server and what `vite build` makes.

import path from 'node:path';
import { after, before, test } from 'node:test';

import { build, createServer } from 'vite';

import { serve } from '../../scripts/serve.mjs';
import { BROWSERS, assertMeshes, withBrowser } from './pages.mjs';
import { installedProject, nativeOutcome, writePage } from './project.mjs';

const LONG = { timeout: 300_000 };

let project;
let native;
before(() => {
  project = installedProject();
  writePage(project.folder, { models: path.join(project.folder, 'public') });
  native = nativeOutcome(project.folder);
});
after(() => project.remove());

/** The app is where it is, and Vite says only what went wrong; nothing else is set. */
const settings = () => ({ root: project.folder, configFile: false, logLevel: 'warn' });

for (const [name, open] of Object.entries(BROWSERS)) {
  test(`what Vite builds meshes in ${name}`, LONG, async () => {
    await build(settings());
    const server = await serve({ root: path.join(project.folder, 'dist') });
    await withBrowser(open, server, (browser) => assertMeshes(browser, server.url, native));
  });

  test(`Vite's development server meshes in ${name}`, LONG, async () => {
    const server = await createServer({ ...settings(), server: { host: '127.0.0.1' } });
    await server.listen();
    const [url] = server.resolvedUrls.local;
    await withBrowser(open, server, (browser) => assertMeshes(browser, url, native));
  });
}

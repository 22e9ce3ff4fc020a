// The installed package on pages without a bundler: beside the page, and on another origin as from a CDN.

import { mkdirSync } from 'node:fs';
import path from 'node:path';
import { after, before, test } from 'node:test';

import { serve } from '../../scripts/serve.mjs';
import { BROWSERS, assertMeshes } from './pages.mjs';
import { installedProject, nativeReport, writePage } from './project.mjs';

const LONG = { timeout: 300_000 };

let project;
let native;
before(() => {
  project = installedProject();
  native = nativeReport();
});
after(() => project.remove());

for (const [name, open] of Object.entries(BROWSERS)) {
  test(`a plain page with an import map meshes in ${name}, below a path too`, LONG, async () => {
    writePage(project.folder, { imports: { hexcast: './node_modules/hexcast/dist/hexcast.js' } });
    await withBrowser(open, { roots: [project.folder], base: '/some/page/' }, ({ browser, url }) => assertMeshes(browser, url, native));
  });

  test(`a page meshes with the package of another origin in ${name}`, LONG, async () => {
    const cdn = await serve({ roots: [path.join(project.folder, 'node_modules')], base: '/npm/', cors: true });
    const site = path.join(project.folder, 'site');
    mkdirSync(site, { recursive: true });
    writePage(site, { imports: { hexcast: `${cdn.url}hexcast/dist/hexcast.js` } });
    try {
      const check = ({ browser, url }) => assertMeshes(browser, url, native, [new URL(cdn.url).origin]);
      await withBrowser(open, { roots: [site] }, check);
    } finally {
      await cdn.close();
    }
  });
}

/** Serves folders, opens a browser, runs a check and ends both. */
async function withBrowser(open, folders, check) {
  const server = await serve(folders);
  let browser;
  try {
    browser = await open();
    await check({ browser, url: server.url });
  } finally {
    await browser?.close();
    await server.close();
  }
}

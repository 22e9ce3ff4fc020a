// The installed package on pages without a bundler: beside the page, and on another origin as from a CDN.

import { mkdirSync } from 'node:fs';
import path from 'node:path';
import { after, before, test } from 'node:test';

import { serve } from '../../scripts/serve.mjs';
import { BROWSERS, assertMeshes, withBrowser } from './pages.mjs';
import { installedProject, nativeOutcome, writePage } from './project.mjs';

const LONG = { timeout: 300_000 };

let project;
let native;
before(() => {
  project = installedProject();
  native = nativeOutcome(project.folder);
});
after(() => project.remove());

for (const [name, open] of Object.entries(BROWSERS)) {
  test(`a plain page with an import map meshes in ${name}, below a path too`, LONG, async () => {
    writePage(project.folder, { imports: { hexcast: './node_modules/hexcast/dist/hexcast.js' } });
    const server = await serve({ root: project.folder, base: '/some/page/' });
    await withBrowser(open, server, (browser) => assertMeshes(browser, server.url, native));
  });

  test(`a page meshes with the package of another origin in ${name}`, LONG, async () => {
    const cdn = await serve({ root: path.join(project.folder, 'node_modules'), base: '/npm/', cors: true });
    const site = path.join(project.folder, 'site');
    mkdirSync(site, { recursive: true });
    writePage(site, { imports: { hexcast: `${cdn.url}hexcast/dist/hexcast.js` } });
    try {
      const server = await serve({ root: site });
      await withBrowser(open, server, (browser) => assertMeshes(browser, server.url, native, [new URL(cdn.url).origin]));
    } finally {
      await cdn.close();
    }
  });
}

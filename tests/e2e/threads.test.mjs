// Pages that are isolated from other origins: the mesher has threads there, in both browsers, and makes the same bytes.

import assert from 'node:assert/strict';
import { cpSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';

import { DIST } from '../../scripts/build.mjs';
import { serve } from '../../scripts/serve.mjs';
import { ISOLATED } from '../../vite.config.mjs';
import { complaintsOf, openChromium, openFirefox } from './browsers.mjs';
import { knotText } from './samples.mjs';
import { legend, run, take, test } from './visit.mjs';

/** In the page: what a mesher makes, and how many threads it has. */
async function made({ knot, options }) {
  const { createMesher } = await import(new URL('hexcast.js', location.href).href);
  const source = Uint8Array.from(knot, (letter) => letter.charCodeAt(0));
  const mesher = await createMesher(options).catch(({ code }) => ({ code }));
  if (mesher.code) return mesher.code;
  const surface = await mesher.read(source, { file: 'knot.stl' });
  const hashes = [];
  for (const job of [{ cells: 300 }, { cells: 80, links: {}, fractions: {} }, { graded: { max_size: 0.5, min_size: 0.1 } }]) {
    const mesh = await mesher.mesh({ geometries: [{ source: surface }], ...job });
    const file = await mesh.blob(job.links ? 'links.npz' : 'hxc');
    hashes.push(await mesh.sha256(), [...new Uint8Array(await crypto.subtle.digest('SHA-256', await file.arrayBuffer()))].join());
  }
  const stop = new AbortController();
  const onProgress = ({ stage }) => stage === 'mesh' && stop.abort('enough');
  const big = { geometries: [{ source: surface }], cells: 3000 };
  const aborted = await mesher.mesh(big, { signal: stop.signal, onProgress }).catch((reason) => reason);
  const { threads, backend } = mesher;
  mesher.dispose();
  return { isIsolated: crossOriginIsolated, threads, backend, hashes, aborted };
}

for (const [name, open] of Object.entries({ Chromium: openChromium, Firefox: openFirefox })) {
  test(`an isolated page meshes on several threads in ${name}, and any other on one, with the same bytes`, async ({
    site,
    isolatedSite,
  }) => {
    const knot = await knotText();
    const browser = await open();
    const ask = async (url, ...asked) => {
      const page = await browser.newPage();
      const complaints = complaintsOf(page, url);
      await page.goto(url);
      const found = [];
      for (const options of asked) found.push(await page.evaluate(made, { knot, options }));
      assert.deepEqual(complaints, []);
      await page.close();
      return found;
    };
    try {
      const [one, refused] = await ask(site, { backend: 'cpu' }, { backend: 'cpu', threads: 2 });
      assert.deepEqual([one.isIsolated, one.threads, one.aborted], [false, 1, 'enough']);
      assert.equal(refused, 'job-conflict');
      for (const [options, threads] of [
        [{ backend: 'cpu', threads: 3 }, 3],
        [{ backend: 'gpu', threads: 2 }, 2],
        [{ backend: 'cpu', threads: 1 }, 1],
        [{ backend: 'cpu', worker: false }, 1],
      ]) {
        const [several] = await ask(isolatedSite, options);
        assert.deepEqual(several, { ...one, isIsolated: true, threads, backend: options.backend }, JSON.stringify(options));
      }
    } finally {
      await browser.close();
    }
  });
}

test('a thread that fails fails the calls that wait for it', async ({ browser }) => {
  const root = mkdtempSync(path.join(tmpdir(), 'hexcast-'));
  cpSync(DIST, root, { recursive: true });
  const worker = readFileSync(path.join(root, 'worker.js'), 'utf8');
  // it would run its share of the work, which the mesher waits for
  const late = "await new Promise((resolve) => setTimeout(resolve, 5000)); throw new Error('planted');";
  writeFileSync(path.join(root, 'worker.js'), worker.replace('many.runThread();', late));
  const server = await serve({ root, headers: ISOLATED });
  const page = await browser.newPage();
  try {
    await page.goto(server.url);
    const asked = async (knot) => {
      const { createMesher } = await import(new URL('hexcast.js', location.href).href);
      const mesher = await createMesher({ backend: 'cpu', threads: 2 });
      const source = Uint8Array.from(knot, (letter) => letter.charCodeAt(0));
      const job = { geometries: [{ source }], cells: 100 };
      const told = ({ code, message }) => `${code}: ${message}`;
      return [await mesher.mesh(job).catch(told), await mesher.mesh(job).catch(told)];
    };
    const [first, second] = await page.evaluate(asked, await knotText());
    assert.match(first, /^device-failed: .*planted/);
    assert.match(second, /^disposed: /);
  } finally {
    await page.close();
    await server.close();
    rmSync(root, { recursive: true });
  }
});

test('the page itself meshes on all threads where it is isolated, which its service worker sees to from the second visit on', async ({
  visit,
  isolatedSite,
  browser,
  site,
}) => {
  const page = await visit('#cells=20&backend=cpu', { url: isolatedSite });
  await take(page, 'cubes', 2);
  await run(page);
  assert.deepEqual(await legend(page), [
    [1, 1000],
    [2, 500],
  ]);
  const context = await browser.newContext();
  const again = await context.newPage();
  await again.goto(site);
  assert.equal(await again.evaluate(() => crossOriginIsolated), false);
  await again.evaluate(() => navigator.serviceWorker.ready.then(() => {}));
  await again.reload();
  assert.equal(await again.evaluate(() => crossOriginIsolated), true);
  const { hashes, threads } = await again.evaluate(made, { knot: await knotText(), options: { backend: 'cpu', threads: 2 } });
  assert.equal(threads, 2);
  assert.equal(hashes.length, 6);
  await context.close();
});

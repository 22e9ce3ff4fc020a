/**
 * The service worker: keeps the files of the page and answers with them where there is no network. It also isolates the page from other
 * origins, so that the mesher has threads, whatever host the page is on: from the second visit on, as the first comes without it.
 */
const worker = /** @type {ServiceWorkerGlobalScope} */ (/** @type {unknown} */ (self));

/** All files of the page: the build replaces this list. */
const FILES = ['./'];
const CACHE = 'hexcast';

worker.addEventListener('install', (event) => event.waitUntil(keep().then(() => worker.skipWaiting())));
// it answers the next page, not those that are open: in Firefox an isolated page fails to load what it asks for meanwhile
worker.addEventListener('activate', (event) => event.waitUntil(removeOthers()));
worker.addEventListener('fetch', (event) => {
  const { request } = event;
  if (request.method !== 'GET' || new URL(request.url).origin !== location.origin) return;
  event.respondWith(answer(request));
});

async function keep() {
  const cache = await caches.open(CACHE);
  await cache.addAll(FILES);
}

/** Removes the files of earlier builds. */
async function removeOthers() {
  const cache = await caches.open(CACHE);
  const { scope } = worker.registration;
  const wanted = new Set(FILES.map((file) => new URL(file, scope).href));
  const old = (await cache.keys()).filter(({ url }) => url.startsWith(scope) && !wanted.has(url));
  await Promise.all(old.map((request) => cache.delete(request)));
}

/** @param {Request} request */
async function answer(request) {
  try {
    return isolated(request, await fetch(request));
  } catch (error) {
    const kept = await caches.match(request, { ignoreSearch: true });
    if (kept) return isolated(request, kept);
    throw error;
  }
}

/** A page or a worker with the headers that let it share memory; any other file as it is. @param {Request} request @param {Response} response */
function isolated({ destination }, response) {
  if (!response.ok || !['document', 'worker'].includes(destination)) return response;
  const headers = new Headers(response.headers);
  headers.set('Cross-Origin-Opener-Policy', 'same-origin');
  headers.set('Cross-Origin-Embedder-Policy', 'require-corp');
  return new Response(response.body, { status: response.status, statusText: response.statusText, headers });
}

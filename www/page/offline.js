/** The service worker: keeps the files of the page and answers with them where there is no network. */
const worker = /** @type {ServiceWorkerGlobalScope} */ (/** @type {unknown} */ (self));

/** All files of the page: the build replaces this list. */
const FILES = ['./'];
const CACHE = 'hexcast';

worker.addEventListener('install', (event) => event.waitUntil(keep().then(() => worker.skipWaiting())));
worker.addEventListener('activate', (event) => event.waitUntil(removeOthers().then(() => worker.clients.claim())));
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
    return await fetch(request);
  } catch (error) {
    const kept = await caches.match(request, { ignoreSearch: true });
    if (kept) return kept;
    throw error;
  }
}

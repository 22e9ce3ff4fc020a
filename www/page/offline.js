/**
 * The service worker: keeps the page for when there is no network. The network comes first, then what was kept. The build puts
 * `FILES`, the names of all files of the page, above.
 *
 * @type {string[]} FILES
 */
const CACHE = 'hexcast';

addEventListener('install', (event) => event.waitUntil(keep().then(() => skipWaiting())));
addEventListener('activate', (event) => event.waitUntil(forgetOthers().then(() => clients.claim())));
addEventListener('fetch', (event) => {
  const { request } = event;
  if (request.method !== 'GET' || new URL(request.url).origin !== location.origin) return;
  event.respondWith(answer(request));
});

async function keep() {
  const cache = await caches.open(CACHE);
  await cache.addAll(FILES);
}

/** Removes the files of earlier builds. */
async function forgetOthers() {
  const cache = await caches.open(CACHE);
  const wanted = new Set(FILES.map((file) => new URL(file, location.href).href));
  const old = (await cache.keys()).filter(({ url }) => url.startsWith(registration.scope) && !wanted.has(url));
  await Promise.all(old.map((request) => cache.delete(request)));
}

async function answer(request) {
  try {
    return await fetch(request);
  } catch (error) {
    const kept = await caches.match(request, { ignoreSearch: true });
    if (kept) return kept;
    throw error;
  }
}

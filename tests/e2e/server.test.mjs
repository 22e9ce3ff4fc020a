// The static server: types, sub-paths, and no file outside its folders.

import assert from 'node:assert/strict';
import { request } from 'node:http';
import { test } from 'node:test';

import { serve } from '../../scripts/serve.mjs';

/** Asks with the path as it is: fetch would resolve the dots itself. */
function get(url, path) {
  const { hostname, port } = new URL(url);
  return new Promise((resolve, reject) => {
    const answered = (response) => resolve({ status: response.resume().statusCode, type: response.headers['content-type'] });
    request({ hostname, port, path }, answered).on('error', reject).end();
  });
}

test('files have their type, also below a path', async () => {
  const { url, close } = await serve({ base: '/a/b/' });
  try {
    assert.deepEqual(await get(url, '/a/b/'), { status: 200, type: 'text/html; charset=utf-8' });
    assert.deepEqual(await get(url, '/a/b/page/main.js?x=1'), { status: 200, type: 'text/javascript; charset=utf-8' });
    assert.deepEqual(await get(url, '/a/b/hexcast_bg.wasm'), { status: 200, type: 'application/wasm' });
    for (const path of ['/', '/a/page/main.js', '/a/b', '/a/b/nothing.js'])
      assert.equal((await get(url, path)).status, 404, path);
  } finally {
    await close();
  }
});

test('nothing outside the folder is served', async () => {
  const { url, close } = await serve();
  try {
    for (const path of [
      '/../package.json',
      '/%2e%2e/package.json',
      '/..%2fpackage.json',
      '/x/../../package.json',
      '/%00',
      '/%zz',
      '//package.json',
    ]) {
      assert.equal((await get(url, path)).status, 404, path);
    }
  } finally {
    await close();
  }
});

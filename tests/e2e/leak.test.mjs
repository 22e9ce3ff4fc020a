// Leaks: the package, in a worker and on the calling thread, answers as the native command does; the page asks for two points and shows
// the path and its narrowest place.

import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';

import { PROGRAM } from './native.mjs';
import { CLOSED_BOX, OPEN_BOX, boxBetween } from './open_box.mjs';
import { hasGeometries, run, test } from './visit.mjs';

const INSIDE = [2, 1, 1];
const OUTSIDE = [-0.4, -0.4, 2.3];

/** What `hexcast leak --json` prints of a column file, with the facets of a box. */
function nativeLeak(folder, mesh, code) {
  const ends = [`--from=${INSIDE}`, `--to=${OUTSIDE}`];
  const files = [path.join(folder, mesh), '--surface', path.join(folder, 'box.stl')];
  const { status, stdout, stderr } = spawnSync(PROGRAM, ['leak', ...files, ...ends, '--json'], { encoding: 'utf8' });
  assert.equal(status, code, stderr);
  return JSON.parse(stdout);
}

for (const worker of [true, false]) {
  const where = worker ? 'in a worker' : 'on the calling thread';

  test(`the leak of a mesh is that of the native command, ${where}`, async ({ visit }) => {
    const page = await visit('');
    const folder = mkdtempSync(path.join(tmpdir(), 'hexcast-'));
    try {
      for (const [text, code] of [
        [OPEN_BOX, 9],
        [CLOSED_BOX, 0],
      ]) {
        const { leak, hxc } = await page.evaluate(
          async ([text, from, to, worker]) => {
            const { createMesher } = await import(new URL('hexcast.js', location.href).href);
            const mesher = await createMesher({ backend: 'cpu', ...(worker ? {} : { worker: false }) });
            const geometries = [{ source: new File([text], 'box.stl'), shell: true }];
            const job = { geometries, cell_size: 0.25, padding: { cells: 2 }, unit: 'mm' };
            const mesh = await mesher.mesh(job);
            const leak = await mesh.leak({ from, to, job });
            const bytes = new Uint8Array(await (await mesh.blob('hxc')).arrayBuffer());
            mesher.dispose();
            return { leak, hxc: [...bytes] };
          },
          [text, INSIDE, OUTSIDE, worker],
        );
        writeFileSync(path.join(folder, 'box.stl'), text);
        writeFileSync(path.join(folder, 'mesh.hxc'), Uint8Array.from(hxc));
        assert.deepEqual(leak, nativeLeak(folder, 'mesh.hxc', code));
        assert.equal(leak.is_tight, code === 0);
        if (code === 9) assert.ok(leak.narrowest.width > 1 && leak.facets.length > 0, JSON.stringify(leak));
      }
    } finally {
      rmSync(folder, { recursive: true });
    }
  });
}

test('a question that cannot be answered says which part of it is wrong', async ({ visit }) => {
  const page = await visit('');
  const errors = await page.evaluate(
    async ([text, from, to]) => {
      const { createMesher } = await import(new URL('hexcast.js', location.href).href);
      const mesher = await createMesher({ backend: 'cpu' });
      const mesh = await mesher.mesh({ geometries: [{ source: new File([text], 'box.stl') }], cells: 16 });
      const ask = (question) =>
        mesh.leak({ from, to: from, ...question }).then(
          () => null,
          ({ code, message }) => `${code}: ${message}`,
        );
      return [await ask({ to }), await ask({ flags: [1, 256] }), await ask({ from: [1, 2] }), await ask({ max_memory: 10 })];
    },
    [CLOSED_BOX, INSIDE, OUTSIDE],
  );
  assert.match(errors[0], /^job-value: the end \(-0\.4, -0\.4, 2\.3\) lies outside of the mesh/);
  assert.match(errors[1], /^job-value: flags\[1\] of the leak: .*256/);
  assert.match(errors[2], /^job-value: from of the leak: .*length 2/);
  assert.match(errors[3], /^memory: .* 10 are allowed/);
});

/** A casing with walls of a cell, and what is drilled through its upper wall. */
const CASING = {
  'case.stl': boxBetween([0, 0, 0], [10, 10, 10]) + boxBetween([1, 1, 1], [9, 9, 9]),
  'hole.stl': boxBetween([4, 6, 8.5], [6, 7, 10]),
};

test('a leak is found between two points, one picked with the keyboard and one typed, and drawn to its narrowest place', async ({
  visit,
}) => {
  const page = await visit('#cell_size=1&backend=cpu&padding=2&unit=mm');
  const files = Object.entries(CASING).map(([name, text]) => ({ name, mimeType: 'model/stl', buffer: Buffer.from(text) }));
  await page.setInputFiles('#file-input', files);
  await hasGeometries(page, 2);
  await run(page);
  await page.click('#leak summary');
  // from the middle of the casing
  await page.getByLabel('Pick the first point').press('Enter');
  assert.ok(await page.isVisible('#pane-z'));
  await page.waitForSelector('#canvas-z[data-axis=z]');
  await page.keyboard.press('Shift+ArrowUp');
  assert.equal(await page.textContent('#readout'), 'cell 7, 8, 7 at 5.5, 6.5, 5.5 mm: background');
  await page.keyboard.press('Enter');
  assert.equal(await page.inputValue('#leak-from'), '5.5, 6.5, 5.5');
  await page.getByLabel('To x, y, z').fill('-1');
  await page.click('#leak-find');
  assert.match(await page.$eval('#leak-to', (input) => input.validationMessage), /x, y and z/);
  await page.fill('#leak-to', '-1 -1 -1');
  await page.keyboard.press('Enter');
  await page.waitForFunction(() => /path/.test(document.querySelector('#leak-answer').textContent));
  assert.match(
    await page.textContent('#leak-answer'),
    /^No path leads from cell 7, 8, 7 to cell 1, 1, 1 through flag 0\. 512 cells are reached from the first point, 1,744 from the second\. $/,
  );
  assert.equal(await page.locator('#finding-list [data-kind=leak]').count(), 0);
  await page.fill('#leak-flags', '0 2');
  await page.click('#leak-find');
  await page.waitForSelector('#finding-list [data-kind=leak]');
  assert.match(
    await page.textContent('#leak-answer'),
    /^A path of \d+ steps, \d+ mm long, leads from cell 7, 8, 7 to cell 1, 1, 1 through flags 0, 2\. $/,
  );
  const text = await page.textContent('#finding-list [data-kind=leak] p');
  const [, place] =
    /^The leak is narrowest at ([45]\.5, 6\.5, 9\.5): a cube of 1 cell passes, none of 2\. \d+ facets of case and hole lie around it\.$/.exec(
      text,
    );
  await page.waitForSelector(`#canvas-3d[data-place="${place.replaceAll(',', '')}"]`, { state: 'attached' });
  // the slice went there, too, and shows the path in its plane and the mark
  await page.waitForSelector('#canvas-z[data-index="11"]');
  assert.ok(Number(await page.getAttribute('#canvas-z', 'data-marks')) >= 1);
  assert.ok((await redPixels(page)) > 50);
  // an end that is not open says so
  await page.fill('#leak-flags', '2');
  await page.click('#leak-find');
  assert.match(await page.textContent('#messages [data-code=job-value]'), /a path may only use flag 2/);
  // a click in the slice is a point, too
  await page.click('#leak-pick-to');
  const corner = await page.$eval('#canvas-z', ({ dataset: { left, top, scaleX, scaleY, height } }) => ({
    x: (Number(left) + 0.5 * scaleX) / devicePixelRatio,
    y: (Number(top) + (height - 0.5) * scaleY) / devicePixelRatio,
  }));
  await page.click('#canvas-z', { position: corner });
  assert.equal(await page.inputValue('#leak-to'), '-1.5, -1.5, 9.5');
  // another mesh has no leak yet
  await run(page);
  assert.equal(await page.textContent('#leak-answer'), '');
  assert.equal(await page.locator('#finding-list [data-kind=leak]').count(), 0);
});

/** Pixels of the slice in the colour of the mark. */
function redPixels(page) {
  return page.$eval('#canvas-z', (canvas) => {
    const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
    let n = 0;
    for (let at = 0; at < data.length; at += 4) n += data[at] === 0xe0 && data[at + 1] === 0x10 && data[at + 2] === 0x3c;
    return n;
  });
}

// The pixels of the 3-D view: each is held to the flag that a ray finds which walks from mesh line to mesh line through all cells.

import assert from 'node:assert/strict';

import { randomFrom } from './random.mjs';
import { cellsAreDrawn, hasGeometries, picture3d, run, saved, test } from './visit.mjs';

/** Pixels that are compared in a picture. */
const PIXELS = 400;

const times = (a, by) => a.map((number) => number * by);
const plus = (a, b) => a.map((number, axis) => number + b[axis]);
const minus = (a, b) => a.map((number, axis) => number - b[axis]);
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const unit = (a) => times(a, 1 / Math.hypot(...a));

/** The ray of a place of the picture, from -1 to 1 each way. */
function rayOf({ stretch, centre, eye, target, tangent }, aspect, [x, y]) {
  const ahead = unit(minus(target, eye));
  const right = unit(cross(ahead, [0, 0, 1]));
  const up = cross(right, ahead);
  // what is stretched is shorter in the world than in the picture
  const inWorld = (at) => at.map((number, axis) => number / stretch[axis]);
  const way = plus(ahead, plus(times(right, x * tangent * aspect), times(up, y * tangent)));
  return { from: inWorld(plus(centre, eye)), way: inWorld(way) };
}

/** The first cell with a flag along a ray: all crossings with lines are sorted, and between two of them lies a cell. */
function firstSeen({ from, way }, { lines, dims, raw, hidden, cut }) {
  const crossings = lines.flatMap((list, axis) => list.map((at) => (at - from[axis]) / way[axis]));
  if (cut) crossings.push((cut.at - from[cut.axis]) / way[cut.axis]);
  const sorted = crossings.filter((t) => t > 0).sort((a, b) => a - b);
  for (const [index, t] of sorted.entries()) {
    const middle = plus(from, times(way, (t + (sorted[index + 1] ?? t)) / 2));
    if (cut && cut.side * (middle[cut.axis] - cut.at) > 0) continue;
    const cell = middle.map((at, axis) => lines[axis].findLastIndex((line) => line <= at));
    if (cell.some((at, axis) => at < 0 || at >= dims[axis])) continue;
    const flag = raw[cell[0] + dims[0] * (cell[1] + dims[1] * cell[2])];
    if (flag !== 0 && !hidden.includes(flag)) return { flag, cell };
  }
  return { flag: 0, cell: null };
}

/** The flag whose colour a pixel has, in some light; 0 where it is transparent. */
function flagOf([red, green, blue, alpha], colours) {
  if (alpha === 0) return 0;
  const pixel = [red, green, blue];
  const off = colours.map(([flag, colour]) => {
    const light =
      pixel.reduce((sum, part, at) => sum + part * colour[at], 0) / colour.reduce((sum, part) => sum + part * part, 0);
    return { flag, off: Math.hypot(...pixel.map((part, at) => part - light * colour[at])) };
  });
  return off.reduce((best, one) => (one.off < best.off ? one : best)).flag;
}

/** What a page with a mesh knows of it, and its flags. */
async function meshOf(page) {
  const report = JSON.parse(await page.textContent('#report'));
  const { dims, origin, spacing, grading } = report;
  const lines = grading
    ? [grading.x, grading.y, grading.z]
    : dims.map((n, axis) => Array.from({ length: n + 1 }, (_, at) => origin[axis] + at * spacing[axis]));
  const colours = await page.$$eval('#legend tr', (rows) =>
    rows.map((row) => {
      const colour = getComputedStyle(row.querySelector('.swatch')).backgroundColor;
      return [Number(row.dataset.flag), colour.match(/\d+/g).map(Number)];
    }),
  );
  const { bytes } = await saved(page, '#download-raw');
  return { dims, lines, colours, raw: new Uint8Array(bytes), axis: report.ray_axis };
}

/** Whether a pixel is within three of an edge of the box, which is drawn over the cells. */
function isAtBox({ stretch, centre, eye, target, tangent }, lines, [width, height], [x, y]) {
  const ahead = unit(minus(target, eye));
  const right = unit(cross(ahead, [0, 0, 1]));
  const dot = (a, b) => a.reduce((sum, number, axis) => sum + number * b[axis], 0);
  const corners = Array.from({ length: 8 }, (_, corner) => {
    const from = minus(
      lines.map((list, axis) => stretch[axis] * list.at((corner >> axis) & 1 ? -1 : 0)),
      plus(centre, eye),
    );
    const [across, up, depth] = [right, cross(right, ahead), ahead].map((axis) => dot(from, axis));
    const half = height / 2 / tangent / depth;
    return [width / 2 + across * half, height / 2 - up * half];
  });
  return corners.some((a, corner) =>
    [0, 1, 2].some((axis) => {
      const b = corners[corner | (1 << axis)];
      const way = minus(b, a);
      const share = Math.min(Math.max(dot(minus([x + 0.5, y + 0.5], a), way) / Math.max(dot(way, way), 1e-9), 0), 1);
      return Math.hypot(...minus([x + 0.5, y + 0.5], plus(a, times(way, share)))) < 3;
    }),
  );
}

/** Compares random pixels of the picture as it is now; returns how many were compared and how many were beside an edge. */
async function compare(page, mesh, seed, { hidden = [], cut = null } = {}) {
  const picture = await picture3d(page);
  const sight = JSON.parse(await page.getAttribute('#canvas-3d', 'data-sight'));
  const { width, height } = await picture.evaluate(({ width, height }) => ({ width, height }));
  const random = randomFrom(seed);
  const places = Array.from({ length: PIXELS }, () => [Math.floor(random() * width), Math.floor(random() * height)]);
  const pixels = await picture.evaluate(
    ({ data, width }, places) => places.map(([x, y]) => [...data.slice(4 * (x + width * y), 4 * (x + width * y) + 4)]),
    places,
  );
  const n = { compared: 0, seen: 0, atEdge: 0 };
  const wrong = [];
  for (const [index, [x, y]] of places.entries()) {
    if (isAtBox(sight, mesh.lines, [width, height], [x, y])) continue;
    const at = ([dx, dy]) => {
      const place = [(2 * (x + 0.5 + dx)) / width - 1, 1 - (2 * (y + 0.5 + dy)) / height];
      return firstSeen(rayOf(sight, width / height, place), { ...mesh, hidden, cut }).flag;
    };
    const expected = at([0, 0]);
    const around = [-1, 0, 1].flatMap((dx) => [-1, 0, 1].map((dy) => at([dx, dy])));
    if (around.some((flag) => flag !== expected)) n.atEdge += 1;
    else {
      n.compared += 1;
      n.seen += expected > 0 ? 1 : 0;
      const found = flagOf(pixels[index], mesh.colours);
      if (found !== expected) wrong.push({ x, y, expected, found, pixel: pixels[index] });
    }
  }
  console.log(`${n.compared} pixels compared, ${n.seen} of them of cells; ${n.atEdge} within a pixel of an edge`);
  assert.deepEqual(wrong, []);
  assert.ok(n.seen > PIXELS / 20, `${n.seen} pixels of cells`);
  return sight;
}

const CASES = {
  'equal cells': '#cells=30&sample=shells&backend=cpu',
  'graded lines': '#graded=2.2&min_size=0.2&growth=1.5&padding=2&padding_by=length&sample=cubes&backend=cpu',
};

for (const [name, hash] of Object.entries(CASES)) {
  for (const axis of ['x', 'z']) {
    test(`pixels of the 3-D view are those of the first cells along their rays: ${name}, rays along ${axis}, seed 7`, async ({
      visit,
    }) => {
      const page = await visit(`${hash}&axis=${axis}`);
      await hasGeometries(page, 2);
      await run(page);
      await cellsAreDrawn(page);
      const mesh = await meshOf(page);
      assert.equal(
        mesh.raw.length,
        mesh.dims.reduce((product, n) => product * n, 1),
      );
      await page.focus('#canvas-3d');
      await compare(page, mesh, 7);
      for (const key of ['ArrowLeft', 'ArrowDown', '+'])
        for (let press = 0; press < 9; press += 1) await page.keyboard.press(key);
      const sight = await compare(page, mesh, 8);
      // a cut shows what is within, and leaves out what lies on the side of the eye
      await page.selectOption('#section-axis', '1');
      const index = Math.floor(mesh.dims[1] / 2);
      const at = (mesh.lines[1][index] + mesh.lines[1][index + 1]) / 2;
      await compare(page, mesh, 9, { cut: { axis: 1, side: sight.eye[1] - sight.target[1] < 0 ? -1 : 1, at } });
      // an axis that is drawn longer, cut and not
      await page.selectOption('#stretch', '2 4');
      await compare(page, mesh, 12, { cut: { axis: 1, side: sight.eye[1] - sight.target[1] < 0 ? -1 : 1, at } });
      await page.selectOption('#section-axis', '');
      await compare(page, mesh, 13);
      await page.selectOption('#stretch', '');
      await page.uncheck('#legend tr:first-child input');
      await page.waitForTimeout(100);
      await compare(page, mesh, 10, { hidden: [mesh.colours[0][0]] });
    });
  }
}

test('a click names the cell that the ray finds there', async ({ visit }) => {
  const page = await visit(CASES['equal cells']);
  await hasGeometries(page, 2);
  await run(page);
  await cellsAreDrawn(page);
  const mesh = await meshOf(page);
  const random = randomFrom(11);
  const { width, height } = await page.locator('#canvas-3d').boundingBox();
  await page.waitForFunction(() => document.querySelector('#canvas-3d').dataset.whole === 'true');
  const sight = JSON.parse(await page.getAttribute('#canvas-3d', 'data-sight'));
  let n_named = 0;
  for (let click = 0; click < 15; click += 1) {
    const [x, y] = [Math.floor(width * (0.25 + random() / 2)), Math.floor(height * (0.25 + random() / 2))];
    const cellAt = (dx, dy) => {
      const place = [(2 * (x + dx)) / width - 1, 1 - (2 * (y + dy)) / height];
      return firstSeen(rayOf(sight, width / height, place), { ...mesh, hidden: [] });
    };
    const { flag, cell } = cellAt(0, 0);
    // the browser may round the place of a click
    const around = [-1, 1].flatMap((dx) => [-1, 1].map((dy) => String(cellAt(dx, dy).cell)));
    if (around.some((other) => other !== String(cell))) continue;
    await page.mouse.move(0, 0);
    await page.click('#canvas-3d', { position: { x, y } });
    const words = cell ? new RegExp(`^cell ${cell.join(', ')} at .*: flag ${flag}, `) : /^$/;
    await page.waitForFunction((words) => new RegExp(words).test(document.querySelector('#readout').textContent), words.source);
    n_named += cell ? 1 : 0;
  }
  assert.ok(n_named > 3, `${n_named} clicks named a cell`);
});

test('flags have colours of their own: 1 and 11, 24 and 25', async ({ visit }) => {
  const page = await visit('#cells=8&backend=cpu&sample=cubes');
  await hasGeometries(page, 2);
  const colours = [];
  for (const flag of [1, 11, 2, 12, 24, 25]) {
    await page.fill('.geometry .flag >> nth=0', String(flag));
    colours.push(await page.inputValue('.geometry [type=color] >> nth=0'));
  }
  assert.equal(new Set(colours).size, colours.length, `${colours}`);
});

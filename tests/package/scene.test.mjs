// Scenes: after each edit the mesh is that of the whole job, and what changed is listed.

import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import path from 'node:path';
import { after, before, test } from 'node:test';

import { ROOT } from '../../scripts/run.mjs';
import { SPOT, installedProject } from './project.mjs';

let project;
before(() => (project = installedProject()));
after(() => project.remove());

/** Runs code in the project that has a mesher, a job of two surfaces and a scene of it. */
function inNode(code) {
  const script = `
    import { readFileSync } from 'node:fs';
    import { createMesher } from 'hexcast';
    const print = (value) => console.log(JSON.stringify(value));
    const mesher = await createMesher({ backend: 'cpu' });
    const spot = await mesher.read(readFileSync(process.argv[2]));
    const octahedron = await mesher.read(new Float32Array([
      ...[[1, 1, 1], [-1, -1, 1], [-1, 1, -1], [1, -1, -1]].flatMap(([x, y, z]) => [x, 0, 0, 0, y, 0, 0, 0, z]),
      ...[[-1, 1, 1], [1, -1, 1], [1, 1, -1], [-1, -1, -1]].flatMap(([x, y, z]) => [0, y, 0, x, 0, 0, 0, 0, z]),
    ]));
    const placed = (of = {}, other = {}) => ({
      geometries: [{ source: spot, flag: 3, ...other }, { source: octahedron, flag: 7, scale: 0.4, ...of }],
      domain: [-1, -1, -1, 1, 1, 1],
      dims: [30, 34, 38],
    });
    const flagsOf = async (mesh) => (await mesh.box([0, 0, 0], mesh.dims)).flags;
    const failure = (promise) => promise.then(() => 'none', ({ code, message }) => code ?? message);
    const scene = await mesher.scene(placed());
    ${code}
    mesher.dispose();
  `;
  return JSON.parse(project.run('scene.js', script, SPOT));
}

/** Random edits of a scene: `HEXCAST_SCENES=200` makes 10,000. */
const EDITS = process.env.HEXCAST_SCENES ? 50 * Number(process.env.HEXCAST_SCENES) : 120;

test('a scene follows random edits: the flags are those of whole meshes, and the changes lead from one to the next', () => {
  const { wrong, unexplained, whole, changed } = inNode(`
    let seed = 7;
    const random = () => (seed = (seed * 48271) % 2147483647) / 2147483647;
    const flags = await flagsOf(scene.mesh);
    const { axis } = scene.mesh.columns;
    const strides = [1, 30, 30 * 34];
    const across = [0, 1, 2].filter((of) => of !== axis);
    let [wrong, unexplained, whole, changed] = [0, 0, 0, 0];
    let job = placed();
    for (let step = 0; step < ${EDITS}; step += 1) {
      const of = job.geometries[random() < 0.7 ? 1 : 0];
      const edit = random();
      if (edit < 0.6) of.translate = [0, 1, 2].map(() => 1.4 * random() - 0.7);
      else if (edit < 0.7) of.flag = 1 + Math.floor(9 * random());
      else if (edit < 0.8) of.rotate = [0, 1, 2].map(() => Math.floor(360 * random()));
      else if (edit < 0.9) of.priority = Math.floor(3 * random());
      else of.source = of.source === spot ? octahedron : spot;
      const update = await scene.update(job);
      if (update.whole) whole += 1;
      const { rays, starts, ends, before, after } = update.changed;
      changed += rays.length;
      for (let run = 0; run < rays.length; run += 1) {
        const n_i = scene.mesh.dims[across[0]];
        const first = (rays[run] % n_i) * strides[across[0]] + Math.floor(rays[run] / n_i) * strides[across[1]];
        for (let cell = starts[run]; cell < ends[run]; cell += 1) {
          const at = first + cell * strides[axis];
          if (flags[at] !== before[run] || before[run] === after[run]) unexplained += 1;
          flags[at] = after[run];
        }
      }
      const found = await flagsOf(scene.mesh);
      const mesh = await mesher.mesh(job);
      const expected = await flagsOf(mesh);
      mesh.dispose();
      if (!Buffer.from(found).equals(Buffer.from(expected))) wrong += 1;
      if (!Buffer.from(found).equals(Buffer.from(flags))) unexplained += 1;
    }
    print({ wrong, unexplained, whole, changed });
  `);
  assert.deepEqual({ wrong, unexplained }, { wrong: 0, unexplained: 0 });
  assert.ok(whole < EDITS / 3, `${whole} of ${EDITS} edits made the whole mesh`);
  assert.ok(changed > (5000 / 120) * EDITS, `${changed} runs changed`);
});

test('what rays alone do not decide is meshed whole, and says why', () => {
  const told = inNode(`
    const rays = await scene.update(placed({ translate: [0.2, 0, 0] }));
    const report = scene.mesh.report;
    const box = await scene.update({ ...placed(), dims: [10, 10, 10] });
    const asked = await scene.update({ ...placed(), dims: [10, 10, 10], links: { fluid: [0] } });
    const links = await scene.mesh.links();
    const nothing = await scene.update(placed({ scale: 0.003 }));
    const again = await scene.update(placed({ scale: 0.003, translate: [0.3, 0, 0] }));
    print({
      rays: [rays.whole, rays.rays > 0, report.backend, report.flags.map(({ flag }) => flag)],
      box: [box.whole, box.changed, scene.mesh.dims],
      asked: [asked.whole, Object.keys(links).length > 0],
      nothing: [nothing.whole, again.whole, again.findings.map(({ code }) => code)],
    });
  `);
  assert.deepEqual(told, {
    rays: [null, true, null, [3, 7]],
    box: ['box', null, [30, 34, 38]],
    asked: ['asked', true],
    nothing: ['asked', null, ['no-cell-thin']],
  });
});

test('errors and aborts leave the scene as it was; what is disposed of says so', () => {
  const told = inNode(`
    const sha = await scene.mesh.sha256();
    const first = scene.mesh;
    const wrong = await failure(scene.update(placed({ flag: 300 })));
    const option = await failure(scene.update(placed(), { spill: true }));
    const isSame = (await scene.mesh.sha256()) === sha && scene.mesh === first;
    const controller = new AbortController();
    const aborted = scene.update(placed({ translate: [0.3, 0.3, 0.3] }), { signal: controller.signal });
    controller.abort(new Error('enough'));
    const reason = await failure(aborted);
    // whether it was made is not known
    const next = await scene.update(placed({ translate: [0.1, 0, 0] }));
    const after = await scene.update(placed({ translate: [0.1, 0.1, 0] }));
    const old = await failure(first.flag(0, 0, 0));
    const whole = await mesher.mesh(placed({ translate: [0.1, 0.1, 0] }));
    const isWhole = (await whole.sha256()) === (await scene.mesh.sha256());
    const last = scene.mesh;
    scene.dispose();
    scene.dispose();
    print({
      wrong, option, isSame, reason, next: next.changed, after: after.changed.rays.length > 0, old, isWhole,
      disposed: [await failure(scene.update(placed())), await failure(last.flag(0, 0, 0))],
    });
  `);
  assert.deepEqual(told, {
    wrong: 'job-value',
    option: 'job-value',
    isSame: true,
    reason: 'enough',
    next: null,
    after: true,
    old: 'disposed',
    isWhole: true,
    disposed: ['disposed', 'disposed'],
  });
});

test('what is disposed of during an update waits for it, and the mesher goes on; a mesher that is disposed of ends', () => {
  const told = inNode(`
    const during = scene.update(placed({ translate: [0.2, 0, 0] }));
    await new Promise((resolve) => setTimeout(resolve));
    scene.dispose();
    const first = await failure(during);
    const mesh = await mesher.mesh(placed());
    const other = await mesher.scene(placed());
    const last = other.update(placed({ translate: [0.2, 0, 0] }));
    await new Promise((resolve) => setTimeout(resolve));
    mesher.dispose();
    print({ first, cells: mesh.report.cells, last: await failure(last) });
  `);
  assert.deepEqual(told, { first: 'disposed', cells: 30 * 34 * 38, last: 'cancelled' });
});

test('updates that are asked for together each list what they change; the first answer after an abort does not', () => {
  const told = inNode(`
    const moved = (x, options) => scene.update(placed({ translate: [x, 0, 0] }), options);
    const together = await Promise.all([moved(0.1), moved(0.2), moved(0.3)]);
    const controller = new AbortController();
    const jobs = [moved(0.1), moved(0.2, { signal: controller.signal }), moved(0.3), moved(0.4)];
    controller.abort(new Error('enough'));
    const after = await Promise.allSettled(jobs);
    print([
      together.map(({ changed }) => changed.rays.length > 0),
      after.map(({ value, reason }) => (reason ? reason.message : value.changed && value.changed.rays.length > 0)),
    ]);
  `);
  assert.deepEqual(told, [
    [true, true, true],
    [null, 'enough', true, true],
  ]);
});

test('the JavaScript of the documents runs as it is written', () => {
  const block = (file, kind) => {
    const blocks = [...readFileSync(path.join(ROOT, file), 'utf8').matchAll(/```js(.*)\n([\s\S]*?)```/g)];
    return blocks.find(([, of]) => of.trim() === kind)[2];
  };
  const told = inNode(`
    const bytes = readFileSync(process.argv[2]);
    const [tankFile, rotorFile] = [bytes, bytes];
    let runs = 0;
    const use = (rays) => void (runs += rays.length);
    const size = await (async () => {
      ${block('docs/scenes.md', '')}
      return vti.size;
    })();
    const job = placed();
    const changed = await (async () => {
      ${block('www/README.md', 'scene')}
      return changed.rays.length;
    })();
    print({ runs, size, changed });
  `);
  assert.ok(told.runs > 10_000 && told.size > 1000 && told.changed > 100, JSON.stringify(told));
});

// The package in Node with one thread and with several: the same bytes, reports but for times, and errors; and programs end.

import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';

import { SPOT, installedProject } from './project.mjs';

let project;
before(() => {
  project = installedProject();
});
after(() => project.remove());

/** What two meshers make of the same jobs; each mesher is the only one of its process. */
const MESHES = `
  import { readFileSync } from 'node:fs';
  import { createMesher } from 'hexcast';
  const [threads, spot] = [Number(process.argv[2]), process.argv[3]];
  const mesher = await createMesher({ backend: 'cpu', threads });
  const source = readFileSync(spot);
  // without some facets it is open
  const n = source.readUInt32LE(80) - 60;
  const open = Buffer.from(source.subarray(0, 84 + 50 * n));
  open.writeUInt32LE(n, 80);
  const surface = await mesher.read(source, { file: 'spot.stl' });
  const moved = { translate: [0.2, 0.1, 0], flag: 7, priority: 2 };
  const jobs = [
    { geometries: [{ source: surface }], cells: 200 },
    { geometries: [{ source: surface }], cells: 90, rule: 'nonzero', axis: 'x', close_gaps: 2 },
    { geometries: [{ source: surface, name: 'one' }, { source, file: 'b.stl', ...moved }], cells: 120, links: {}, fractions: {}, staggered: true },
    { geometries: [{ source: surface }], graded: { min_size: 0.01, max_size: 0.1 } },
    { geometries: [{ source: open }], cells: 64, axis: 'y' },
  ];
  const facts = [];
  for (const job of jobs) {
    const mesh = await mesher.mesh(job);
    const { seconds, timings, columns, peak_bytes, ...report } = mesh.report;
    const bytes = async (format) => {
      const hash = await crypto.subtle.digest('SHA-256', await (await mesh.blob(format)).arrayBuffer());
      return [...new Uint8Array(hash)].join();
    };
    const formats = ['npy', 'hxc', 'npz', ...(job.links ? ['links.npz', 'fractions.npz', 'staggered.npz'] : [])];
    facts.push({ flags: await mesh.sha256(), files: await Promise.all(formats.map(bytes)), flag_cells: report.flags, n: mesh.dims });
  }
  const scene = await mesher.scene(jobs[2]);
  await scene.update({ ...jobs[2], geometries: [jobs[2].geometries[0], { ...jobs[2].geometries[1], translate: [0.3, 0, 0.1] }] });
  facts.push(await scene.mesh.sha256());
  const refused = await mesher.mesh({ geometries: [{ source }], cells: 2000, max_memory: '1MB' }).catch(({ code }) => code);
  console.log(JSON.stringify({ threads: mesher.threads, info: surface.info, facts, refused }));
`;

test('one thread and several make the same files, and a program of several ends by itself', () => {
  const made = [1, 2, 5].map((threads) => JSON.parse(project.run('threads.js', MESHES, String(threads), SPOT)));
  assert.deepEqual(
    made.map(({ threads }) => threads),
    [1, 2, 5],
  );
  const [one, ...others] = made.map(({ threads: _, ...rest }) => rest);
  assert.equal(one.refused, 'memory');
  for (const several of others) assert.deepEqual(several, one);
});

/** The largest share of the processor time of a process that one of its threads has while fractions are measured. */
const SHARE = `
  import { readFileSync, readdirSync } from 'node:fs';
  import { createMesher } from 'hexcast';
  const TICKS = 11;
  const ticks = () => {
    const of = (task) => Number(readFileSync('/proc/self/task/' + task + '/stat', 'utf8').split(') ')[1].split(' ')[TICKS]);
    return new Map(readdirSync('/proc/self/task').map((task) => [task, of(task)]));
  };
  const mesher = await createMesher({ backend: 'cpu', threads: 3 });
  const job = { geometries: [{ source: readFileSync(process.argv[2]) }], cells: 200, fractions: { rays: 8 } };
  (await mesher.mesh(job)).dispose();
  const before = ticks();
  for (let n = 0; n < 3; n++) (await mesher.mesh(job)).dispose();
  const spent = [...ticks()].map(([task, after]) => after - (before.get(task) ?? 0));
  console.log(Math.max(...spent) / spent.reduce((sum, more) => sum + more));
`;

test('fractions are measured on all threads', () => {
  // a third each; on one thread, as it once was, four fifths
  const share = Number(project.run('share.js', SHARE, SPOT));
  assert.ok(share < 0.55, `one thread has ${share} of the time`);
});

const ASKED = `
  import { readFileSync } from 'node:fs';
  import { createMesher } from 'hexcast';
  const wasm = readFileSync(new URL('./hexcast_bg.wasm', import.meta.resolve('hexcast')));
  const code = (options) => createMesher({ backend: 'cpu', ...options }).then((mesher) => mesher.threads, ({ code }) => code);
  const found = [];
  for (const options of [{ threads: 0 }, { threads: 1.5 }, { threads: 2, wasm }, { wasm }, { threads: 1 }, { threads: 3 }, {}]) found.push(await code(options));
  console.log(JSON.stringify(found));
`;

test('a number of threads that there cannot be is refused; a second mesher shares the threads of the first', () => {
  const found = JSON.parse(project.run('asked.js', ASKED));
  assert.deepEqual(found, ['job-value', 'job-value', 'job-conflict', 1, 1, 3, 3]);
});

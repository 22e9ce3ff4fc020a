// Times a body that moves in a scene, beside a mesh of the whole, for bench.mjs: natively, and with the npm package in Node.

import { readFileSync } from 'node:fs';
import path from 'node:path';

import { writeWave } from '../tests/e2e/wave.mjs';
import { jsonLines, median, ms, output, table } from './results.mjs';

/** Measures ten spheres of which one moves. @param {import('./bench.mjs').Bench} bench */
export async function benchMoved({ stages, runs, sizes, quick, folder }) {
  const all = quick ? [256] : [256, ...sizes];
  const rows = all.map((n) => {
    const [printed] = jsonLines(output(stages, ['--moved', '--cells', String(n), '--runs', runs]));
    const { facets, moved_facets, rays, changed_runs, update_s, first_s, whole_s } = printed;
    const model = `${n} cells, ${moved_facets.toLocaleString('en')} of ${facets.toLocaleString('en')} facets`;
    return [model, ms(update_s), ms(first_s), ms(whole_s), rays, changed_runs];
  });
  const inNode = await measureInNode(all, Number(runs), path.join(folder, 'wave.stl'));
  const head = ['model', 'update, ms', 'the first update, ms', 'the whole, ms', 'rays made again', 'runs that changed'];
  const text = [
    '## A body that moves in a scene, CPU\n',
    table(head, rows),
    '\nThe same in Node, one thread of wasm, as a caller of the package waits for it:\n',
    table(head, inNode),
  ];
  return { adapter: '', text: text.join('\n') };
}

/** Ten bodies of 19,880 facets, of which one moves by a third of a cell at a time. @param {number[]} sizes @param {number} runs @param {string} file */
async function measureInNode(sizes, runs, file) {
  const { build, DIST } = await import('../scripts/build.mjs');
  await build();
  const { createMesher } = await import(path.join(DIST, 'node.js'));
  const facets = writeWave(file, 142);
  const mesher = await createMesher({ backend: 'cpu' });
  const source = await mesher.read(readFileSync(file));
  const placed = (/** @type {number} */ index) => [
    0.5 + (index % 3),
    0.5 + (Math.floor(index / 3) % 2),
    0.5 + Math.floor(index / 6),
  ];
  const rows = [];
  for (const n of sizes) {
    const geometries = Array.from({ length: 10 }, (_, index) => ({
      source,
      scale: 0.4,
      translate: placed(index),
      flag: 1 + index,
    }));
    const job = { geometries, domain: [0, 0, 0, 3, 3, 3], dims: [n, n, n] };
    const seconds = async (/** @type {() => Promise<unknown>} */ work) => {
      const start = performance.now();
      await work();
      return (performance.now() - start) / 1000;
    };
    const wholes = [];
    for (let run = 0; run <= runs; run += 1) wholes.push(await seconds(async () => (await mesher.mesh(job)).dispose()));
    const scene = await mesher.scene(job);
    const updates = [];
    let [rays, changed] = [0, 0];
    for (let step = 0; step <= runs; step += 1) {
      const by = (step + 1) / n;
      geometries[0].translate = [0.5 + by, 0.5 + 0.5 * by, 0.5 + 0.25 * by];
      updates.push(
        await seconds(async () => {
          const update = await scene.update(job);
          [rays, changed] = [update.rays, update.changed?.rays.length ?? 0];
        }),
      );
    }
    scene.dispose();
    const [first, ...others] = updates;
    const model = `${n} cells, ${facets.toLocaleString('en')} of ${(10 * facets).toLocaleString('en')} facets`;
    rows.push([model, ms(median(others)), ms(first), ms(median(wholes.slice(1))), rays, changed]);
  }
  mesher.dispose();
  return rows;
}

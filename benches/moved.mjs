// Times a body that moves in a scene, beside a mesh of the whole, for bench.mjs.

import { jsonLines, ms, output, table } from './results.mjs';

/** Measures ten spheres of which one moves. @param {import('./bench.mjs').Bench} bench */
export function benchMoved({ stages, runs, sizes, quick }) {
  const rows = (quick ? [256] : [256, ...sizes]).map((n) => {
    const [printed] = jsonLines(output(stages, ['--moved', '--cells', String(n), '--runs', runs]));
    const { facets, moved_facets, rays, changed_runs, update_s, first_s, whole_s } = printed;
    const model = `${n} cells, ${moved_facets.toLocaleString('en')} of ${facets.toLocaleString('en')} facets`;
    return [model, ms(update_s), ms(first_s), ms(whole_s), rays, changed_runs];
  });
  const head = ['model', 'update, ms', 'the first update, ms', 'the whole, ms', 'rays made again', 'runs that changed'];
  return { adapter: '', text: `## A body that moves in a scene, CPU\n\n${table(head, rows)}` };
}

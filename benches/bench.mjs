// Measures hexcast and other programs on the same files, in turn, and writes the tables of RESULTS.md.
// usage: npm run bench -- [native | peers | solvers | facets | moved | page | big] [--quick] [--rounds R] [--runs K] [--largest N]
// "solvers" solves problems with known answers by hexcast and openEMS, gprMax, Meep and snappyHexMesh, with what HEXCAST_COMMAND names or a new build; it takes some ten minutes.
// "facets" times surfaces of many facets, and says which became slower. "moved" times a body that moves in a scene. "big" opens a model of 2e7 facets on the page. By default "native" and "peers": all stages compared with VTK, then every program of peers.py. "page" measures the page in Chromium
// and the command on the same driver. Needs cargo, and python3 with venv for the peers; takes some ten minutes.

import { mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { parseArgs } from 'node:util';

import { ensureNodeModules } from '../scripts/machine.mjs';
import { benchFacets } from './facets.mjs';
import { benchMoved } from './moved.mjs';
import { benchNative } from './native.mjs';
import { benchPeers } from './peers.mjs';
import { build, machine, programs, write } from './results.mjs';
import { benchSolvers } from './solvers.mjs';

/**
 * What every bench gets: the programs, how often they run, and the numbers of cells along the longest axis.
 *
 * @typedef {ReturnType<typeof programs> & { rounds: number, runs: string, quick: boolean, sizes: number[], largest?: string }} Bench
 * @typedef {{ adapter: string, text: string }} Measured the name of the GPU, and the tables
 */

/** @type {Record<string, (bench: Bench) => Measured | Promise<Measured>>} */
const BENCHES = {
  native: benchNative,
  peers: benchPeers,
  solvers: benchSolvers,
  facets: benchFacets,
  moved: benchMoved,
  page: async (bench) => (await inBrowser('page')).benchPage(bench),
  big: async (bench) => (await inBrowser('big')).benchBig(bench),
};

/**
 * What runs in a browser is loaded late: it needs the Node packages, which a clean clone lacks.
 *
 * @template {'page' | 'big'} Name
 * @param {Name} name
 * @returns {Promise<{ page: typeof import('./page.mjs'), big: typeof import('./big.mjs') }[Name]>}
 */
async function inBrowser(name) {
  await ensureNodeModules();
  return import(`./${name}.mjs`);
}

const { values, positionals } = parseArgs({
  allowPositionals: true,
  options: {
    quick: { type: 'boolean', default: false },
    rounds: { type: 'string', default: '2' },
    runs: { type: 'string', default: '3' },
    largest: { type: 'string' },
  },
});
const names = positionals.length > 0 ? positionals : ['native', 'peers'];
const unknown = names.find((name) => !(name in BENCHES));
if (unknown) throw new Error(`no bench is named ${unknown}: ${Object.keys(BENCHES).join(', ')}`);
const folder = mkdtempSync(path.join(tmpdir(), 'hexcast-bench-'));
process.on('exit', () => rmSync(folder, { recursive: true }));
const command = names.includes('facets') ? build(['bin', 'hexcast']) : '';
const built = names.some((name) => !['big', 'facets', 'solvers'].includes(name))
  ? programs(folder)
  : { stages: '', command, spheres: '', folder };
const bench = { ...built, ...values, rounds: Number(values.rounds), sizes: values.quick ? [256] : [512, 1024] };
for (const name of names) {
  const { adapter, text } = await BENCHES[name](bench);
  const inOrder = `* ${bench.runs} runs after a first that does not count; medians of wall time.`;
  /** @type {Record<string, string>} */
  const alone = {
    big: '* One run.',
    solvers: '* One run; processor time.',
    facets: inOrder,
    moved: inOrder,
  };
  const inTurn = `* ${bench.rounds} rounds, programs in turn; ${bench.runs} runs a program and round after a first that does not count; medians.`;
  const rounds = alone[name] ?? inTurn;
  write(name, [...machine(adapter), rounds, text].join('\n'));
}

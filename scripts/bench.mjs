// Times hexcast and VTK on the same files in the same run, in turn, and writes the tables of benches/RESULTS.md.
// usage: node scripts/bench.mjs [--quick] [--rounds R] [--runs K]
// Needs cargo, and python3 with venv for the peers; makes .tools/peers on first use. Takes some minutes.

import { execFileSync } from 'node:child_process';
import { existsSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { cpus, loadavg, release, tmpdir, totalmem } from 'node:os';
import { join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { parseArgs } from 'node:util';

const root = fileURLToPath(new URL('..', import.meta.url));
const results = join(root, 'benches/RESULTS.md');
const { values: options } = parseArgs({
  options: {
    quick: { type: 'boolean', default: false },
    rounds: { type: 'string', default: '2' },
    runs: { type: 'string', default: '3' },
  },
});
const sizes = options.quick ? [256] : [512, 1024];
const rounds = Number(options.rounds);

const run = (program, args) =>
  execFileSync(program, args, { cwd: root, encoding: 'utf8', maxBuffer: 1 << 28, stdio: ['ignore', 'pipe', 'inherit'] });
const jsonLines = (text) => text.split('\n').filter((line) => line.startsWith('{')).map((line) => JSON.parse(line));
const median = (numbers) => [...numbers].sort((a, b) => a - b)[numbers.length >> 1];

/** Builds the bench and returns the path of its program. */
function buildBench() {
  const messages = jsonLines(run('cargo', ['bench', '--bench', 'table', '--no-run', '--message-format=json']));
  const bench = messages.find((message) => message.executable && message.target?.name === 'table');
  return bench.executable;
}

/** Makes the virtual environment of the peers and returns its python. */
function peersPython() {
  const folder = join(root, '.tools/peers');
  const windows = process.platform === 'win32';
  const python = join(folder, windows ? 'Scripts/python.exe' : 'bin/python');
  if (!existsSync(python)) run(windows ? 'python' : 'python3', ['-m', 'venv', folder]);
  try {
    execFileSync(python, ['-c', 'import numpy, vtk'], { stdio: 'ignore' });
  } catch {
    run(python, ['-m', 'pip', 'install', '--quiet', 'numpy', 'vtk']);
  }
  return python;
}

/** Times VTK and both backends in turn; seconds from file to flags in memory of every warm run. */
function race(programs, file, n) {
  const seconds = { vtk: [], cpu: [], gpu: [] };
  const last = {};
  for (let round = 0; round < rounds; round++) {
    const args = ['benches/peers.py', file, String(n), 'vtk', '--runs', options.runs];
    [last.vtk] = jsonLines(run(programs.python, args));
    if (last.vtk.error) throw new Error(`VTK failed: ${last.vtk.error}`);
    seconds.vtk.push(...last.vtk.runs_s);
    for (const backend of ['cpu', 'gpu']) {
      const args = ['--file', file, '--cells', String(n), '--backends', backend, '--runs', options.runs];
      [last[backend]] = jsonLines(run(programs.bench, args));
      seconds[backend].push(...last[backend].runs.map((s) => s.read + s.lines + s.snap + s.columns + s.flags));
    }
  }
  return { n, seconds, last, load: loadavg()[0] };
}

/** Counts the cells in which VTK and hexcast differ. */
function differences(programs, file, n, scratch) {
  const prefix = join(scratch, 'flags');
  run(programs.python, ['benches/peers.py', file, String(n), 'vtk', '--flags', prefix]);
  run(programs.bench, ['--file', file, '--cells', String(n), '--backends', 'cpu', '--runs', '0', '--flags', `${prefix}.ours`]);
  const [vtk, ours] = [`${prefix}.vtk.u8`, `${prefix}.ours`].map((path) => readFileSync(path));
  if (vtk.length !== ours.length) throw new Error(`${vtk.length} cells by VTK, ${ours.length} by hexcast`);
  let n_differing = 0;
  for (let cell = 0; cell < vtk.length; cell++) n_differing += vtk[cell] !== ours[cell];
  return { n, n_cells: vtk.length, n_differing };
}

const ms = (seconds) => (1000 * seconds).toFixed(seconds < 0.01 ? 2 : seconds < 0.1 ? 1 : 0);
const table = (head, rows) =>
  [head, head.map((_, column) => (column ? '---:' : '---')), ...rows].map((row) => `| ${row.join(' | ')} |`).join('\n');

function raceTable({ n, seconds, last }) {
  const vtk = median(seconds.vtk);
  const row = (name, all, run) => {
    const middle = median(all);
    const columns = run.to_columns_s ? ms(run.to_columns_s) : '';
    const again = run.to_flags_again_s ? ms(run.to_flags_again_s) : '';
    const vec = run.to_flags_in_vec_s ? ms(run.to_flags_in_vec_s) : '';
    const spread = `${ms(Math.min(...all))} - ${ms(Math.max(...all))}`;
    return [name, columns, ms(middle), spread, again, vec, (n ** 3 / middle / 1e9).toFixed(2), `${(vtk / middle).toFixed(1)}x`];
  };
  return table(
    [`${n}^3`, 'columns, ms', 'flags, ms', 'from - to', 'flags again, ms', 'flags in Vec, ms', '1e9 cells/s', 'against VTK'],
    [
      row('VTK', seconds.vtk, last.vtk),
      row('hexcast, CPU', seconds.cpu, last.cpu),
      row(`hexcast, GPU (${last.gpu.adapter.split(' (')[0]})`, seconds.gpu, last.gpu),
    ],
  );
}

function stageTable({ n, last }) {
  const stages = ['read', 'lines', 'snap', 'columns', 'flags', 'flags_again', 'flags_in_vec', 'bytes_once'];
  const row = (name, run) => [name, ...stages.map((stage) => ms(run[`${stage}_s`])), (run.crossings_per_s / 1e6).toFixed(1)];
  return table([`${n}^3, ms`, ...stages.map((stage) => stage.replaceAll('_', ' ')), '1e6 crossings/s'], [row('CPU', last.cpu), row('GPU', last.gpu)]);
}

function passTable(name, passes, isWhole = () => false) {
  const total = passes.filter(([pass]) => !isWhole(pass)).reduce((sum, [, seconds]) => sum + seconds, 0);
  const share = (pass, seconds) => (isWhole(pass) ? '' : `${((100 * seconds) / total).toFixed(1)} %`);
  return table([name, 'ms', 'share'], passes.map(([pass, seconds]) => [pass, ms(seconds), share(pass, seconds)]));
}

function gatherLine({ n, naive_gather: g }) {
  return [`${n}^3`, g.n_pairs, g.n_crossings, ms(g.naive_s), ms(g.ours_s), `${(g.naive_s / g.ours_s).toFixed(1)}x`];
}

/** Machine facts, as far as the system tells them. */
function machine(adapter, load) {
  const cores = cpus();
  const memory = (totalmem() / 2 ** 30).toFixed(0);
  return [
    `* Processor: ${cores[0].model.trim()}, ${cores.length} cores; ${memory} GiB of memory; ${process.platform} ${release()}.`,
    `* GPU backend on: ${adapter}.`,
    `* Date: ${new Date().toISOString().slice(0, 10)}. Load before the run: ${load.toFixed(2)}.`,
    `* ${rounds} rounds, programs in turn; ${options.runs} runs a program and round after a first that does not count; medians. Of passes, the run that was disturbed least.`,
    '',
  ].join('\n');
}

/** Replaces what stands between the marks of RESULTS.md. */
function write(text) {
  const marks = ['<!-- measured -->', '<!-- /measured -->'];
  const [before, rest] = readFileSync(results, 'utf8').split(marks[0]);
  const after = rest.split(marks[1])[1];
  writeFileSync(results, `${before}${marks[0]}\n${text}\n${marks[1]}${after}`);
}

const load = loadavg()[0];
const scratch = mkdtempSync(join(tmpdir(), 'hexcast-bench-'));
try {
  const programs = { bench: buildBench(), python: peersPython() };
  const spheres = join(scratch, 'spheres.stl');
  run(programs.bench, ['--spheres', spheres]);
  const spot = join(root, 'tests/fixtures/spot.stl');
  const races = sizes.map((n) => race(programs, spheres, n));
  const passes = sizes.map((n) => jsonLines(run(programs.bench, ['--file', spheres, '--cells', String(n), '--backends', 'cpu', '--runs', '5', '--passes']))[1]);
  const compared = [['64 spheres', spheres], ['spot', spot]].flatMap(([name, file]) =>
    [128, 256].map((n) => [name, differences(programs, file, n, scratch)]),
  );
  const whole = (pass) => pass.startsWith('all');
  const text = [
    machine(races[0].last.gpu.adapter, load),
    '## From file to flags in memory, 64 spheres\n',
    races.map(raceTable).join('\n\n'),
    '\n### Stage by stage\n',
    races.map(stageTable).join('\n\n'),
    '\n### Columns, pass by pass\n',
    passes.flatMap((p) => [passTable(`GPU, ${p.n}^3`, p.gpu_passes), passTable(`CPU, ${p.n}^3`, p.cpu_passes, whole)]).join('\n\n'),
    '\n## The paper\'s gather beside our intersection\n',
    table(['GPU', '(facet, bin) pairs', 'crossings', 'gather, ms', 'ours, ms', 'gather / ours'], passes.map(gatherLine)),
    '\n## Cells that differ from VTK\'s\n',
    table(['model', 'cells', 'differing'], compared.map(([name, d]) => [`${name}, ${d.n}`, d.n_cells, d.n_differing])),
  ].join('\n');
  write(text);
  console.log(text);
} finally {
  rmSync(scratch, { recursive: true });
}

// How much a pass of the columns reads, writes or tests at least, and what the machine could do at most.

/**
 * @typedef {'scan' | 'clear' | 'hits'} Limit
 * @typedef {Record<'n_bands' | 'n_facets' | 'n_bins' | 'n_pairs' | 'n_cpu_pairs' | 'n_crossings' | 'n_rays' | 'n_runs', number>} Counts
 */

/**
 * Limits of two cores of an AMD EPYC, each measured by a loop that does nothing else; both backends share these cores.
 * scan: an XOR scan in place, 36e9 at best; clear: `clear_buffer` of lavapipe; hits: tests of a ray and a facet in exact 64-bit integers.
 *
 * @type {Record<Limit, [number, string]>}
 */
const LIMITS = { scan: [36e9, 'B'], clear: [10e9, 'B'], hits: [783e6, 'hits'] };

/**
 * What a pass moves, from the formulas at the head of its kernel: every array that it reads or writes counts once, caches are
 * perfect. Facets (48 bytes) are read by each band. Keys are the names of `passTable`.
 *
 * @type {Record<string, (counts: Counts) => [Limit, number]>}
 */
const WORK = {
  Lattice: ({ n_bands, n_facets, n_bins, n_pairs }) => ['scan', n_bands * n_facets * 52 + 4 * n_bins + 16 * n_pairs],
  Intersect: ({ n_pairs }) => ['hits', 64 * n_pairs],
  Map: ({ n_crossings }) => ['hits', n_crossings],
  MapOneLayer: ({ n_crossings }) => ['hits', n_crossings],
  MapSimple: ({ n_crossings }) => ['hits', n_crossings],
  ScanReduce: ({ n_bands, n_facets, n_bins }) => ['scan', 4 * (n_bands * n_facets + n_bins)],
  ScanApply: ({ n_bands, n_facets, n_bins }) => ['scan', 8 * (n_bands * n_facets + n_bins)],
  // upload: facets once; clears: offsets; readback: runs and chunks, which are read once more to put them in order
  'upload, clears, readback': ({ n_bands, n_facets, n_bins, n_runs }) => [
    'clear',
    48 * n_facets + 4 * (n_bands * n_facets + n_bins) + 2 * (4 * n_runs + 64 * n_bins),
  ],
  lattice: ({ n_facets, n_cpu_pairs }) => ['scan', 36 * n_facets + 20 * n_cpu_pairs],
  crossings: ({ n_crossings }) => ['hits', n_crossings],
  map: ({ n_crossings, n_rays, n_runs }) => ['scan', 4 * (n_crossings + n_rays) + 4 * (n_runs + n_rays)],
};

/** The head of the columns that `limitCells` fills. */
export const LIMIT_HEAD = ['work', 'rate', 'limit', 'of it', 'in this run', 'of that'];

/**
 * Work, rate, limit and share of the limit of a pass, as text; empty where no limit means anything. `machine` has what the same
 * process has reached of each limit, from `benches/table/machine.rs`.
 *
 * @param {string} pass
 * @param {number} seconds
 * @param {Counts} counts
 * @param {Record<Limit, number>} machine
 */
export function limitCells(pass, seconds, counts, machine) {
  if (!(pass in WORK)) return LIMIT_HEAD.map(() => '');
  const [name, n] = WORK[pass](counts);
  const [limit, unit] = LIMITS[name];
  const rate = n / seconds;
  const share = (/** @type {number} */ most) => [`${scaled(most)}${unit}/s`, `${((100 * rate) / most).toFixed(0)} %`];
  const [most, ofMost] = share(limit);
  return [`${scaled(n)}${unit}`, `${scaled(rate)}${unit}/s`, `${name}, ${most}`, ofMost, ...share(machine[name])];
}

/** @param {number} number */
function scaled(number) {
  const [size, prefix] = number >= 1e9 ? [1e9, 'G'] : number >= 1e6 ? [1e6, 'M'] : [1e3, 'k'];
  return `${(number / size).toPrecision(3)} ${prefix}`;
}

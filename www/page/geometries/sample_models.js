/** The models of the samples, made here: they are not downloaded and need no licence. */
import { cross, minus, plus, unit } from '../view/vectors.js';

/**
 * A closed surface: three numbers a corner, and three corners a facet, counter-clockwise seen from outside.
 *
 * @typedef {{ corners: number[][], facets: number[][] }} Surface
 * @typedef {{ file: string, surface: Surface, priority?: number }} Model
 */

/** @type {Record<string, () => Model[]>} */
const MODELS = {
  knot: () => [{ file: 'knot.stl', surface: knot(10, 2.2, [240, 28], [2, 3]) }],
  cubes: () => [
    { file: 'copper.stl', surface: box([0, 0, 0], [10, 10, 10]) },
    { file: 'epoxy.stl', surface: box([10, 0, 0], [20, 10, 5]) },
  ],
  gear: () => [{ file: 'gear.stl', surface: gear() }],
  shells: () => [
    { file: 'coating.stl', surface: sphere(10, [64, 32]) },
    { file: 'core.stl', surface: sphere(6.5, [64, 32]), priority: 1 },
  ],
};

/** Files of a sample, with the settings of their geometries. @param {string} id */
export function sampleFiles(id) {
  return (MODELS[id]?.() ?? []).map(({ file, surface, ...settings }) => ({
    source: new File([stl(surface)], file, { type: 'model/stl' }),
    settings,
  }));
}

/** Binary STL: 80 bytes, the number of facets, and of each a normal and three corners. @param {Surface} surface */
function stl({ corners, facets }) {
  const bytes = new DataView(new ArrayBuffer(84 + 50 * facets.length));
  bytes.setUint32(80, facets.length, true);
  for (const [index, facet] of facets.entries()) {
    const [a, b, c] = facet.map((corner) => corners[corner]);
    const normal = unit(cross(minus(b, a), minus(c, a)));
    for (const [at, number] of [normal, a, b, c].flat().entries()) bytes.setFloat32(84 + 50 * index + 4 * at, number, true);
  }
  return bytes;
}

/** @param {number[]} low @param {number[]} high @returns {Surface} */
function box(low, high) {
  // bit 0 of a corner is that of x
  const corners = Array.from({ length: 8 }, (_, corner) => low.map((at, axis) => ((corner >> axis) & 1 ? high[axis] : at)));
  const sides = [
    [0, 4, 6, 2],
    [1, 3, 7, 5],
    [0, 1, 5, 4],
    [2, 6, 7, 3],
    [0, 2, 3, 1],
    [4, 5, 7, 6],
  ];
  return { corners, facets: sides.flatMap(([a, b, c, d]) => triangles(a, b, c, d)) };
}

/** A sphere by rings of `n[0]` corners, of which there are `n[1]` - 1 between the poles on y. @param {number} radius @param {number[]} n @returns {Surface} */
function sphere(radius, [around, down]) {
  const rings = range(down - 1, (ring) => {
    const angle = (Math.PI * (ring + 1)) / down;
    return range(around, (at) => {
      const turn = (2 * Math.PI * at) / around;
      return [-radius * Math.sin(angle) * Math.cos(turn), radius * Math.cos(angle), radius * Math.sin(angle) * Math.sin(turn)];
    });
  });
  const corners = [...rings.flat(), [0, radius, 0], [0, -radius, 0]];
  const [top, bottom] = [corners.length - 2, corners.length - 1];
  const at = (/** @type {number} */ ring, /** @type {number} */ turn) => ring * around + (turn % around);
  const sides = range(down - 2, (ring) =>
    range(around, (turn) => triangles(at(ring, turn), at(ring + 1, turn), at(ring + 1, turn + 1), at(ring, turn + 1))),
  );
  const caps = range(around, (turn) => [
    [top, at(0, turn), at(0, turn + 1)],
    [bottom, at(down - 2, turn + 1), at(down - 2, turn)],
  ]);
  return { corners, facets: [...sides.flat(2), ...caps.flat()] };
}

/**
 * A tube around a curve that winds `p` times around z and `q` times around a circle.
 *
 * @param {number} radius @param {number} tube @param {number[]} n corners along the curve and around the tube
 * @param {number[]} turns @returns {Surface}
 */
function knot(radius, tube, [along, around], [p, q]) {
  const curve = (/** @type {number} */ u) => {
    const out = radius * (2 + Math.cos((q / p) * u)) * 0.5;
    return [out * Math.cos(u), out * Math.sin(u), radius * Math.sin((q / p) * u) * 0.5];
  };
  const rings = range(along, (i) => {
    const u = (i / along) * p * Math.PI * 2;
    const [here, next] = [curve(u), curve(u + 0.01)];
    const way = minus(next, here);
    const side = cross(way, plus(next, here));
    const [b, n] = [unit(side), unit(cross(side, way))];
    return range(around, (j) => {
      const angle = (j / around) * Math.PI * 2;
      const [across, up] = [-tube * Math.cos(angle), tube * Math.sin(angle)];
      return here.map((number, axis) => number + (across * n[axis] + up * b[axis]));
    });
  });
  const at = (/** @type {number} */ i, /** @type {number} */ j) => (i % along) * around + (j % around);
  const facets = range(along, (i) => range(around, (j) => triangles(at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1))));
  return { corners: rings.flat(), facets: facets.flat(2) };
}

/** A spur gear with 18 teeth and a bore. @returns {Surface} */
function gear() {
  const n_teeth = 18;
  const [bore, root, tip, height] = [5, 16, 20, 7];
  const tooth = [
    [0, root],
    [0.22, root],
    [0.34, tip],
    [0.66, tip],
    [0.78, root],
  ];
  const outer = range(n_teeth, (at) => tooth.map(([share, radius]) => ({ turn: (at + share) / n_teeth, radius }))).flat();
  const inner = range(72, (at) => ({ turn: at / 72, radius: bore }));
  const levels = [0, height].map((z) =>
    [...outer, ...inner].map(({ turn, radius }) => [
      radius * Math.cos(2 * Math.PI * turn),
      radius * Math.sin(2 * Math.PI * turn),
      z,
    ]),
  );
  const [n, m, above] = [outer.length, inner.length, levels[0].length];
  const out = (/** @type {number} */ at) => at % n;
  const within = (/** @type {number} */ at) => n + (at % m);
  const walls = [
    ...range(n, (at) => triangles(out(at), out(at + 1), above + out(at + 1), above + out(at))),
    ...range(m, (at) => triangles(within(at + 1), within(at), above + within(at), above + within(at + 1))),
  ].flat();
  // both rings turn together: whichever is behind goes on
  const cap = [];
  for (let i = 0, j = 0; i < n || j < m; ) {
    const isOuter = j === m || (i < n && (outer[i + 1]?.turn ?? 1) <= (inner[j + 1]?.turn ?? 1));
    cap.push(isOuter ? [out(i), out(i + 1), within(j)] : [out(i), within(j + 1), within(j)]);
    if (isOuter) i += 1;
    else j += 1;
  }
  const top = cap.map((facet) => facet.map((corner) => above + corner));
  return { corners: levels.flat(), facets: [...walls, ...cap.map(([a, b, c]) => [a, c, b]), ...top] };
}

/** Two facets of four corners. @param {number} a @param {number} b @param {number} c @param {number} d */
const triangles = (a, b, c, d) => [
  [a, b, d],
  [b, c, d],
];

/** @template T @param {number} n @param {(at: number) => T} make @returns {T[]} */
const range = (n, make) => Array.from({ length: n }, (_, at) => make(at));

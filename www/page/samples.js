/** Models to try, made here as binary STL: nothing is downloaded, nobody's licence applies. */

const TAU = 2 * Math.PI;

/**
 * One entry a sample: id, title, and the files that `make` gives.
 *
 * @type {{ id: string, title: string, make: () => { file: string, triangles: number[], priority?: number }[] }[]}
 */
export const SAMPLES = [
  { id: 'knot', title: 'Torus knot', make: () => [{ file: 'knot.stl', triangles: knot() }] },
  {
    id: 'cubes',
    title: 'Two touching blocks',
    make: () => [
      { file: 'copper.stl', triangles: block([0, 0, 0], [10, 10, 10]) },
      { file: 'epoxy.stl', triangles: block([10, 0, 0], [20, 10, 5]) },
    ],
  },
  { id: 'gear', title: 'Gear', make: () => [{ file: 'gear.stl', triangles: gear() }] },
  {
    id: 'shells',
    title: 'Coated core',
    make: () => [
      { file: 'coating.stl', triangles: sphere(10) },
      { file: 'core.stl', triangles: sphere(6.5), priority: 1 },
    ],
  },
];

/** Files of a sample, each with `name` and, where it matters, `settings`. @param {string} id */
export function sampleFiles(id) {
  const sample = SAMPLES.find((sample) => sample.id === id);
  return (sample?.make() ?? []).map(({ file, triangles, ...settings }) => ({
    source: new File([stl(triangles)], file, { type: 'model/stl' }),
    settings,
  }));
}

/** Binary STL of triangles, 9 numbers each. @param {number[]} triangles */
export function stl(triangles) {
  const n_facets = triangles.length / 9;
  const view = new DataView(new ArrayBuffer(84 + 50 * n_facets));
  [...'hexcast sample'].forEach((letter, at) => view.setUint8(at, letter.charCodeAt(0)));
  view.setUint32(80, n_facets, true);
  for (let facet = 0; facet < n_facets; facet += 1) {
    // normals stay zero: readers that need them compute them from the corners
    for (let number = 0; number < 9; number += 1) {
      view.setFloat32(84 + 50 * facet + 12 + 4 * number, triangles[9 * facet + number], true);
    }
  }
  return view.buffer;
}

/**
 * Triangles between the points of a grid that is closed in both directions.
 *
 * @param {number} n_u
 * @param {number} n_v
 * @param {(u: number, v: number) => number[]} point
 */
function torusOf(n_u, n_v, point) {
  /** @type {number[]} */
  const triangles = [];
  const grid = Array.from({ length: n_u }, (_, u) =>
    Array.from({ length: n_v }, (_, v) => point((TAU * u) / n_u, (TAU * v) / n_v)),
  );
  for (let u = 0; u < n_u; u += 1) {
    for (let v = 0; v < n_v; v += 1) {
      const [a, b] = [grid[u][v], grid[(u + 1) % n_u][v]];
      const [c, d] = [grid[(u + 1) % n_u][(v + 1) % n_v], grid[u][(v + 1) % n_v]];
      triangles.push(...a, ...b, ...c, ...a, ...c, ...d);
    }
  }
  return triangles;
}

/** A (2, 3) torus knot with a round tube. */
function knot() {
  const centre = (/** @type {number} */ t) => {
    const ring = 10 + 4 * Math.cos(3 * t);
    return [ring * Math.cos(2 * t), ring * Math.sin(2 * t), 5 * Math.sin(3 * t)];
  };
  return torusOf(240, 28, (t, angle) => {
    const [here, ahead] = [centre(t), centre(t + 1e-3)];
    const tangent = unit(ahead.map((x, k) => x - here[k]));
    // the direction away from the z axis, made square to the tube
    const out = unit([here[0], here[1], 0]);
    const along = dot(out, tangent);
    const side = unit(out.map((x, k) => x - along * tangent[k]));
    const up = cross(tangent, side);
    const [c, s] = [2.2 * Math.cos(angle), -2.2 * Math.sin(angle)];
    return here.map((x, k) => x + c * side[k] + s * up[k]);
  });
}

/** @param {number[]} low @param {number[]} high */
function block([x0, y0, z0], [x1, y1, z1]) {
  const corner = (/** @type {number} */ bits) => [bits & 1 ? x1 : x0, bits & 2 ? y1 : y0, bits & 4 ? z1 : z0];
  const faces = [
    [0, 2, 3, 1],
    [4, 5, 7, 6],
    [0, 1, 5, 4],
    [2, 6, 7, 3],
    [0, 4, 6, 2],
    [1, 3, 7, 5],
  ];
  return faces.flatMap(([a, b, c, d]) => [a, b, c, a, c, d].flatMap(corner));
}

/** A spur gear with 18 teeth and a bore. */
function gear() {
  const n_teeth = 18;
  const [bore, root, tip, height] = [5, 16, 20, 7];
  const outline = [];
  for (let tooth = 0; tooth < n_teeth; tooth += 1) {
    for (const [part, radius] of [
      [0, root],
      [0.22, root],
      [0.34, tip],
      [0.66, tip],
      [0.78, root],
    ]) {
      outline.push([(TAU * (tooth + part)) / n_teeth, radius]);
    }
  }
  // profile round the section: bore below, rim below, rim above, bore above
  const ring = outline.map(([angle, radius]) =>
    [
      [bore, 0],
      [radius, 0],
      [radius, height],
      [bore, height],
    ].map(([r, z]) => [r * Math.cos(angle), r * Math.sin(angle), z]),
  );
  /** @type {number[]} */
  const triangles = [];
  ring.forEach((here, at) => {
    const next = ring[(at + 1) % ring.length];
    for (let k = 0; k < 4; k += 1) {
      const [a, b, c, d] = [here[k], next[k], next[(k + 1) % 4], here[(k + 1) % 4]];
      triangles.push(...a, ...b, ...c, ...a, ...c, ...d);
    }
  });
  return triangles;
}

/** @param {number} radius */
function sphere(radius) {
  const [n_around, n_down] = [64, 32];
  const point = (/** @type {number} */ i, /** @type {number} */ j) => {
    if (j === 0 || j === n_down) return [0, 0, j === 0 ? radius : -radius];
    const [around, down] = [(TAU * (i % n_around)) / n_around, (Math.PI * j) / n_down];
    return [radius * Math.sin(down) * Math.cos(around), radius * Math.sin(down) * Math.sin(around), radius * Math.cos(down)];
  };
  /** @type {number[]} */
  const triangles = [];
  for (let i = 0; i < n_around; i += 1) {
    for (let j = 0; j < n_down; j += 1) {
      const [a, b, c, d] = [point(i, j), point(i, j + 1), point(i + 1, j + 1), point(i + 1, j)];
      if (j < n_down - 1) triangles.push(...a, ...b, ...c);
      if (j > 0) triangles.push(...a, ...c, ...d);
    }
  }
  return triangles;
}

/** @param {number[]} a @param {number[]} b */
function dot(a, b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/** @param {number[]} a @param {number[]} b */
function cross(a, b) {
  return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
}

/** @param {number[]} a */
function unit(a) {
  const length = Math.hypot(...a);
  return a.map((x) => x / length);
}

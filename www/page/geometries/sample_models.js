/** The models of the samples, made by three.js: they are not downloaded and need no licence. */
import { BoxGeometry, ExtrudeGeometry, Mesh, Path, Shape, SphereGeometry, TorusKnotGeometry, Vector2 } from 'three';
import { STLExporter } from 'three/addons/exporters/STLExporter.js';
import { mergeVertices } from 'three/addons/utils/BufferGeometryUtils.js';

/** @typedef {{ file: string, geometry: import('three').BufferGeometry, priority?: number }} Model */

/** @type {Record<string, () => Model[]>} */
const MODELS = {
  knot: () => [{ file: 'knot.stl', geometry: new TorusKnotGeometry(10, 2.2, 240, 28, 2, 3) }],
  cubes: () => [
    { file: 'copper.stl', geometry: new BoxGeometry(10, 10, 10).translate(5, 5, 5) },
    { file: 'epoxy.stl', geometry: new BoxGeometry(10, 10, 5).translate(15, 5, 2.5) },
  ],
  gear: () => [{ file: 'gear.stl', geometry: gear() }],
  shells: () => [
    { file: 'coating.stl', geometry: new SphereGeometry(10, 64, 32) },
    { file: 'core.stl', geometry: new SphereGeometry(6.5, 64, 32), priority: 1 },
  ],
};

/** Files of a sample, with the settings of their geometries. @param {string} id */
export function sampleFiles(id) {
  return (MODELS[id]?.() ?? []).map(({ file, geometry, ...settings }) => ({
    source: new File([stl(geometry)], file, { type: 'model/stl' }),
    settings,
  }));
}

/** Binary STL of a closed surface. @param {import('three').BufferGeometry} geometry */
function stl(geometry) {
  // corners that differ in their normals or by rounding become one: every edge has two facets
  for (const name of ['normal', 'uv']) geometry.deleteAttribute(name);
  return /** @type {DataView<ArrayBuffer>} */ (new STLExporter().parse(new Mesh(mergeVertices(geometry)), { binary: true }));
}

/** A spur gear with 18 teeth and a bore. */
function gear() {
  const n_teeth = 18;
  const [bore, root, tip, height] = [5, 16, 20, 7];
  const points = Array.from({ length: n_teeth }, (_, tooth) =>
    [root, root, tip, tip, root].map((radius, at) => {
      const angle = (2 * Math.PI * (tooth + [0, 0.22, 0.34, 0.66, 0.78][at])) / n_teeth;
      return new Vector2(radius * Math.cos(angle), radius * Math.sin(angle));
    }),
  );
  const outline = new Shape(points.flat());
  outline.holes.push(new Path().absarc(0, 0, bore, 0, 2 * Math.PI));
  return new ExtrudeGeometry(outline, { depth: height, bevelEnabled: false, curveSegments: 36 });
}

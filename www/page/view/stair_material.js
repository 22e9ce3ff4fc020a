/** The material of stair-step surfaces: faces flat, back faces darker, mesh lines where cells are large enough to see. */
import * as THREE from 'three';

import { placeAt } from '../text/places.js';

/** Lines in a row of the texture that holds them: every device has textures as wide. */
const ROW = 2048;

/**
 * Where the lines of drawn cells are, in lengths from the first: their spacing, or a texture of each axis with all of them.
 *
 * @typedef {{ spacing: THREE.Vector3 } | { lists: THREE.DataTexture[], ends: THREE.Vector3 }} CellLines
 */

/**
 * The lines of the cells that are drawn, each of which has so many cells of the mesh along an edge.
 *
 * @param {import('../text/places.js').Lines} lines
 * @param {number} step
 * @returns {CellLines}
 */
export function linesOfCells(lines, step) {
  const { spacing, origin, dims } = lines;
  if (spacing) return { spacing: new THREE.Vector3().fromArray(spacing.map((size) => size * step)) };
  const n_cells = dims.map((n) => Math.ceil(n / step));
  const lists = n_cells.map((n, axis) => {
    const rows = Math.ceil((n + 1) / ROW);
    const places = new Float32Array(rows * ROW);
    for (let line = 0; line <= n; line += 1) places[line] = placeAt(lines, axis, line * step) - origin[axis];
    const texture = new THREE.DataTexture(places, ROW, rows, THREE.RedFormat, THREE.FloatType);
    texture.needsUpdate = true;
    return texture;
  });
  return { lists, ends: new THREE.Vector3().fromArray(n_cells) };
}

/**
 * Makes a material for faces that lie on mesh lines.
 *
 * @param {string} colour
 * @param {CellLines} lines
 */
export function stairMaterial(colour, lines) {
  const material = new THREE.MeshStandardMaterial({ color: colour, flatShading: true, side: THREE.DoubleSide, roughness: 0.75 });
  // three compiles the two kinds of lines apart
  material.customProgramCacheKey = () => ('spacing' in lines ? 'equal' : 'unequal');
  if ('lists' in lines) material.addEventListener('dispose', () => lines.lists.forEach((list) => list.dispose()));
  material.onBeforeCompile = (shader) => {
    if ('spacing' in lines) shader.uniforms.cellSize = { value: lines.spacing };
    else {
      shader.uniforms.ends = { value: lines.ends };
      for (const [axis, list] of lines.lists.entries()) shader.uniforms[`lines${'XYZ'[axis]}`] = { value: list };
    }
    shader.vertexShader = shader.vertexShader
      .replace('#include <common>', '#include <common>\nvarying vec3 vPlace;')
      .replace('#include <begin_vertex>', '#include <begin_vertex>\nvPlace = position;');
    shader.fragmentShader = shader.fragmentShader
      .replace('#include <common>', `#include <common>\nvarying vec3 vPlace;\n${'spacing' in lines ? EQUAL : UNEQUAL}`)
      .replace('#include <color_fragment>', `#include <color_fragment>\n${LINES}`);
  };
  return material;
}

/** Cells from the first line to a place. */
const EQUAL = `
uniform vec3 cellSize;
vec3 cellsTo(vec3 place) { return place / cellSize; }
vec3 normalTo(vec3 place) { return cross(dFdx(place / cellSize), dFdy(place / cellSize)); }`;

/** The same by a search among the lines, at most 2^18 an axis. */
const UNEQUAL = `
uniform highp sampler2D linesX;
uniform highp sampler2D linesY;
uniform highp sampler2D linesZ;
uniform vec3 ends;
float line(highp sampler2D lines, int at) { return texelFetch(lines, ivec2(at % ${ROW}, at / ${ROW}), 0).r; }
float cellsAlong(highp sampler2D lines, float end, float place) {
  int low = 0;
  int high = int(end);
  for (int step = 0; step < 18 && high - low > 1; step += 1) {
    int middle = (low + high) / 2;
    if (line(lines, middle) <= place) low = middle;
    else high = middle;
  }
  float start = line(lines, low);
  return float(low) + (place - start) / (line(lines, low + 1) - start);
}
vec3 cellsTo(vec3 place) {
  return vec3(cellsAlong(linesX, ends.x, place.x), cellsAlong(linesY, ends.y, place.y), cellsAlong(linesZ, ends.z, place.z));
}
vec3 normalTo(vec3 place) { return cross(normalize(dFdx(place)), normalize(dFdy(place))); }`;

/** The axis across the face has no lines; lines fade where a cell is less than a few pixels wide. */
const LINES = `
{
  vec3 cells = cellsTo(vPlace);
  vec3 across = abs(normalize(normalTo(vPlace)));
  vec3 perPixel = max(fwidth(cells), 1e-6);
  vec3 distanceToLine = abs(fract(cells - 0.5) - 0.5) / perPixel;
  vec3 isLine = (1.0 - smoothstep(0.3, 1.1, distanceToLine)) * (1.0 - smoothstep(0.1, 0.2, perPixel)) * (1.0 - step(0.5, across));
  diffuseColor.rgb *= 1.0 - 0.38 * max(isLine.x, max(isLine.y, isLine.z));
  // a tone for each axis: steps stay readable where all faces get the same light
  diffuseColor.rgb *= dot(across, vec3(0.86, 0.72, 1.0));
  if (!gl_FrontFacing) diffuseColor.rgb *= 0.55;
}`;

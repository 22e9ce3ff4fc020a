/** The material of stair-step surfaces: faces flat, back faces darker, mesh lines where cells are large enough to see. */
import * as THREE from 'three';

/**
 * Makes a material for faces that lie on mesh lines.
 *
 * @param {string} colour
 * @param {number[]} spacing length of a drawn cell on x, y, z
 */
export function stairMaterial(colour, spacing) {
  const material = new THREE.MeshStandardMaterial({ color: colour, flatShading: true, side: THREE.DoubleSide, roughness: 0.75 });
  material.onBeforeCompile = (shader) => {
    shader.uniforms.cellSize = { value: new THREE.Vector3().fromArray(spacing) };
    shader.vertexShader = shader.vertexShader
      .replace('#include <common>', '#include <common>\nuniform vec3 cellSize;\nvarying vec3 vCell;')
      .replace('#include <begin_vertex>', '#include <begin_vertex>\nvCell = position / cellSize;');
    shader.fragmentShader = shader.fragmentShader
      .replace('#include <common>', '#include <common>\nvarying vec3 vCell;')
      .replace('#include <color_fragment>', `#include <color_fragment>\n${LINES}`);
  };
  return material;
}

/** The axis across the face has no lines; lines fade where a cell is less than a few pixels wide. */
const LINES = `
{
  vec3 across = abs(normalize(cross(dFdx(vCell), dFdy(vCell))));
  vec3 perPixel = max(fwidth(vCell), 1e-6);
  vec3 distanceToLine = abs(fract(vCell - 0.5) - 0.5) / perPixel;
  vec3 isLine = (1.0 - smoothstep(0.3, 1.1, distanceToLine)) * (1.0 - smoothstep(0.1, 0.2, perPixel)) * (1.0 - step(0.5, across));
  diffuseColor.rgb *= 1.0 - 0.38 * max(isLine.x, max(isLine.y, isLine.z));
  // a tone for each axis: steps stay readable where all faces get the same light
  diffuseColor.rgb *= dot(across, vec3(0.86, 0.72, 1.0));
  if (!gl_FrontFacing) diffuseColor.rgb *= 0.55;
}`;

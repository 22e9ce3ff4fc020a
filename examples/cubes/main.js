/** Draws the cells of a mesh that can be seen: a cube for each cell with a flag and a neighbour in the background, all in one InstancedMesh. */
import { createMesher } from 'hexcast';
import * as THREE from 'three';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';

const [input, state, canvas] = ['file', 'state', 'view'].map((id) => document.getElementById(id));
const mesher = await createMesher();
const renderer = new THREE.WebGLRenderer({ canvas, antialias: true });
const scene = new THREE.Scene();
scene.background = new THREE.Color('white');
scene.add(new THREE.HemisphereLight('white', 'grey', 3));
const camera = new THREE.PerspectiveCamera(45, canvas.width / canvas.height, 1, 1e4);
const controls = new OrbitControls(camera, canvas);
const draw = () => renderer.render(scene, camera);
controls.addEventListener('change', draw);

/** Indices of the cells that can be seen. @param {Uint8Array} flags @param {readonly number[]} dims */
function visible(flags, [nx, ny, nz]) {
  const cells = [];
  for (let z = 0, at = 0; z < nz; z += 1) {
    for (let y = 0; y < ny; y += 1) {
      for (let x = 0; x < nx; x += 1, at += 1) {
        const isInside = x > 0 && x < nx - 1 && y > 0 && y < ny - 1 && z > 0 && z < nz - 1;
        const around = [at - 1, at + 1, at - nx, at + nx, at - nx * ny, at + nx * ny];
        if (flags[at] > 0 && (!isInside || around.some((neighbour) => flags[neighbour] === 0))) cells.push(at);
      }
    }
  }
  return cells;
}

async function show([source]) {
  const mesh = await mesher.mesh({ geometries: [{ source }], cells: 64 });
  const [nx, ny, nz] = mesh.dims;
  const { flags } = await mesh.box([0, 0, 0], mesh.dims);
  const cells = visible(flags, mesh.dims);
  const cubes = new THREE.InstancedMesh(new THREE.BoxGeometry(0.9, 0.9, 0.9), new THREE.MeshLambertMaterial(), cells.length);
  const place = new THREE.Matrix4();
  for (const [index, cell] of cells.entries()) {
    place.setPosition(cell % nx, Math.floor(cell / nx) % ny, Math.floor(cell / (nx * ny)));
    cubes.setMatrixAt(index, place);
    cubes.setColorAt(index, new THREE.Color().setHSL((flags[cell] * 0.38) % 1, 0.6, 0.55));
  }
  mesh.dispose();
  for (const old of scene.children.filter((child) => child instanceof THREE.InstancedMesh)) {
    scene.remove(old);
    old.dispose();
  }
  scene.add(cubes);
  controls.target.set(nx / 2, ny / 2, nz / 2);
  camera.position.set(nx * 1.6, ny * 1.2, nz * 2.2);
  controls.update();
  draw();
  state.textContent = `${cells.length} cubes of ${nx} x ${ny} x ${nz} cells`;
}

input.addEventListener('change', () =>
  show(input.files).catch((error) => {
    state.textContent = error.message;
  }),
);
input.disabled = false;

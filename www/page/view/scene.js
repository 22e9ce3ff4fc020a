/**
 * The 3-D scene: models, stair-step surface, domain, section. Draws only when something has changed.
 *
 * World lengths may be far from zero, so everything hangs in one group that is moved to the origin.
 */
import * as THREE from 'three';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';

import { oncePerFrame } from '../elements/dom.js';
import { Marks } from './marks.js';
import { movedBy, placedBox } from '../text/places.js';
import { linesOfCells, stairMaterial } from './stair_material.js';

/**
 * @typedef {{ axis: number, side: number, at: number, image: ImageData, edges: number[][] }} Cut
 * @typedef {THREE.Mesh<THREE.BufferGeometry, THREE.MeshStandardMaterial | THREE.MeshBasicMaterial>} Drawn
 * @typedef {{ scale: number | number[] | null, rotate: number[] | null, about: number[] | null, translate: number[] | null }} Placing
 * @typedef {Placing & { corners: Float32Array, colour: string }} Model
 */

/** How long the camera flies to a place. */
const FLIGHT_SECONDS = 0.6;

export class Scene {
  #canvas;
  #frame;
  #renderer;
  #scene = new THREE.Scene();
  #camera = new THREE.PerspectiveCamera(35, 1, 0.01, 1000);
  #controls;
  #world = new THREE.Group();
  #models = groupOfDrawn();
  #skin = groupOfDrawn();
  #section = groupOfDrawn();
  #marks = new Marks();
  /** @type {THREE.Box3Helper | null} */
  #box = null;
  /** @type {number[] | null} */
  #boxCorners = null;
  #plane = new THREE.Plane();
  /** Counts the moves of the camera: one in flight ends where another begins. */
  #moves = 0;
  /** Sphere around what is shown, in world lengths. */
  #centre = new THREE.Vector3();
  #radius = 1;

  /** @param {HTMLCanvasElement} canvas */
  constructor(canvas) {
    this.#canvas = canvas;
    this.#frame = /** @type {HTMLElement} */ (canvas.parentElement);
    this.#renderer = new THREE.WebGLRenderer({ canvas, antialias: true, alpha: true });
    this.#renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    this.#camera.up.set(0, 0, 1);
    this.#controls = new OrbitControls(this.#camera, canvas);
    this.#world.add(this.#models, this.#skin, this.#section, this.#marks);
    const lamp = new THREE.DirectionalLight(0xffffff, 2.4);
    lamp.position.set(0.4, 0.8, 1);
    this.#camera.add(lamp);
    this.#scene.add(this.#world, this.#camera, new THREE.HemisphereLight(0xffffff, 0xaab2bb, 2));
    this.invalidate = oncePerFrame(() => this.draw());
    this.#controls.addEventListener('change', this.invalidate);
    this.#controls.addEventListener('start', () => this.#moves++);
    new ResizeObserver(() => this.#resize()).observe(this.#frame);
    this.#resize();
  }

  #resize() {
    const { clientWidth: width, clientHeight: height } = this.#frame;
    if (width === 0 || height === 0) return;
    this.#renderer.setSize(width, height, false);
    const before = this.#angle();
    this.#camera.aspect = width / height;
    // what was in view still is, also where the view becomes narrow
    const factor = Math.sin(before / 2) / Math.sin(this.#angle() / 2);
    const { target } = this.#controls;
    this.#camera.position.sub(target).multiplyScalar(factor).add(target);
    this.#camera.near *= factor;
    this.#camera.far *= factor;
    this.#camera.updateProjectionMatrix();
    this.draw();
  }

  /** How wide the camera sees along the shorter side of the view, in radians. */
  #angle() {
    return THREE.MathUtils.degToRad(this.#camera.fov) * Math.min(1, this.#camera.aspect);
  }

  draw() {
    this.#renderer.render(this.#scene, this.#camera);
  }

  /** Shows models. @param {Model[]} models */
  setModels(models) {
    discard(this.#models);
    for (const { corners, colour, ...placing } of models) {
      const geometry = new THREE.BufferGeometry();
      geometry.setAttribute('position', new THREE.BufferAttribute(corners, 3));
      const material = new THREE.MeshStandardMaterial({
        color: colour,
        flatShading: true,
        side: THREE.DoubleSide,
        roughness: 0.7,
      });
      const mesh = new THREE.Mesh(geometry, material);
      this.#models.add(place(mesh, placing));
    }
    this.invalidate();
  }

  /**
   * Shows the stair-step surface, its colours by flag.
   *
   * @param {import('../../hexcast.js').Skin} skin
   * @param {import('../text/places.js').Lines} lines
   * @param {(flag: number) => string} colourOf
   */
  setSkin(skin, lines, colourOf) {
    discard(this.#skin);
    this.#skin.position.fromArray(lines.origin);
    const cells = linesOfCells(lines, skin.step);
    for (const { flag, positions, indices } of skin.parts) {
      const geometry = new THREE.BufferGeometry();
      geometry.setAttribute('position', new THREE.BufferAttribute(positions, 3));
      geometry.setIndex(new THREE.BufferAttribute(indices, 1));
      const mesh = new THREE.Mesh(geometry, stairMaterial(colourOf(flag), cells));
      mesh.userData.flag = flag;
      this.#skin.add(mesh);
    }
    this.invalidate();
  }

  /** @param {(flag: number) => string} colourOf */
  setColours(colourOf) {
    for (const mesh of this.#skin.children) mesh.material.color.set(colourOf(mesh.userData.flag));
    this.invalidate();
  }

  /** Shows either the models or the cells, and of these the flags that are not hidden. @param {string} what @param {Set<number>} hidden */
  show(what, hidden) {
    this.#models.visible = what === 'model';
    this.#skin.visible = what === 'cells';
    this.#section.visible = what === 'cells';
    for (const mesh of this.#skin.children) mesh.visible = !hidden.has(mesh.userData.flag);
    this.invalidate();
  }

  /** Draws the edges of a box of six numbers, or none. @param {number[] | null} corners */
  setBox(corners) {
    if (String(corners) === String(this.#boxCorners)) return;
    this.#boxCorners = corners;
    if (this.#box) {
      this.#world.remove(this.#box);
      this.#box.geometry.dispose();
    }
    this.#box = null;
    if (corners) {
      const [low, high] = [corners.slice(0, 3), corners.slice(3)].map((at) => new THREE.Vector3().fromArray(at));
      this.#box = new THREE.Box3Helper(new THREE.Box3(low, high), 0x7a8a99);
      this.#world.add(this.#box);
    }
    this.invalidate();
  }

  /**
   * Cuts away what lies beyond a plane across an axis and draws the cells that it cuts.
   *
   * @param {null | Cut} cut `at` in
   *   world lengths; what lies on `side` of it goes; the image has equal pixels between the first edge and the last on the two axes
   *   across, or one between each edge and the next
   */
  setSection(cut) {
    discard(this.#section);
    if (cut) this.#cap(cut);
    const normal = [0, 1, 2].map((axis) => (axis === cut?.axis ? -cut.side : 0));
    // planes are in the scene's lengths, where the centre of the world is the origin
    this.#plane.set(new THREE.Vector3().fromArray(normal), cut ? cut.side * (cut.at - this.#centre.getComponent(cut.axis)) : 0);
    const planes = cut ? [this.#plane] : [];
    for (const group of [this.#skin, this.#models]) for (const mesh of group.children) mesh.material.clippingPlanes = planes;
    this.#renderer.localClippingEnabled = Boolean(cut);
    this.invalidate();
  }

  /** @param {Cut} cut */
  #cap({ axis, at, image, edges }) {
    const texture = new THREE.DataTexture(new Uint8Array(image.data.buffer), image.width, image.height);
    texture.magFilter = THREE.NearestFilter;
    texture.colorSpace = THREE.SRGBColorSpace;
    texture.needsUpdate = true;
    const [first, second] = [0, 1, 2].filter((other) => other !== axis);
    const [n_i, n_j] = edges.map((places) => places.length - 1);
    const geometry = new THREE.PlaneGeometry(1, 1, n_i, n_j);
    const { position, uv } = geometry.attributes;
    for (let corner = 0; corner < position.count; corner += 1) {
      const [i, j] = [corner % (n_i + 1), Math.floor(corner / (n_i + 1))];
      const point = [at, at, at];
      [point[first], point[second]] = [edges[0][i], edges[1][j]];
      position.setXYZ(corner, point[0], point[1], point[2]);
      uv.setXY(corner, i / n_i, j / n_j);
    }
    const material = new THREE.MeshBasicMaterial({ map: texture, side: THREE.DoubleSide, alphaTest: 0.5 });
    this.#section.add(new THREE.Mesh(geometry, material));
  }

  /**
   * Moves the camera so that all models fill the view.
   *
   * @param {(Placing & { info: import('hexcast').FileInfo })[]} models
   * @param {number[]} [direction]
   */
  fitModels(models, direction) {
    const all = new THREE.Box3();
    for (const { info, ...placing } of models) {
      const [low, high] = placedBox(info.bounding_box, placing);
      all.union(new THREE.Box3(new THREE.Vector3().fromArray(low), new THREE.Vector3().fromArray(high)));
    }
    this.fit([...all.min, ...all.max], direction);
  }

  /** From where the camera looks. */
  direction() {
    return this.#camera.position.clone().sub(this.#controls.target).toArray();
  }

  /** Moves the camera so that a box of six numbers fills the view, seen from a corner or along `direction`. @param {number[]} corners */
  fit(corners, direction = [1.1, -1.6, 0.9]) {
    this.#moves++;
    const [low, high] = [corners.slice(0, 3), corners.slice(3)].map((at) => new THREE.Vector3().fromArray(at));
    this.#centre.addVectors(low, high).multiplyScalar(0.5);
    this.#radius = Math.max(low.distanceTo(high) / 2, Number.MIN_VALUE);
    this.#world.position.copy(this.#centre).negate();
    const distance = (1.12 * this.#radius) / Math.sin(this.#angle() / 2);
    this.#camera.position.fromArray(direction).setLength(distance);
    this.#camera.near = distance / 200;
    this.#camera.far = distance * 20;
    this.#camera.updateProjectionMatrix();
    this.#controls.target.set(0, 0, 0);
    this.#controls.update();
    this.invalidate();
  }

  /** Flies near a place, outside of what is shown. @param {number[]} place @returns {Promise<boolean>} whether it came there */
  lookAt(place) {
    const target = new THREE.Vector3().fromArray(place).sub(this.#centre);
    // outwards, and a little from where models are seen at first: a place in the middle has no outside
    const outwards = new THREE.Vector3(0.22, -0.32, 0.18).add(target.clone().normalize());
    return this.#fly(target, outwards.setLength(2 * this.#radius));
  }

  /**
   * Moves the camera along an arc around what it looks at; at once for people who want no motion.
   *
   * @param {THREE.Vector3} target
   * @param {THREE.Vector3} offset of the camera from it
   * @returns {Promise<boolean>} false where another move took over
   */
  #fly(target, offset) {
    const move = ++this.#moves;
    const from = this.#controls.target.clone();
    const fromOffset = this.#camera.position.clone().sub(from);
    const seconds = matchMedia('(prefers-reduced-motion: reduce)').matches ? 0 : FLIGHT_SECONDS;
    const start = performance.now();
    return new Promise((resolve) => {
      const step = () => {
        if (move !== this.#moves) return resolve(false);
        const share = seconds > 0 ? Math.min(1, (performance.now() - start) / 1000 / seconds) : 1;
        const eased = THREE.MathUtils.smoothstep(share, 0, 1);
        const length = THREE.MathUtils.lerp(fromOffset.length(), offset.length(), eased);
        this.#controls.target.lerpVectors(from, target, eased);
        this.#camera.position.lerpVectors(fromOffset, offset, eased).setLength(length).add(this.#controls.target);
        this.#controls.update();
        this.invalidate();
        if (share === 1) return resolve(true);
        requestAnimationFrame(step);
      };
      step();
    });
  }

  /** Marks places, of which one is shown, and draws a path. @param {(number[] | null)[]} places @param {number} current @param {number[][]} path */
  mark(places, current, path) {
    if (places.length === 0 && path.length === 0 && this.#marks.children.length === 0) return;
    this.#marks.set(places, current, path);
    this.invalidate();
  }

  /** Turns by angles around z and up (radians), and moves nearer by a factor. @param {number} around @param {number} up */
  turn(around, up, nearer = 1) {
    this.#controls.rotateLeft(-around);
    this.#controls.rotateUp(up);
    this.#controls.dollyOut(nearer);
  }

  /** The side of the target on which the camera is, along an axis: 1 or -1. @param {number} axis */
  sideOf(axis) {
    return this.#camera.position.getComponent(axis) < this.#controls.target.getComponent(axis) ? -1 : 1;
  }

  /** The picture as it is. @returns {Promise<Blob | null>} PNG */
  picture() {
    // drawn and read in the same task: the buffer is cleared after the frame
    this.draw();
    return new Promise((resolve) => this.#canvas.toBlob(resolve, 'image/png'));
  }
}

/**
 * Scales an object, rotates it about x, y and z around a point, and moves it, as the job does.
 *
 * @template {THREE.Object3D} T
 * @param {T} object
 * @param {Placing} placing
 */
function place(object, { scale, rotate, about, translate }) {
  object.scale.fromArray([scale ?? 1, scale ?? 1, scale ?? 1].flat());
  const [x, y, z] = (rotate ?? [0, 0, 0]).map(THREE.MathUtils.degToRad);
  object.rotation.set(x, y, z, 'ZYX');
  object.position.fromArray(movedBy({ rotate, about, translate }));
  object.updateMatrix();
  return object;
}

/** @returns {THREE.Group & { children: Drawn[] }} */
function groupOfDrawn() {
  return /** @type {THREE.Group & { children: Drawn[] }} */ (new THREE.Group());
}

/** Empties a group and frees what its meshes hold on the graphics card. @param {ReturnType<typeof groupOfDrawn>} group */
function discard(group) {
  for (const mesh of group.children) {
    mesh.geometry.dispose();
    mesh.material.map?.dispose();
    mesh.material.dispose();
  }
  group.clear();
}

/** Marks in the 3-D scene, in front of everything: a ring at each finding, always as large on the screen, and the path of a leak. */
import * as THREE from 'three';

/** Colour of the mark that is shown and of the path, on light and dark and on the colours of flags; and of other marks. */
const COLOUR = '#e0103c';
const OTHER_COLOUR = '#7d2fb8';
/** Pixels of a side of a ring's picture. */
const SIDE = 64;
/** Heights in the view, as shares of the distance of the camera. */
const HEIGHT = 0.035;
const OTHER_HEIGHT = 0.028;

export class Marks extends THREE.Group {
  #ring = ringMaterial(COLOUR);
  #otherRing = ringMaterial(OTHER_COLOUR);
  #line = new THREE.LineBasicMaterial({ color: COLOUR, depthTest: false, transparent: true });

  /**
   * Shows marks in place of all others.
   *
   * @param {(number[] | null)[]} places in world lengths
   * @param {number} current index of the one that is shown, -1 for none
   * @param {number[][]} path corners of a line, none for no line
   */
  set(places, current, path) {
    for (const child of this.children) if (child instanceof THREE.Line) child.geometry.dispose();
    this.clear();
    for (const [index, place] of places.entries()) {
      if (!place) continue;
      const isCurrent = index === current;
      const sprite = new THREE.Sprite(isCurrent ? this.#ring : this.#otherRing);
      sprite.scale.setScalar(isCurrent ? HEIGHT : OTHER_HEIGHT);
      sprite.renderOrder = isCurrent ? 3 : 2;
      sprite.position.fromArray(place);
      this.add(sprite);
    }
    if (path.length > 1) this.add(this.#lineOf(path));
  }

  /** @param {number[][]} path */
  #lineOf(path) {
    // from its own first corner, as world lengths may be far from zero
    const from = new THREE.Vector3().fromArray(path[0]);
    const geometry = new THREE.BufferGeometry().setFromPoints(path.map((at) => new THREE.Vector3().fromArray(at).sub(from)));
    const line = new THREE.Line(geometry, this.#line);
    line.position.copy(from);
    line.renderOrder = 1;
    return line;
  }
}

/** @param {string} colour */
function ringMaterial(colour) {
  const canvas = new OffscreenCanvas(SIDE, SIDE);
  const context = canvas.getContext('2d');
  if (context) {
    context.arc(SIDE / 2, SIDE / 2, (3 * SIDE) / 8, 0, 2 * Math.PI);
    for (const [width, edge] of /** @type {[number, string][]} */ ([
      [SIDE / 5, '#ffffff'],
      [SIDE / 8, colour],
    ])) {
      context.lineWidth = width;
      context.strokeStyle = edge;
      context.stroke();
    }
  }
  const map = new THREE.CanvasTexture(canvas);
  map.colorSpace = THREE.SRGBColorSpace;
  return new THREE.SpriteMaterial({ map, sizeAttenuation: false, depthTest: false, transparent: true });
}

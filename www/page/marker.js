/** A ring that marks a place in the 3-D scene: always as large on the screen, and in front of everything. */
import * as THREE from 'three';

/** Colour of the ring, on light and dark and on the colours of flags. */
const COLOUR = '#e0103c';
/** Pixels of a side of its picture. */
const SIDE = 64;
/** Height in the view, as a share of the distance of the camera. */
const HEIGHT = 0.035;

/** Makes the ring. */
export function ring() {
  const canvas = new OffscreenCanvas(SIDE, SIDE);
  const context = canvas.getContext('2d');
  if (context) {
    context.strokeStyle = COLOUR;
    context.lineWidth = SIDE / 8;
    context.arc(SIDE / 2, SIDE / 2, SIDE / 2 - context.lineWidth, 0, 2 * Math.PI);
    context.stroke();
  }
  const map = new THREE.CanvasTexture(canvas);
  map.colorSpace = THREE.SRGBColorSpace;
  const sprite = new THREE.Sprite(new THREE.SpriteMaterial({ map, sizeAttenuation: false, depthTest: false, transparent: true }));
  sprite.scale.setScalar(HEIGHT);
  sprite.renderOrder = 1;
  sprite.visible = false;
  return sprite;
}

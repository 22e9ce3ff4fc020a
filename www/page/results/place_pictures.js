/** Pictures of the places of problems: drawn once a card is seen, and kept while the parts and the place are the same. */
import { debounce } from '../elements/dom.js';
import { boxAround } from '../text/places.js';
import { flagsOf, on, state } from '../state/state.js';
import { Camera } from '../view/camera.js';
import { withScene } from '../view/scene_holder.js';

/** @typedef {import('../state/state.js').Finding} Finding */

/** Pixels of a side; the card shows it half as large, so that edges are smooth. */
const SIDE = 192;
/** From where places are seen, as the parts are at first. */
const CORNER = [1.1, -1.6, 0.9];
/** Share of the parts that is seen around a point, and times of a box that is seen around it. */
const AROUND = { point: 0.08, box: 2.2 };
/** Milliseconds that the parts and the mesh stay as they are before pictures are drawn. */
const PAUSE = 200;

/** Pictures that were drawn. @type {Map<string, ImageData>} */
let kept = new Map();
/** Cards that are seen and have no picture yet. @type {Map<Element, Finding>} */
const waiting = new Map();
/** All that may come to be seen. @type {WeakMap<Element, Finding>} */
const known = new WeakMap();
const drawSoon = debounce(drawAll, PAUSE);
const seen = new IntersectionObserver((entries) => {
  for (const { target, isIntersecting } of entries) {
    const finding = known.get(target);
    if (!isIntersecting || !finding) continue;
    seen.unobserve(target);
    waiting.set(target, finding);
    drawSoon();
  }
});
on(['geometries', 'colours'], () => {
  kept = new Map();
});

/** Puts a picture of the place into a button, over its text. @param {HTMLElement} button @param {Finding} finding */
export function pictureOf(button, finding) {
  const image = kept.get(keyOf(finding));
  if (image) return put(button, image);
  known.set(button, finding);
  seen.observe(button);
}

/** What a picture depends on, besides the parts. @param {Finding} finding */
function keyOf({ kind, place, boxes, flag }) {
  return JSON.stringify([kind, place, boxes, flag]);
}

function drawAll() {
  for (const [button, finding] of waiting) {
    waiting.delete(button);
    if (!button.isConnected || !finding.place) continue;
    withScene(async (scene) => {
      const part = state.geometries.find((geometry) => finding.flag !== null && flagsOf(geometry).includes(finding.flag));
      const places = finding.boxes.length > 0 ? [] : [finding.place];
      const overlay = { places, current: 0, marked: finding.boxes };
      const into = kept;
      const image = await scene.placePicture(
        { sight: sightOf(finding, part), width: SIDE, height: SIDE, overlay },
        part?.corners ?? null,
      );
      if (!image) return;
      into.set(keyOf(finding), image);
      put(button, image);
    });
  }
}

/** Looks at the whole part where all of it is meant, else at the first place. @param {Finding} finding @param {import('../state/state.js').Geometry | undefined} part */
function sightOf({ kind, place, boxes }, part) {
  const camera = new Camera();
  const isWhole = part && /^(no-cell|surface|volume-filled|flag|shells-overlap)/.test(kind);
  camera.fit(isWhole ? boxAround([part]) : around(/** @type {number[]} */ (place), boxes[0]), CORNER);
  return camera.sight();
}

/** A cube around a box or a point. @param {number[]} place @param {number[]} [box] */
function around(place, box) {
  const all = boxAround(state.geometries);
  const sizeOf = (/** @type {number[]} */ of) => Math.max(...[0, 1, 2].map((axis) => of[axis + 3] - of[axis]));
  const half = (box ? AROUND.box * sizeOf(box) : AROUND.point * sizeOf(all)) / 2;
  const middle = box ? [0, 1, 2].map((axis) => (box[axis] + box[axis + 3]) / 2) : place;
  return [...middle.map((at) => at - half), ...middle.map((at) => at + half)];
}

/** @param {Element} button @param {ImageData} image */
function put(button, image) {
  const canvas = document.createElement('canvas');
  Object.assign(canvas, { width: image.width, height: image.height });
  canvas.getContext('2d')?.putImageData(image, 0, 0);
  button.append(canvas);
}

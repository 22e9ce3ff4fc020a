/** What tells sizes and directions in a pane: a scale bar, and the axes as they are seen. */
import { make } from '../elements/dom.js';
import { measure } from '../text/format.js';
import { state } from '../state/state.js';
import { directionsOf } from './camera.js';
import { stretch } from './stretch.js';

/** CSS pixels of the longest bar, and of the arms of the triad. */
const LONGEST = 110;
const ARM = 20;
const SVG = 'http://www.w3.org/2000/svg';

/** The longest of the lengths 1, 2 and 5, and these times powers of ten, that is at most as long. @param {number} most */
export function roundLength(most) {
  const power = 10 ** Math.floor(Math.log10(most));
  const digit = [5, 2, 1].find((one) => one * power <= most * (1 + 1e-9)) ?? 1;
  return digit * power;
}

export class Gauges {
  #triad = document.createElementNS(SVG, 'svg');
  #bar = make('span', { className: 'bar' });
  #text = make('span');
  #root;

  /** @param {HTMLElement} stage */
  constructor(stage) {
    this.#triad.setAttribute('viewBox', '-32 -32 64 64');
    this.#root = make('div', { className: 'gauges', hidden: true, 'aria-hidden': 'true' }, this.#triad, this.#bar, this.#text);
    stage.append(this.#root);
  }

  /** @param {{ axes: number[], perLength: number[] } | null} of the axes to the right and upwards, and device pixels a length on them; null for an empty pane */
  showPlane(of) {
    if (!of) return this.#hide();
    const { axes, perLength } = of;
    const right = [0, 1, 2].map((axis) => (axis === axes[0] ? 1 : 0));
    const up = [0, 1, 2].map((axis) => (axis === axes[1] ? 1 : 0));
    return this.#show(right, up, perLength[0] / (devicePixelRatio || 1), axes[0]);
  }

  /** @param {import('./camera.js').Sight} sight @param {number} height of the view in CSS pixels */
  showSight(sight, height) {
    const { right, up } = directionsOf(sight);
    const distance = Math.hypot(...sight.eye.map((at, axis) => at - sight.target[axis]));
    this.#show(right, up, height / (2 * sight.tangent * distance), -1);
  }

  #hide() {
    this.#root.hidden = true;
  }

  /** @param {number[]} right @param {number[]} up @param {number} perLength CSS pixels a length @param {number} axis of the bar; -1 for any that is not stretched */
  #show(right, up, perLength, axis) {
    const length = roundLength(LONGEST / perLength);
    this.#root.hidden = !Number.isFinite(length) || length <= 0;
    this.#bar.style.width = `${length * perLength}px`;
    const { mesh, settings } = state;
    const unit = mesh ? mesh.report.unit : settings.unit || null;
    const others = [0, 1, 2].filter((other) => stretch[other] === 1);
    const of = stretch.some((times) => times !== 1)
      ? ` of ${axis < 0 ? others.map((other) => 'xyz'[other]).join(', ') : 'xyz'[axis]}`
      : '';
    this.#text.textContent = measure(length, unit) + of;
    this.#triad.replaceChildren(...[0, 1, 2].flatMap((at) => arm(at, right[at], -up[at])));
  }
}

/** An axis with its name; none where it leads straight to or from the eye. @param {number} axis @param {number} x @param {number} y */
function arm(axis, x, y) {
  if (Math.hypot(x, y) < 0.15) return [];
  const line = document.createElementNS(SVG, 'path');
  line.setAttribute('d', `M0 0L${ARM * x} ${ARM * y}`);
  const name = document.createElementNS(SVG, 'text');
  const far = ARM + 8 / Math.hypot(x, y);
  name.setAttribute('x', String(far * x));
  name.setAttribute('y', String(far * y));
  name.textContent = 'xyz'[axis];
  return [line, name];
}

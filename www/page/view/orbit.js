/** The pointers of the 3-D view: they turn, move and zoom it, and a click or tap picks what is there. */

/**
 * @typedef {object} Moves
 * @property {(around: number, up: number) => void} turn in radians
 * @property {(factor: number, place: [number, number]) => void} zoom towards a place of the view from -1 to 1 each way
 * @property {(x: number, y: number) => void} pan by shares of half the view
 * @property {(x: number, y: number) => void} pick in CSS pixels
 * @property {(x: number, y: number) => void} hover in CSS pixels, where no button is pressed
 */

/** CSS pixels that a pointer may move in a click. */
const CLICK = 5;

/** Connects the pointers and the wheel. @param {HTMLCanvasElement} canvas @param {Moves} moves */
export function startOrbit(canvas, { turn, zoom, pan, pick, hover }) {
  /** Pointers that are down, where they are, and whether they move the view instead of turning it. @type {Map<number, { x: number, y: number, isPan: boolean }>} */
  const down = new Map();
  let moved = 0;
  const placeOf = (/** @type {number} */ x, /** @type {number} */ y) =>
    /** @type {[number, number]} */ ([(2 * x) / canvas.clientWidth - 1, 1 - (2 * y) / canvas.clientHeight]);
  const panBy = (/** @type {number} */ dx, /** @type {number} */ dy) =>
    pan((-2 * dx) / canvas.clientWidth, (2 * dy) / canvas.clientHeight);

  canvas.style.touchAction = 'none';
  canvas.addEventListener('contextmenu', (event) => event.preventDefault());
  canvas.addEventListener(
    'wheel',
    (event) => {
      event.preventDefault();
      // a wheel counts pixels or, in some browsers, lines
      const pixels = event.deltaY * (event.deltaMode === 1 ? 18 : 1);
      zoom(2 ** (-Math.min(Math.max(pixels, -300), 300) / 400), placeOf(event.offsetX, event.offsetY));
    },
    { passive: false },
  );
  canvas.addEventListener('pointerdown', (event) => {
    if (down.size === 0) moved = 0;
    canvas.setPointerCapture(event.pointerId);
    const isPan = event.button !== 0 || event.ctrlKey || event.metaKey || event.shiftKey;
    down.set(event.pointerId, { x: event.offsetX, y: event.offsetY, isPan });
  });
  canvas.addEventListener('pointermove', (event) => {
    const pointer = down.get(event.pointerId);
    if (!pointer) return down.size === 0 && event.pointerType !== 'touch' ? hover(event.offsetX, event.offsetY) : undefined;
    const [dx, dy] = [event.offsetX - pointer.x, event.offsetY - pointer.y];
    moved += Math.abs(dx) + Math.abs(dy);
    const other = [...down.values()].find((one) => one !== pointer);
    if (other) {
      // two fingers: what is between them stays between them
      panBy(dx / 2, dy / 2);
      const before = Math.hypot(pointer.x - other.x, pointer.y - other.y);
      const now = Math.hypot(event.offsetX - other.x, event.offsetY - other.y);
      if (before > 0 && now > 0) zoom(now / before, placeOf((event.offsetX + other.x) / 2, (event.offsetY + other.y) / 2));
    } else if (pointer.isPan) panBy(dx, dy);
    // a turn around for the height of the view
    else turn((-2 * Math.PI * dx) / canvas.clientHeight, (2 * Math.PI * dy) / canvas.clientHeight);
    pointer.x = event.offsetX;
    pointer.y = event.offsetY;
    return undefined;
  });
  const lift = (/** @type {PointerEvent} */ event) => {
    const pointer = down.get(event.pointerId);
    if (event.type === 'pointerup' && pointer && down.size === 1 && moved <= CLICK && event.button === 0)
      pick(event.offsetX, event.offsetY);
    down.delete(event.pointerId);
  };
  canvas.addEventListener('pointerup', lift);
  canvas.addEventListener('pointercancel', lift);
}

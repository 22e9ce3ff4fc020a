/**
 * The worker that draws the 3-D view: it holds the canvas, so the page never waits for a picture. Of all that arrives while it draws
 * only the last counts. While something moves, pictures are small enough to come soon; at rest the whole one is drawn in strips, between
 * which it looks for messages.
 */
import { packed } from './columns.js';
import { isDone } from './gl.js';
import { openEdges } from './open_edges.js';
import { Picture } from './picture.js';
import { PlacePictures } from './place_picture.js';

/**
 * @typedef {{ canvas: OffscreenCanvas, gl: import('./gl.js').GL, picture: Picture, places: PlacePictures }} Opened
 * @typedef {import('./picture.js').Shown} Shown
 */

/** Milliseconds that a picture may take while something moves. */
const MOVING_MS = 24;
/** A whole picture is drawn so many milliseconds after the last message. */
const REST_MS = 120;
/** Milliseconds that a strip of it should take. */
const STRIP_MS = 30;
/** Rows of the least strip. */
const LEAST_STRIP = 8;
/** Pictures are not drawn smaller than this share of their width. */
const LEAST_SCALE = 1 / 8;
/** Pixels by which the passes of a whole picture are moved, for smooth edges; the first is not. */
const PASSES = [
  [0, 0],
  [0.25, -0.375],
  [-0.375, -0.25],
  [0.375, 0.25],
  [-0.25, 0.375],
];
/** After so many milliseconds no further pass begins, of the view at rest and of a file that somebody waits for. */
const VIEW_MS = 2000;
const FILE_MS = 700;

/** Pixels of the longer side of a file, at most. */
const MOST_SIDE = 8192;

/** @type {Opened | null} */
let opened = null;
/** Of the canvas, in pixels, and pixels of a CSS pixel. */
let size = { width: 1, height: 1, ratio: 1 };
/** Whether a file is drawn, so that the canvas waits for its size. */
let isSaving = false;
/** What the parts of the picture were given: a context that was lost is given it again. @type {{ [part: string]: any }} */
const given = { models: [], cells: null, colours: new Uint32Array(256), overlay: {} };
/** Corners of models by their numbers. @type {Map<number, Float32Array>} */
const corners = new Map();
/** Open edges of those that have some. @type {Map<number, Float32Array>} */
const open = new Map();
/** @type {Shown & { ratio: number }} */
const shown = {
  what: 'model',
  cut: null,
  lost: [],
  cell: 0,
  ratio: 1,
  sight: { stretch: [1, 1, 1], centre: [0, 0, 0], eye: [1, 1, 1], target: [0, 0, 0], tangent: 0.3, near: 0.1, far: 10 },
};
let scale = 0.5;
/** Milliseconds of the last picture that was drawn whole at its scale. */
let last = Infinity;
/** Counts what changes the picture. */
let revision = 0;
let isDrawing = false;
let isLost = false;
/** Numbers of the questions for a file of the picture. @type {number[]} */
const saves = [];
/** Pictures that were put on the canvas. */
let n_pictures = 0;
/** Meshes of which it has had the cells. */
let n_meshes = 0;
/** Messages that came. */
let n_heard = 0;

const say = (/** @type {object} */ message, /** @type {Transferable[]} */ transfer = []) => postMessage(message, { transfer });

/** @type {{ [kind: string]: (message: any) => unknown }} */
const TAKE = {
  open({ canvas }) {
    canvas.addEventListener('webglcontextlost', (/** @type {Event} */ event) => {
      event.preventDefault();
      isLost = true;
    });
    canvas.addEventListener('webglcontextrestored', () => {
      isLost = false;
      start(canvas);
      invalidate();
    });
    start(canvas);
  },
  size({ width, height, ratio }) {
    size = { width, height, ratio };
    if (!isSaving) takeSize();
  },
  models({ models }) {
    for (const model of models) if (model.corners) corners.set(model.id, model.corners);
    for (const id of corners.keys()) {
      if (models.some((/** @type {{ id: number }} */ model) => model.id === id)) continue;
      corners.delete(id);
      open.delete(id);
    }
    given.models = models.map((/** @type {{ id: number }} */ model) => ({ ...model, corners: corners.get(model.id) }));
    opened?.picture.models.set(given.models);
    const unclosed = given.models.filter((/** @type {{ isOpen: boolean }} */ { isOpen }) => isOpen);
    for (const { id, corners } of unclosed) if (!open.has(id)) open.set(id, openEdges(corners));
    given.overlay.edges = unclosed.map((/** @type {{ id: number, matrix: number[] }} */ { id, matrix }) => ({
      id,
      ends: open.get(id),
      matrix,
    }));
    opened?.picture.overlay.set({ edges: given.overlay.edges });
  },
  cells({ all, grid, cells }) {
    given.cells = all && { columns: packed(all, cells), grid };
    n_meshes += 1;
    opened?.picture.cells.set(given.cells);
  },
  colours({ colours }) {
    given.colours = colours;
    opened?.picture.cells.setColours(colours);
  },
  overlay({ overlay }) {
    Object.assign(given.overlay, overlay);
    opened?.picture.overlay.set(overlay);
  },
  shown({ shown: what }) {
    Object.assign(shown, what);
  },
  pick({ id, place }) {
    say({ kind: 'answer', id, answer: opened?.picture.pick(shown, place) ?? null });
    return false;
  },
  place({ id, asked }) {
    const edges = (given.overlay.edges ?? []).filter((/** @type {{ id: number }} */ of) => of.id === asked.part);
    say({ kind: 'answer', id, answer: isLost ? null : (opened?.places.draw(asked, edges) ?? null) });
    return false;
  },
  save({ id }) {
    saves.push(id);
  },
};

addEventListener('message', ({ data }) => {
  try {
    n_heard += 1;
    if (TAKE[data.kind](data) === undefined) invalidate();
    else if (!isDrawing) say({ kind: 'rest', heard: n_heard });
  } catch (error) {
    say({ kind: 'failed', message: String(error) });
  }
});

/** @param {OffscreenCanvas} canvas */
function start(canvas) {
  const gl = canvas.getContext('webgl2', { alpha: true, antialias: false, depth: false, powerPreference: 'high-performance' });
  if (!gl) return say({ kind: 'failed' });
  const picture = new Picture(gl);
  opened = { canvas, gl, picture, places: new PlacePictures(gl, picture.models) };
  picture.resize(canvas.width, canvas.height);
  picture.models.set(given.models);
  picture.cells.set(given.cells);
  picture.cells.setColours(given.colours);
  picture.overlay.set(given.overlay);
  return undefined;
}

function invalidate() {
  revision += 1;
  if (isDrawing) return;
  isDrawing = true;
  // messages of the same task come first
  setTimeout(async () => {
    try {
      await draw();
    } catch (error) {
      say({ kind: 'failed', message: String(error) });
    } finally {
      isDrawing = false;
      say({ kind: 'rest', heard: n_heard });
    }
  });
}

/** Draws until the picture at rest is that of the last message. */
async function draw() {
  for (let drawn = -1; drawn !== revision; ) {
    drawn = revision;
    while (saves.length > 0) say({ kind: 'answer', id: saves.pop(), answer: await wholePicture() });
    await drawSoon();
    if (drawn !== revision) continue;
    for (const end = performance.now() + REST_MS; performance.now() < end && drawn === revision; ) await wait(8);
    if (drawn === revision) await drawWhole(() => drawn !== revision);
  }
}

/** @param {number} milliseconds */
const wait = (milliseconds) => new Promise((resolve) => setTimeout(resolve, milliseconds));

/** One picture as large as may be drawn in time. */
async function drawSoon() {
  if (!opened || isLost) return;
  const meshes = n_meshes;
  const { gl, picture } = opened;
  const begin = performance.now();
  const isFine = scale === 1 && last < MOVING_MS / 2;
  picture.draw(shown, { scale, ratio: shown.ratio, from: 0, to: picture.rows(scale), jitter: [0, 0], isFine });
  picture.show(scale);
  await isDone(gl);
  last = performance.now() - begin;
  tell(false, meshes);
  if (last > MOVING_MS) scale = Math.max(LEAST_SCALE, scale / 2);
  // twice as wide takes four times as long
  else if (last < MOVING_MS / 6) scale = Math.min(1, scale * 2);
}

/** The picture at rest; then passes that make its edges smooth. @param {() => boolean} isOld */
async function drawWhole(isOld) {
  if (!opened) return;
  const begin = performance.now();
  for (const [n, jitter] of PASSES.entries()) {
    if (!(await drawInStrips(jitter, isOld))) return;
    opened.picture.addToMean(n);
    opened.picture.showMean();
    await isDone(opened.gl);
    tell(true, n_meshes);
    if (isOld() || performance.now() - begin > VIEW_MS) return;
  }
}

/** Draws a whole pass, unless it becomes old meanwhile. @param {number[]} jitter @param {() => boolean} isOld @returns {Promise<boolean>} whether it is there */
async function drawInStrips(jitter, isOld, ratio = shown.ratio) {
  if (!opened) return false;
  const { gl, picture } = opened;
  const rows = picture.rows(1);
  let height = Math.max(LEAST_STRIP, Math.round(rows / 16));
  for (let from = 0; from < rows; ) {
    const begin = performance.now();
    const to = Math.min(rows, from + height);
    picture.draw(shown, { scale: 1, ratio, from, to, jitter, isFine: true });
    await isDone(gl);
    if (isOld() || isLost) return false;
    from = to;
    // as many as take the time, but no leaps: the next rows may show more
    const fitting = (height * STRIP_MS) / Math.max(performance.now() - begin, 1);
    height = Math.max(LEAST_STRIP, Math.round(Math.min(Math.max(fitting, height / 2), 3 * height)));
  }
  return true;
}

/** @param {boolean} isWhole @param {number} cells meshes that were there when it began */
function tell(isWhole, cells) {
  n_pictures += 1;
  say({ kind: 'drawn', n: n_pictures, isWhole, cells, step: opened?.picture.cells.step });
}

/** @returns {Promise<Blob | null>} PNG of the whole picture, twice as wide and high as the canvas, if it can be */
async function wholePicture() {
  if (!opened) return null;
  const { canvas, gl, picture } = opened;
  const begin = performance.now();
  const { width, height, ratio } = size;
  const most = Math.min(MOST_SIDE, gl.getParameter(gl.MAX_TEXTURE_SIZE));
  const times = Math.max(1, Math.min(2, most / Math.max(width, height)));
  const large = { width: Math.floor(times * width), height: Math.floor(times * height) };
  isSaving = true;
  picture.resize(large.width, large.height);
  for (const [n, jitter] of PASSES.entries()) {
    await drawInStrips(jitter, () => false, times * ratio);
    picture.addToMean(n);
    if (performance.now() - begin > FILE_MS) break;
  }
  // in the task that draws: the canvas is empty after it, and nobody sees it large
  Object.assign(canvas, large);
  picture.showMean();
  const blob = canvas.convertToBlob({ type: 'image/png' });
  isSaving = false;
  takeSize();
  await drawSoon();
  return blob;
}

/** The canvas gets the size that it was given last. */
function takeSize() {
  if (!opened) return;
  const { width, height, ratio } = size;
  Object.assign(opened.canvas, { width, height });
  opened.picture.resize(width, height);
  shown.ratio = ratio;
}

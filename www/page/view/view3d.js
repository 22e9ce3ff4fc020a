/** The 3-D view: loads three.js when there is first something to draw, and connects the tools above the picture. */
import { buttonOf, byId, canvasOf, inputOf, selectOf } from '../elements/dom.js';
import { count, short } from '../text/format.js';
import { save } from '../downloads/downloads.js';
import { clearMessages, showNotice } from '../elements/messages.js';
import { domainOf } from '../settings/settings.js';
import { baseName } from '../settings/share.js';
import { colourOf, on, placeKey, state } from '../state/state.js';
import { paint } from './flag_pixels.js';
import { placeAt } from '../text/places.js';

/** @typedef {import('./scene.js').Scene} Scene */

/** Most pixels a side of the picture of a section. */
const SECTION_PIXELS = 1024;
/** The same where cells differ in size: each sample is a rectangle of its own. */
const SECTION_SAMPLES = 512;

/** The scene, once three.js is loaded; a promise, so that it is loaded once. */
let loading = /** @type {Promise<Scene> | null} */ (null);
let shown = 'model';
let section = 0;
let modelsLook = '[]';
let modelsDrawn = '';
/** The mesh whose surface is drawn. @type {import('hexcast').Mesh | null} */
let drawn = null;
/** Whether the view could not be opened. */
let hasFailed = false;
/** The side that the section removes: the one of the camera when its axis was chosen. */
let side = 1;

/** Connects the view. */
export function startView3d() {
  on(['geometries', 'mesh'], showTools);
  showTools();
  on('geometries', () => showModels());
  on('colours', () => recolour());
  on('estimate', () =>
    withScene((scene) =>
      scene.setBox(state.geometries.length > 0 && state.estimate?.result ? domainOf(state.estimate.result) : null),
    ),
  );
  on('mesh', () => showMesh());
  // before the surface is there, the old one would be drawn once more
  on('findings', () => drawn === state.mesh && mark());
  on('legend', () => {
    withScene((scene) => scene.show(shown, state.hidden));
    cut();
  });
  for (const what of ['model', 'cells']) byId(`show-${what}`).addEventListener('change', () => choose(what));
  byId('fit').addEventListener('click', () => fit());
  byId('save-3d').addEventListener('click', () => withScene(savePicture));
  byId('section-axis').addEventListener('change', () => cut(true));
  byId('section-at').addEventListener('input', () => cut());
  byId('canvas-3d').addEventListener('keydown', turnByKey);
  // three.js is large: it is loaded while the browser is idle
  (globalThis.requestIdleCallback ?? setTimeout)(() => loadScene().catch(() => {}));
}

function loadScene() {
  return import('./scene.js');
}

function load() {
  // asked first, as three.js would write an error to the console
  if (!loading && !document.createElement('canvas').getContext('webgl2'))
    loading = Promise.reject(new Error('there is no WebGL'));
  loading ??= loadScene().then(({ Scene }) => new Scene(canvasOf('canvas-3d')));
  return loading;
}

/**
 * Calls an action with the scene once there is anything to show; where a browser has no WebGL, reports that once.
 *
 * @param {(scene: Scene) => unknown} action
 */
async function withScene(action) {
  if (!loading && state.geometries.length === 0 && !state.mesh) return;
  try {
    await action(await load());
  } catch {
    if (hasFailed) return;
    hasFailed = true;
    byId('no-3d').hidden = false;
    choose('model');
  }
}

/** Marks what was found. */
function mark() {
  const { findings, finding, leak } = state;
  const places = findings.map(({ place }) => place);
  return withScene((scene) => scene.mark(places, finding, leak?.path?.points ?? []));
}

/** Disables the tools while there is nothing to show. */
function showTools() {
  const isEmpty = hasFailed || (state.geometries.length === 0 && !state.mesh);
  byId('canvas-3d').tabIndex = isEmpty ? -1 : 0;
  for (const id of ['fit', 'save-3d']) buttonOf(id).disabled = isEmpty;
  inputOf('show-model').disabled = isEmpty || state.geometries.length === 0;
  inputOf('show-cells').disabled = isEmpty || !state.mesh;
}

/** Shows the models anew where what is seen of them has changed: corners are large. */
function showModels() {
  const { geometries } = state;
  const look = JSON.stringify(
    geometries.map(({ id, flag, scale, rotate, about, translate }) => [id, colourOf(flag), scale, rotate, about, translate]),
  );
  const drawn = geometries.map(({ corners }) => corners?.length).join();
  if (look === modelsLook && drawn === modelsDrawn) return;
  // a picture that comes after the cells does not hide them
  if (look !== modelsLook) choose('model');
  [modelsLook, modelsDrawn] = [look, drawn];
  withScene((scene) => {
    // of a model that is not drawn yet, the view shows the box
    const models = geometries.flatMap(({ corners, ...rest }) =>
      corners ? [{ ...rest, corners, colour: colourOf(rest.flag) }] : [],
    );
    scene.setModels(models);
    const ids = geometries.map(({ id }) => id).join();
    const places = geometries.map(placeKey).join();
    const { models: lastIds, places: lastPlaces } = byId('canvas-3d').dataset;
    if (ids !== lastIds) fit();
    else if (places !== lastPlaces) fit(true);
    Object.assign(byId('canvas-3d').dataset, { models: ids, places });
  });
}

function recolour() {
  withScene((scene) => {
    const before = shown;
    scene.setColours(colourOf);
    showModels();
    choose(before);
    cut();
  });
}

/** Shows the models or the cells. @param {string} what */
function choose(what) {
  // without models there are the cells only
  const hasModels = state.geometries.length > 0;
  shown = state.mesh && (what === 'cells' || !hasModels) ? 'cells' : 'model';
  showTools();
  inputOf(`show-${shown}`).checked = true;
  byId('section').hidden = shown !== 'cells' || hasFailed;
  withScene((scene) => {
    scene.show(shown, state.hidden);
    byId('canvas-3d').setAttribute(
      'aria-label',
      shown === 'cells' ? 'Stair-step surface of the mesh; arrow keys turn it' : 'The model; arrow keys turn it',
    );
  });
}

async function showMesh() {
  const { mesh, skin: promised } = state;
  if (!mesh) {
    mark();
    return clearMessages('mesh');
  }
  selectOf('section-axis').value = '';
  await withScene(async (scene) => {
    byId('view-status').textContent = 'Extracting …';
    const skin = await (promised ?? mesh.skin());
    if (mesh !== state.mesh) return;
    drawn = mesh;
    await mark();
    byId('view-status').textContent = '';
    clearMessages('mesh');
    if (skin.step > 1)
      showNotice(
        `the surface in 3-D is drawn with cells of ${skin.step} × ${skin.step} × ${skin.step}, because it has too many faces; slices and files have every cell`,
        'mesh',
      );
    scene.setSkin(skin, mesh.lines, colourOf);
    const isEmpty = skin.parts.length === 0;
    choose(isEmpty ? 'model' : 'cells');
    scene.setSection(null);
    scene.setBox(domainOf(mesh.report));
    if (state.geometries.length === 0) fit();
    const n_triangles = skin.parts.reduce((sum, part) => sum + part.indices.length / 3, 0);
    byId('canvas-3d').dataset.triangles = String(n_triangles);
    scrollToView();
    byId('view-status').textContent = isEmpty ? 'No cell has a flag.' : `${count(n_triangles)} triangles`;
  });
}

/** Moves the camera so that all of what is shown can be seen, from where it is or from a corner. */
function fit(keepsDirection = false) {
  const { mesh, geometries } = state;
  if (!mesh && geometries.length === 0) return;
  withScene((scene) => {
    const direction = keepsDirection ? scene.direction() : undefined;
    if (mesh && (shown === 'cells' || geometries.length === 0)) scene.fit(domainOf(mesh.report), direction);
    else scene.fitModels(geometries, direction);
  });
}

/**
 * Flies to a place of the models, which it shows uncut; the canvas has the place once it is there.
 *
 * @param {number[]} place in world lengths
 */
export function lookAt(place) {
  selectOf('section-axis').value = '';
  cut();
  if (state.geometries.some(({ corners }) => corners)) choose('model');
  mark();
  withScene(async (scene) => {
    const { dataset } = byId('canvas-3d');
    delete dataset.place;
    if (await scene.lookAt(place)) dataset.place = place.join(' ');
  });
  scrollToView();
}

/** On a phone the picture lies between the fields and the result. */
function scrollToView() {
  if (matchMedia('(max-width: 760px)').matches) byId('view').scrollIntoView({ behavior: 'smooth' });
}

/** @param {Scene} scene */
async function savePicture(scene) {
  const picture = await scene.picture();
  if (picture) save(picture, `${baseName(state.job)}-3d.png`);
}

/** Puts the section where its tools say; `isNew` starts in the middle. The last request wins. */
async function cut(isNew = false) {
  const { mesh } = state;
  const choice = selectOf('section-axis').value;
  const slider = inputOf('section-at');
  slider.disabled = choice === '';
  const request = ++section;
  byId('section-where').textContent = '';
  if (!mesh || choice === '') return withScene((scene) => scene.setSection(null));
  const axis = /** @type {0 | 1 | 2} */ (Number(choice));
  slider.max = String(mesh.dims[axis] - 1);
  if (isNew) slider.value = String(Math.floor(mesh.dims[axis] / 2));
  const index = Number(slider.value);
  const { lines } = mesh;
  const at = placeAt(lines, axis, index + 0.5);
  const where = `${'xyz'[axis]} = ${short(at)}${mesh.report.unit ? ` ${mesh.report.unit}` : ''}`;
  slider.setAttribute('aria-valuetext', `cell ${index} of ${mesh.dims[axis]}, ${where}`);
  byId('section-where').textContent = where;
  const slice = await mesh.slice(axis, index, lines.spacing ? SECTION_PIXELS : SECTION_SAMPLES);
  if (request !== section || mesh !== state.mesh) return undefined;
  const [first, second] = [0, 1, 2].filter((other) => other !== axis);
  const edges = (/** @type {number} */ of, /** @type {number} */ n) =>
    lines.spacing
      ? [0, n].map((sample) => placeAt(lines, of, sample * slice.step))
      : Array.from({ length: n + 1 }, (_, sample) => placeAt(lines, of, Math.min(sample * slice.step, lines.dims[of])));
  return withScene((scene) => {
    if (isNew) side = scene.sideOf(axis);
    scene.setSection({
      axis,
      side,
      at,
      image: paint(slice, { isUp: false, hidden: state.hidden }),
      edges: [edges(first, slice.width), edges(second, slice.height)],
    });
  });
}

/** @param {KeyboardEvent} event */
function turnByKey(event) {
  const step = event.shiftKey ? 0.02 : 0.1;
  /** @type {Record<string, [number, number, number?]>} */
  const turns = {
    ArrowLeft: [-step, 0],
    ArrowRight: [step, 0],
    ArrowUp: [0, step],
    ArrowDown: [0, -step],
    '+': [0, 0, 1.15],
    '=': [0, 0, 1.15],
    '-': [0, 0, 1 / 1.15],
  };
  if (event.key === 'Home') fit();
  else if (turns[event.key] && !event.ctrlKey && !event.metaKey) withScene((scene) => scene.turn(...turns[event.key]));
  else return;
  event.preventDefault();
}

/** The 3-D view: opens the scene when there is first something to draw, and connects the tools above the picture. */
import { buttonOf, byId, inputOf } from '../elements/dom.js';
import { count } from '../text/format.js';
import { smallest } from '../text/places.js';
import { save } from '../downloads/downloads.js';
import { clearMessages, showError, showNotice } from '../elements/messages.js';
import { domainOf } from '../settings/settings.js';
import { lookOf, offerLook, takeNumbers } from '../settings/looks.js';
import { baseName } from '../settings/share.js';
import { change, colourOf, on, placeKey, state } from '../state/state.js';
import { isLive } from '../run/live_rule.js';
import { flagColours } from './flag_pixels.js';
import { Gauges } from './gauges.js';
import { lostParts, mark, NO_MARKS } from './marks.js';
import { withLegend } from './picture_legend.js';
import { startPointing } from './scene_pointing.js';
import { held, listenToScene, withScene } from './scene_holder.js';
import { keepCut, startSection, uncut } from './section.js';
import { stretch } from './stretch.js';

/** @typedef {import('./scene.js').Scene} Scene */

/** Columns of a mesh that are drawn at most: the browser holds four bytes of each, twice. */
const MOST_COLUMNS = 2 ** 26;
/** Milliseconds. */
const MOST_WAIT = 1000;

/** @type {'model' | 'cells'} */
let shown = 'model';
let modelsLook = '[]';
let modelsDrawn = '';
/** The mesh whose cells are drawn. @type {import('hexcast').Mesh | null} */
let drawn = null;
/** Words for when the cells of the last mesh are on the canvas. */
let said = '';
/** Who waits for the cells of the last mesh. @type {(() => void)[]} */
const waiting = [];
/** Whether models came or went while cells are shown: the camera follows with the next mesh. */
let isToFit = false;
/** What was shown before the cells of a preview. */
let beforePreview = /** @type {'model' | 'cells' | null} */ (null);
/** Where the camera was in the last picture. */
let lastPlace = '';

/** Connects the view. */
export function startView3d() {
  const stage = /** @type {HTMLElement} */ (byId('canvas-3d').parentElement);
  const gauges = new Gauges(stage);
  const pointing = startPointing(() => shown === 'cells' && drawn === state.mesh, fit);
  listenToScene({ failed, drawn: isDrawn, looked: (sight) => gauges.showSight(sight, stage.clientHeight), ...pointing });
  startSection();
  on(['geometries', 'mesh'], showTools);
  showTools();
  on('geometries', () => showModels());
  on('colours', () => recolour());
  on(['estimate', 'mesh', 'live'], showBox);
  on('mesh', () => showMesh());
  // before the surface is there, the old one would be drawn once more
  on('findings', () => drawn === state.mesh && mark());
  on('legend', () => withScene((scene) => scene.setColours(flagColours(state.hidden))));
  for (const what of /** @type {const} */ (['model', 'cells']))
    byId(`show-${what}`).addEventListener('change', () => choose(what));
  byId('fit').addEventListener('click', () => fit());
  byId('save-3d').addEventListener('click', () => withScene(savePicture));
  on('stretch', () => {
    withScene((scene) => scene.setStretch(stretch));
    fit(true);
  });
  offerLook('camera', () => lookOf((state.mesh && held.scene?.place()) || []));
}

/** Draws the edges of the box that is to be meshed: that of the mesh, where the next comes by itself, so that it is not drawn for a moment. */
function showBox() {
  const { mesh, geometries, estimate } = state;
  const of = mesh && isLive() ? mesh.report : estimate?.result;
  withScene((scene) => scene.setBox(geometries.length > 0 && of ? domainOf(of) : null));
}

/** Says that there is no 3-D view. */
function failed() {
  settle();
  byId('no-3d').hidden = false;
  byId('view-status').textContent = '';
  choose('model');
}

/** A picture is on the canvas. @param {import('./scene.js').Drawn} picture */
function isDrawn({ n, isWhole, cells, step }) {
  // for tests
  const sight = JSON.stringify(held.scene?.sight());
  Object.assign(byId('canvas-3d').dataset, { pictures: n, whole: isWhole, meshes: cells, sight });
  const place = String(held.scene?.place());
  if (isWhole && place !== lastPlace) {
    lastPlace = place;
    change('look');
  }
  if (!said || cells !== held.scene?.n_meshes) return;
  byId('view-status').textContent = said;
  said = '';
  settle();
  const size = [step, step, step].join(' × ');
  if (step > 1)
    showNotice(`the 3-D view has no room for all cells, and draws ${size} as one; slices and files have every cell`, 'mesh');
}

/** Nobody waits for cells any more. */
function settle() {
  for (const resolve of waiting.splice(0)) resolve();
}

/** Resolves once the cells of the last mesh are on the canvas, or cannot come there; after a second in any case, as a page that is not seen draws nothing. */
export function cellsAreDrawn() {
  if (held.hasFailed || !state.mesh || (drawn === state.mesh && !said)) return Promise.resolve();
  return new Promise((resolve) => {
    waiting.push(() => resolve(undefined));
    setTimeout(resolve, MOST_WAIT);
  });
}

/** The runs of a mesh for {@link Scene#setCells}; null where there are too many rays, or no view. @param {import('hexcast').Mesh} mesh */
export function runsOf(mesh) {
  return held.hasFailed || mesh.report.rays > MOST_COLUMNS ? null : mesh.columns.all();
}

/** Draws cells, and in stripes the parts that have none. @param {import('hexcast').Mesh} mesh @param {import('hexcast').AllRuns} runs */
function drawCells(mesh, runs) {
  const cell = Math.max(...[0, 1, 2].map((axis) => smallest(mesh.lines, axis)));
  withScene((scene) => {
    drawn = mesh;
    scene.setColours(flagColours(state.hidden));
    scene.setCells(mesh, runs);
    scene.setLost(lostParts(mesh.report), cell);
  });
}

/** Draws the cells of a mesh that is not that of the page. @param {import('hexcast').Mesh} mesh @param {import('hexcast').AllRuns} runs */
export function showPreview(mesh, runs) {
  beforePreview ??= shown;
  drawCells(mesh, runs);
  withScene((scene) => scene.mark(NO_MARKS));
  choose('cells');
}

/** Draws the mesh of the page again. */
export async function endPreview() {
  const { mesh } = state;
  const before = beforePreview;
  beforePreview = null;
  if (!before || !mesh || drawn === mesh) return;
  const runs = await runsOf(mesh)?.catch(() => null);
  if (!runs || mesh !== state.mesh || beforePreview) return;
  drawCells(mesh, runs);
  mark();
  choose(before);
}

/** Disables the tools while there is nothing to show. */
function showTools() {
  const isEmpty = held.hasFailed || (state.geometries.length === 0 && !state.mesh);
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
  const staysWithCells = shown === 'cells' && isLive();
  if (look !== modelsLook && !staysWithCells) choose('model');
  [modelsLook, modelsDrawn] = [look, drawn];
  withScene((scene) => {
    // of a model that is not drawn yet, the view shows the box
    const models = geometries.flatMap(({ corners, ...rest }) =>
      corners ? [{ ...rest, corners, colour: colourOf(rest.flag), isOpen: isOpen(rest.info, corners) }] : [],
    );
    scene.setModels(models);
    const ids = geometries.map(({ id }) => id).join();
    const places = geometries.map(placeKey).join();
    const { models: lastIds, places: lastPlaces } = byId('canvas-3d').dataset;
    if (ids !== lastIds && staysWithCells) isToFit = true;
    else if (ids !== lastIds) fit();
    else if (places !== lastPlaces) fit(true);
    Object.assign(byId('canvas-3d').dataset, { models: ids, places });
  });
}

/** Whether edges of a surface are open, and all its facets are drawn, so that these edges are known. @param {import('../state/state.js').Geometry['info']} info @param {Float32Array} corners */
function isOpen({ closed_parity: isClosed, facets }, corners) {
  return isClosed === false && corners.length === 9 * facets;
}

function recolour() {
  withScene((scene) => {
    const before = shown;
    scene.setColours(flagColours(state.hidden));
    showModels();
    choose(before);
  });
}

/** Shows the models or the cells. @param {'model' | 'cells'} what */
function choose(what) {
  // without models there are the cells only
  const hasModels = state.geometries.length > 0;
  shown = state.mesh && (what === 'cells' || !hasModels) ? 'cells' : 'model';
  showTools();
  inputOf(`show-${shown}`).checked = true;
  byId('section').hidden = shown !== 'cells' || held.hasFailed;
  withScene((scene) => {
    scene.show(shown);
    byId('canvas-3d').setAttribute(
      'aria-label',
      shown === 'cells' ? 'Stair-step surface of the mesh; arrow keys turn it' : 'The model; arrow keys turn it',
    );
  });
}

async function showMesh() {
  const { mesh, runs: promised } = state;
  if (!mesh) {
    mark();
    return clearMessages('mesh');
  }
  if (held.hasFailed) return undefined;
  byId('view-status').textContent = 'Drawing …';
  const runs = await (promised ?? runsOf(mesh))?.catch((error) => error);
  if (mesh !== state.mesh) return undefined;
  clearMessages('mesh');
  if (runs === undefined || runs instanceof Error) {
    byId('view-status').textContent = 'Too large for 3-D';
    settle();
    if (runs) return showError(runs, '3-D');
    return showNotice('there are too many cells for the 3-D view; slices and files have all of them', 'mesh');
  }
  const cells = mesh.report.flags.reduce((sum, { flag, cells }) => sum + (flag ? cells : 0), 0);
  withScene((scene) => {
    drawCells(mesh, runs);
    keepCut(mesh);
    scene.setBox(domainOf(mesh.report));
    mark();
    said = cells > 0 ? `${count(cells)} cells` : 'No cell has a flag.';
    choose(cells > 0 ? 'cells' : 'model');
    if (state.geometries.length === 0 || isToFit) fit();
    isToFit = false;
    const place = takeNumbers('camera', 6);
    if (place) scene.put(place);
    if (!state.live) scrollToView();
  });
  return undefined;
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
  uncut();
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
  if (picture) save(await withLegend(picture, shown === 'cells' ? drawn : null), `${baseName(state.job)}-3d.png`);
}

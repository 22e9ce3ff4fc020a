/** The section of the 3-D view: a plane across an axis, beyond which the cells are cut away. */
import { byId, inputOf, selectOf } from '../elements/dom.js';
import { lookOf, offerLook, takeNumbers } from '../settings/looks.js';
import { change, state } from '../state/state.js';
import { short } from '../text/format.js';
import { cellAt, placeAt } from '../text/places.js';
import { withScene } from './scene_holder.js';

/** Where the section is, in world lengths, so that it stays there. @type {number | null} */
let cutAt = null;
/** The side that the section removes: the one of the camera when its axis was chosen. */
let side = 1;

/** Connects its tools. */
export function startSection() {
  byId('section-axis').addEventListener('change', () => cut(true));
  byId('section-at').addEventListener('input', () => cut());
  offerLook('cut', () => (cutAt === null ? '' : lookOf([Number(selectOf('section-axis').value), side, cutAt])));
}

/** Shows all of the cells. */
export function uncut() {
  selectOf('section-axis').value = '';
  cut();
}

/** The section of a link, or that of the mesh before, at its place in another mesh. @param {import('hexcast').Mesh} mesh */
export function keepCut({ lines, dims }) {
  const [asked, towards, at] = takeNumbers('cut', 3) ?? [];
  if ([0, 1, 2].includes(asked)) {
    selectOf('section-axis').value = String(asked);
    side = towards < 0 ? -1 : 1;
    cutAt = at;
  }
  const axis = Number(selectOf('section-axis').value);
  if (selectOf('section-axis').value !== '' && cutAt !== null) {
    const slider = inputOf('section-at');
    slider.max = String(dims[axis] - 1);
    slider.value = String(cellAt(lines, [cutAt, cutAt, cutAt])[axis]);
  }
  cut(false, cutAt);
}

/**
 * Puts the section where its tools say; `isNew` starts in the middle.
 *
 * @param {boolean} [isNew]
 * @param {number | null} [kept] where it stays, within a cell: meshes in a row would move it, if each took the middle of one
 */
function cut(isNew = false, kept = null) {
  const { mesh } = state;
  const choice = selectOf('section-axis').value;
  const slider = inputOf('section-at');
  slider.disabled = choice === '';
  byId('section-where').textContent = '';
  cutAt = null;
  change('look');
  if (!mesh || choice === '') return withScene((scene) => scene.setSection(null));
  const axis = /** @type {0 | 1 | 2} */ (Number(choice));
  slider.max = String(mesh.dims[axis] - 1);
  if (isNew) slider.value = String(Math.floor(mesh.dims[axis] / 2));
  const index = Number(slider.value);
  // through the middle of cells, so that it shows the plane of this number
  const at = placeAt(mesh.lines, axis, index + 0.5);
  cutAt = kept ?? at;
  const where = `${'xyz'[axis]} = ${short(at)}${mesh.report.unit ? ` ${mesh.report.unit}` : ''}`;
  slider.setAttribute('aria-valuetext', `cell ${index} of ${mesh.dims[axis]}, ${where}`);
  byId('section-where').textContent = where;
  return withScene((scene) => {
    if (isNew) side = scene.sideOf(axis);
    scene.setSection({ axis, side, at });
  });
}

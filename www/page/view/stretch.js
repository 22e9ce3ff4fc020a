/** An axis that is drawn longer than it is, for flat boards: only pictures change, and the line below them says so. */
import { byId, selectOf } from '../elements/dom.js';
import { offerLook, takeLook } from '../settings/looks.js';
import { short } from '../text/format.js';
import { placeAt } from '../text/places.js';
import { change, on, state } from '../state/state.js';

/** Times that each axis is drawn longer than it is. */
export const stretch = [1, 1, 1];

/** Connects the choice. */
export function startStretch() {
  const choice = selectOf('stretch');
  choice.addEventListener('change', take);
  offerLook('stretch', () => choice.value);
  on('mesh', () => {
    const asked = takeLook('stretch');
    if (asked && [...choice.options].some(({ value }) => value === asked)) choice.value = asked;
    take();
  });
}

function take() {
  const [axis, times] = selectOf('stretch').value.split(' ');
  const now = [1, 1, 1];
  if (times) now[Number(axis)] = times === 'fit' ? fitting(Number(axis)) : Number(times);
  byId('stretched').textContent = times
    ? `${'xyz'[Number(axis)]} is drawn ${short(Number(now[Number(axis)].toPrecision(3)))} times as long`
    : '';
  if (String(now) === String(stretch)) return;
  stretch.splice(0, 3, ...now);
  change('stretch');
  change('look');
}

/** Times that make an axis as long as the longest of the mesh. @param {number} axis */
function fitting(axis) {
  const { mesh } = state;
  if (!mesh) return 1;
  const ends = mesh.dims.map((n, at) => placeAt(mesh.lines, at, n) - mesh.lines.origin[at]);
  return Math.max(...ends) / ends[axis];
}

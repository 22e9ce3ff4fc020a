/** Open surfaces of several files that are one closed surface together, such as the patches of a boundary: they are joined on demand. */
import { save } from '../downloads/downloads.js';
import { replaceGeometries } from './files.js';
import { clearMessages, showNotice } from '../elements/messages.js';
import { change, on, placeKey, state } from '../state/state.js';

/** @typedef {import('../state/state.js').Geometry} Geometry */

const HEAD_BYTES = 84;
const FACET_BYTES = 50;

/** The geometries that were looked at last. */
let looked = '';

/** Looks for patches whenever geometries are added, removed or moved. */
export function startPatches() {
  on(['geometries', 'phase'], look);
}

async function look() {
  const { mesher, phase } = state;
  if (!mesher || phase !== 'idle') return;
  const open = state.geometries.filter(
    ({ info, split, corners }) => info.closed_parity === false && !split && corners?.length === 9 * info.facets,
  );
  const parts = open.filter((geometry) => placeKey(geometry) === placeKey(open[0]));
  const key = JSON.stringify(parts.map((geometry) => [geometry.id, placeKey(geometry)]));
  if (key === looked) return;
  looked = key;
  clearMessages('patches');
  change('patches', { patches: null });
  if (parts.length < 2) return;
  const surface = await mesher.read(joined(parts));
  const isClosed = surface.info.closed_parity;
  surface.dispose();
  if (!isClosed || key !== looked) return;
  change('patches', { patches: parts });
  const names = parts.map(({ source }) => source.name);
  const text = `${names.slice(0, -1).join(', ')} and ${names.at(-1)} are parts of one closed surface: apart, none of them has an inside`;
  showNotice(text, 'patches', { label: 'Join the parts', act: joinPatches });
}

/** Puts one closed surface in the place of its parts. */
export async function joinPatches() {
  const { patches } = state;
  if (!patches) return;
  const file = joined(patches);
  clearMessages('patches');
  await replaceGeometries(patches, file);
  const text = `${file.name} was joined on this page: the command and the program that are copied need it as a file`;
  showNotice(text, 'files', { label: `Save ${file.name}`, act: () => save(file, file.name) });
}

/** Binary STL of all facets. @param {Geometry[]} parts */
function joined(parts) {
  const corners = parts.map(({ corners }) => corners ?? new Float32Array());
  const n_facets = corners.reduce((sum, { length }) => sum + length / 9, 0);
  const bytes = new DataView(new ArrayBuffer(HEAD_BYTES + FACET_BYTES * n_facets));
  bytes.setUint32(HEAD_BYTES - 4, n_facets, true);
  let at = HEAD_BYTES;
  for (const numbers of corners) {
    for (let from = 0; from < numbers.length; from += 9, at += FACET_BYTES) {
      // after the normal, which nobody reads
      for (let k = 0; k < 9; k += 1) bytes.setFloat32(at + 12 + 4 * k, numbers[from + k], true);
    }
  }
  return new File([bytes], 'joined.stl', { type: 'model/stl' });
}

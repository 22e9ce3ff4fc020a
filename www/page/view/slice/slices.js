/** The slices across x, y and z, all through the crosshair. */
import { byId } from '../../elements/dom.js';
import { on } from '../../state/state.js';
import { crosshair } from '../crosshair.js';
import { nameCell } from '../readout.js';
import { SlicePane } from './slice_pane.js';

/** Makes the panes, and keeps what they show. */
export function startSlices() {
  const panes = /** @type {const} */ ([0, 1, 2]).map((axis) => new SlicePane(axis));
  const all = (/** @type {(pane: SlicePane) => void} */ act) => () => panes.forEach(act);
  on('mesh', () => {
    nameCell(null);
    if (crosshair.isElsewhere) for (const pane of panes) pane.fit();
  });
  on(
    ['mesh', 'crosshair', 'panes', 'difference'],
    all((pane) => pane.follow()),
  );
  on(
    ['colours', 'legend'],
    all((pane) => pane.repaint()),
  );
  const draw = all((pane) => pane.draw());
  on(['findings', 'stretch', 'measure'], draw);
  byId('mesh-lines').addEventListener('change', draw);
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', draw);
}

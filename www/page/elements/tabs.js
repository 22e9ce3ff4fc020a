/** The tabs of the main view, with the keys that tabs have. */
import { offerLook, takeLook } from '../settings/looks.js';
import { change, on } from '../state/state.js';
import { byId } from './dom.js';

const TABS = ['3d', 'slices'];

/** Connects the tabs. */
export function startTabs() {
  offerLook('tab', () => (byId('panel-slices').hidden ? '' : 'slices'));
  on('mesh', () => takeLook('tab') === 'slices' && select('slices'));
  for (const [at, name] of TABS.entries()) {
    const tab = byId(`tab-${name}`);
    tab.addEventListener('click', () => select(name));
    tab.addEventListener('keydown', ({ key }) => {
      const step = { ArrowRight: 1, ArrowLeft: -1 }[key];
      if (!step) return;
      const next = TABS[(at + step + TABS.length) % TABS.length];
      select(next);
      byId(`tab-${next}`).focus();
    });
  }
}

/** Shows a tab's panel. @param {string} name */
export function select(name) {
  for (const other of TABS) {
    const isThis = other === name;
    byId(`tab-${other}`).setAttribute('aria-selected', String(isThis));
    byId(`tab-${other}`).tabIndex = isThis ? 0 : -1;
    byId(`panel-${other}`).hidden = !isThis;
  }
  change('look');
}

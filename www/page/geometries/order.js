/** The order of the geometries, of which the later wins at equal priority, unless it is open and the other is closed: cards are dragged, or moved with Alt and an arrow key. */
import { byId, make } from '../elements/dom.js';
import { change, state } from '../state/state.js';

/** The card that is dragged. @type {number | null} */
let dragged = null;

/** Connects the list. */
export function startOrder() {
  const list = byId('geometries');
  list.addEventListener('dragover', (event) => {
    const card = /** @type {HTMLElement} */ (event.target).closest('.geometry');
    if (dragged === null || !(card instanceof HTMLElement)) return;
    event.preventDefault();
    const { top, height } = card.getBoundingClientRect();
    const at = [...list.children].indexOf(card) + (event.clientY > top + height / 2 ? 1 : 0);
    for (const other of list.children) other.classList.toggle('before', other === list.children[at]);
    list.dataset.at = String(at);
  });
  list.addEventListener('drop', (event) => {
    if (dragged === null) return;
    event.preventDefault();
    event.stopPropagation();
    const from = state.geometries.findIndex(({ id }) => id === dragged);
    const at = Number(list.dataset.at);
    move(dragged, at > from ? at - 1 : at);
    // its card is another, and has no end of dragging
    dragged = null;
  });
}

/** What a card is dragged by. @param {import('../state/state.js').Geometry} geometry */
export function handle({ id, name }) {
  const start = (/** @type {DragEvent} */ event) => {
    dragged = id;
    event.dataTransfer?.setData('text/plain', String(name));
  };
  const end = () => {
    dragged = null;
    for (const card of byId('geometries').children) card.classList.remove('before');
  };
  return make(
    'button',
    {
      type: 'button',
      className: 'icon handle',
      draggable: true,
      title: 'Drag, or Alt and an arrow key: at equal priority the later part wins. Click to select, with Shift up to here',
      'aria-label': `Select ${name}: Alt and an arrow key move it, Shift and an arrow key select more`,
      on: { dragstart: start, dragend: end },
    },
    '⠿',
  );
}

/** @param {KeyboardEvent} event @param {number} id */
export function moveByKey(event, id) {
  const by = { ArrowUp: -1, ArrowDown: 1 }[event.key];
  if (!event.altKey || !by) return;
  event.preventDefault();
  move(id, state.geometries.findIndex((geometry) => geometry.id === id) + by);
  /** @type {HTMLElement | null} */ (document.querySelector(`.geometry[data-id="${id}"] .handle`))?.focus();
}

/** Moves a geometry to an index. @param {number} id @param {number} to */
function move(id, to) {
  const geometries = state.geometries.filter((geometry) => geometry.id !== id);
  const moved = state.geometries.find((geometry) => geometry.id === id);
  if (!moved || to < 0 || to > geometries.length) return;
  geometries.splice(to, 0, moved);
  change('geometries', { geometries });
  byId('status').textContent = `${moved.name ?? moved.source.name} is part ${to + 1} of ${state.geometries.length}.`;
}

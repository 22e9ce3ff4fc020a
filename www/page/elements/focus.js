/** Keeps the focus where something that has it is removed or hidden: it goes to what is nearest, and never falls to the body. */
import { byId } from './dom.js';

const FOCUSABLE = 'button, input, select, textarea, summary, a[href], [tabindex="0"]';

/** What had the focus last, and all that it lies in. @type {HTMLElement[]} */
let last = [];

/** Watches the focus. */
export function startFocus() {
  document.addEventListener('focusin', ({ target }) => {
    last = [];
    for (let at = /** @type {HTMLElement | null} */ (target); at && at !== document.body; at = at.parentElement) last.push(at);
  });
  new MutationObserver(rescue).observe(document.body, {
    subtree: true,
    childList: true,
    attributeFilter: ['hidden', 'disabled'],
  });
}

function rescue() {
  const lost = last[0];
  if (document.activeElement !== document.body || !lost || isThere(lost)) return;
  const around = last.find((element) => element !== lost && isThere(element));
  const nearest = [...(around?.querySelectorAll(FOCUSABLE) ?? [])].find((element) =>
    isThere(/** @type {HTMLElement} */ (element)),
  );
  const next = /** @type {HTMLElement} */ (nearest ?? byId('view'));
  next.focus({ preventScroll: true });
}

/** @param {HTMLElement} element */
function isThere(element) {
  return element.isConnected && element.checkVisibility() && !(/** @type {HTMLButtonElement} */ (element).disabled);
}

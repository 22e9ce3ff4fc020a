/** Fields with values that are not allowed: the page says so, and meshes nothing until they are corrected. */
import { byId } from '../elements/dom.js';
import { sentence } from '../elements/messages.js';
import { change } from '../state/state.js';

const FORMS = ['geometries', 'settings'];

/** Announces every change of a field, also one that changes no setting because the value is wrong. */
export function startFields() {
  // a choice is read where it has changed, after its input
  for (const event of ['input', 'change']) for (const form of FORMS) byId(form).addEventListener(event, () => change('fields'));
}

/** A sentence about the first wrong field; null where all are right. */
export function wrongField() {
  const inputs = FORMS.flatMap((form) => [...byId(form).querySelectorAll('input')]);
  const wrong = inputs.find((input) => !input.validity.valid);
  if (!wrong) return null;
  const name = wrong.dataset.name ?? wrong.getAttribute('aria-label') ?? wrong.labels?.[0].textContent ?? '';
  const what = name.replace(/\s+/g, ' ').trim();
  const { validationMessage: message } = wrong;
  return sentence(message.startsWith('must ') ? `${what} ${message}` : `${what}: ${message}`);
}

/** Fields that hold what they must not: said in a sentence, and nothing is meshed until they are right. */
import { byId } from './dom.js';
import { sentence } from './messages.js';
import { change } from './state.js';

const FORMS = ['geometries', 'settings'];

/** Hears of every change of a field; those that are wrong change nothing else. */
export function startFields() {
  // a choice is read where it has changed, after its input
  for (const event of ['input', 'change']) for (const form of FORMS) byId(form).addEventListener(event, () => change('fields'));
}

/** What is wrong with the first field that is, with its name; null where all are right. */
export function wrongField() {
  const inputs = FORMS.flatMap((form) => [...byId(form).querySelectorAll('input')]);
  const wrong = inputs.find((input) => !input.validity.valid);
  if (!wrong) return null;
  const name = wrong.getAttribute('aria-label') ?? wrong.labels?.[0].textContent ?? '';
  return sentence(`${name.replace(/\s+/g, ' ').trim()}: ${wrong.validationMessage}`);
}

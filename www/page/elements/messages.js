/** Errors and notices as sentences on the page. */
import { byId, make } from './dom.js';
import { short } from '../text/format.js';

/** @typedef {import('../state/state.js').Remedy} Remedy */

/**
 * Shows what went wrong, with what to do about it. An abort is no error and shows nothing.
 *
 * @param {any} error a HexcastError or any other
 * @param {string} [subject] what failed, such as a file's name
 * @param {Remedy} [remedy] a button with what to do about it
 * @param {string} [about] what `clearMessages` removes together
 */
export function showError(error, subject, remedy, about) {
  if (error?.name === 'AbortError' || error?.code === 'cancelled' || error?.code === 'disposed') return;
  const text = sentence(error?.message ?? String(error));
  const box = make('div', { className: 'message error', role: 'alert' });
  box.append(make('p', {}, subject && !text.includes(subject) ? `${subject}: ${text}` : text));
  if (error?.hint) box.append(make('p', { className: 'hint' }, sentence(error.hint)));
  if (error?.code) box.dataset.code = error.code;
  if (about) box.dataset.about = about;
  if (remedy) box.append(remedyButton(box, remedy));
  box.append(dismissButton(box));
  byId('messages').append(box);
  box.scrollIntoView?.({ block: 'nearest' });
}

/**
 * Shows a remark; one about the mesh that is shown stays until `clearMessages('mesh')`.
 *
 * @param {string} text
 * @param {string} [about] what `clearMessages` removes together
 * @param {Remedy[]} remedies buttons with what to do about it
 */
export function showNotice(text, about = 'files', ...remedies) {
  const box = make('div', { className: 'message', role: 'status', 'data-about': about }, make('p', {}, sentence(text)));
  box.append(...remedies.map((remedy) => remedyButton(box, remedy)), dismissButton(box));
  byId('messages').append(box);
}

/** Removes the messages of what is done anew; by default all but those about the mesh that is shown. @param {string} [about] */
export function clearMessages(about) {
  const chosen = about ? `[data-about=${about}]` : ':not([data-about=mesh])';
  for (const box of byId('messages').querySelectorAll(`.message${chosen}`)) box.remove();
}

/** First letter upper case, a full stop at the end, numbers of six digits. @param {string} text */
export function sentence(text) {
  const trimmed = text.trim();
  const start = /^[a-z][a-z]*[ ,]/.test(trimmed) ? trimmed[0].toUpperCase() + trimmed.slice(1) : trimmed;
  return rounded(/[.!?]$/.test(start) ? start : `${start}.`);
}

/** The numbers of a text with as many digits as people read. @param {string} text */
export function rounded(text) {
  return text.replace(/\d+\.\d{7,}(e-?\d+)?/g, (digits) => short(Number(digits)));
}

/** @param {HTMLElement} box @param {Remedy} remedy */
function remedyButton(box, { label, act }) {
  const click = () => {
    box.remove();
    act();
  };
  return make('button', { type: 'button', className: 'small', on: { click } }, label);
}

/** @param {HTMLElement} box */
function dismissButton(box) {
  return make(
    'button',
    { type: 'button', className: 'icon', 'aria-label': 'Dismiss message', on: { click: () => box.remove() } },
    '×',
  );
}

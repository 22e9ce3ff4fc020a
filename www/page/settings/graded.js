/** The fields of lines that are generated, of cells that differ in size. */
import { byId, inputOf, onInput, put } from '../elements/dom.js';
import { readNumbers, short, writeNumbers } from '../text/format.js';
import { set, state } from '../state/state.js';

/** Connects the fields. */
export function startGraded() {
  onInput('graded', 'change', ({ checked }) => {
    const graded = state.settings.graded ?? Number(short(largestCell()));
    set(checked ? { sizing: 'graded', graded } : { sizing: 'cells' });
  });
  onInput('graded-most', 'input', (input) => {
    const value = readNumbers(input.value);
    const isRight = value !== null && value !== undefined && [value].flat().every((size) => size > 0);
    input.setCustomValidity(isRight ? '' : 'this is a length greater than 0, or three, separated by spaces');
    if (isRight) set({ graded: value });
  });
  onInput('graded-least', 'input', (input) => {
    const value = readNumbers(input.value);
    const isRight = value === null || (typeof value === 'number' && value > 0);
    input.setCustomValidity(isRight ? '' : 'this is a length greater than 0');
    if (isRight) set({ min_size: value });
  });
  onInput('graded-growth', 'input', (input) => {
    if (input.value !== '' && input.checkValidity()) set({ growth: Number(input.value) });
  });
  onInput('graded-absorbing', 'input', (input) => {
    const value = readNumbers(input.value) ?? (input.value.trim() === '' ? 0 : undefined);
    const isRight =
      value !== undefined && [value].flat().every((cells) => Number.isInteger(cells) && cells >= 0 && cells <= 1024);
    input.setCustomValidity(isRight ? '' : 'this is a whole number of cells from 0 to 1024, or three, separated by spaces');
    if (isRight) set({ absorbing: value });
  });
}

/** Size of the largest cell as estimated. */
export function largestCell() {
  const result = state.estimate?.result;
  return Math.max(...(result?.spacing ?? result?.grading?.largest ?? [1]));
}

/** Writes the fields. */
export function showGraded() {
  const { sizing, graded, min_size, growth, absorbing } = state.settings;
  const isGraded = sizing === 'graded';
  inputOf('graded').checked = isGraded;
  byId('graded-fields').hidden = !isGraded;
  // of geometries, too
  document.body.classList.toggle('is-graded', isGraded);
  put('graded-most', writeNumbers(graded));
  put('graded-least', writeNumbers(min_size));
  put('graded-growth', growth);
  put('graded-absorbing', writeNumbers(absorbing));
}

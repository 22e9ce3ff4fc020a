/**
 * What a link has of how the mesh is looked at: the camera, the cut, the crosshair, the panes, hidden flags. Each part of the view says what it has, and takes
 * what a link has for it once there is a mesh.
 */

/** Keys of a link. @typedef {'camera' | 'cut' | 'at' | 'panes' | 'stretch' | 'hidden'} Look */

/** @type {Map<Look, () => string>} */
const texts = new Map();
/** What a link has, until its part of the view takes it. @type {Map<Look, string>} */
const waiting = new Map();
/** @type {readonly Look[]} */
const LOOKS = ['camera', 'cut', 'at', 'panes', 'stretch', 'hidden'];

/** Lets a part of the view say what a link has of it: an empty text where it is as it comes. @param {Look} look @param {() => string} text */
export function offerLook(look, text) {
  texts.set(look, text);
}

/** What a link has for a part of the view, once. @param {Look} look */
export function takeLook(look) {
  const text = waiting.get(look);
  waiting.delete(look);
  return text;
}

/** Numbers that a link has for a part of the view, once; null where there are not so many. @param {Look} look @param {number} n */
export function takeNumbers(look, n) {
  const numbers = takeLook(look)?.split(' ').map(Number) ?? [];
  return numbers.length === n && numbers.every(Number.isFinite) ? numbers : null;
}

/** Numbers as a link has them. @param {number[]} numbers */
export function lookOf(numbers) {
  return numbers.map((number) => Number(number.toPrecision(5))).join(' ');
}

/** Reads what a link has. @param {URLSearchParams} query */
export function expectLooks(query) {
  waiting.clear();
  for (const look of LOOKS) {
    const text = query.get(look);
    if (text) waiting.set(look, text);
  }
}

/** Writes it: what still waits stays. @param {URLSearchParams} query */
export function writeLooks(query) {
  for (const look of LOOKS) {
    const text = waiting.get(look) ?? texts.get(look)?.() ?? '';
    if (text) query.set(look, text);
  }
}

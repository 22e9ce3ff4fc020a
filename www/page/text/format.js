/** Numbers as people read and write them. */

const GROUPED = new Intl.NumberFormat('en', { maximumFractionDigits: 0 });

/** 1234567 -> "1,234,567" @param {number} n */
export function count(n) {
  return GROUPED.format(n);
}

/** 9591000000 -> "9.59 billion"; small counts in full. @param {number} n */
export function roughly(n) {
  return (
    scaled(n, [
      [1e15, 'quadrillion'],
      [1e12, 'trillion'],
      [1e9, 'billion'],
      [1e6, 'million'],
    ]) ?? count(n)
  );
}

/** Decimal units, as disks and downloads count: 1234567 -> "1.23 MB". @param {number} n */
export function bytes(n) {
  return (
    scaled(n, [
      [1e15, 'PB'],
      [1e12, 'TB'],
      [1e9, 'GB'],
      [1e6, 'MB'],
      [1e3, 'kB'],
    ]) ?? `${n} byte${n === 1 ? '' : 's'}`
  );
}

/**
 * Three digits of the largest unit that there is one of, once rounded; null below all units.
 *
 * @param {number} n
 * @param {[number, string][]} units
 */
function scaled(n, units) {
  for (const [size, unit] of units) if (n / size >= 0.9995) return `${(n / size).toPrecision(3)} ${unit}`;
  return null;
}

/** 0.0123 -> "12 ms", 75 -> "1 min 15 s" @param {number} seconds */
export function duration(seconds) {
  if (seconds < 0.9995) return `${Math.max(1, Math.round(seconds * 1000))} ms`;
  if (seconds < 59.5) return `${seconds.toPrecision(2)} s`;
  const whole = Math.round(seconds);
  const minutes = Math.floor(whole / 60);
  if (minutes < 60) return `${minutes} min ${whole % 60} s`;
  return `${Math.floor(minutes / 60)} h ${minutes % 60} min`;
}

/** Six digits, no trailing zeros: 0.30000000000000004 -> "0.3" @param {number} number */
export function short(number) {
  return String(Number(number.toPrecision(6)));
}

/**
 * A length, area (power 2) or volume (power 3) with the unit, if there is one.
 *
 * @param {number} number
 * @param {string | null} unit
 */
export function measure(number, unit, power = 1) {
  const suffix = ['', '', '²', '³'][power];
  return unit ? `${short(number)} ${unit}${suffix}` : short(number);
}

/** [1, 2, 3] -> "1 × 2 × 3" @param {number[]} numbers */
export function times(numbers, write = short) {
  return numbers.map(write).join(' × ');
}

/** The numbers of a text, separated by spaces, commas or slashes; undefined where a part is none. @param {string} text */
export function numbersOf(text) {
  const numbers = text
    .split(/[\s,;/×]+/)
    .filter(Boolean)
    .map(Number);
  return numbers.every(Number.isFinite) ? numbers : undefined;
}

/** The flags of a text, at least one; undefined where it has other things. @param {string} text */
export function flagsOf(text) {
  const flags = numbersOf(text);
  return flags?.length && flags.every((flag) => Number.isInteger(flag) && flag >= 0 && flag <= 255) ? flags : undefined;
}

/**
 * Reads one number or three from a field.
 *
 * @param {string} text
 * @returns {number | [number, number, number] | null | undefined} null where the field is empty, undefined where it is neither
 */
export function readNumbers(text) {
  const numbers = numbersOf(text);
  if (numbers?.length === 0) return null;
  if (numbers?.length === 1) return numbers[0];
  return numbers?.length === 3 ? /** @type {[number, number, number]} */ (numbers) : undefined;
}

/**
 * The lengths of a cell: once where they are equal, to the digits shown.
 *
 * @param {number[]} spacing
 * @param {string | null} [unit]
 */
export function cellSize(spacing, unit) {
  const texts = spacing.map(short);
  const text = texts.every((other) => other === texts[0]) ? texts[0] : texts.join(' × ');
  return unit ? `${text} ${unit}` : text;
}

/** What `readNumbers` reads back. @param {unknown} value */
export function writeNumbers(value) {
  if (value === null || value === undefined) return '';
  return Array.isArray(value) ? value.join(' ') : String(value);
}

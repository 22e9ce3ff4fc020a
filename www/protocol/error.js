/** Errors with the codes of the native library. */

/** @typedef {import('../hexcast.js').ErrorCode} ErrorCode */
/** @typedef {{ hint?: string, details?: Record<string, unknown>, cause?: unknown }} Remarks */

export class HexcastError extends Error {
  /**
   * @param {ErrorCode} code
   * @param {string} message
   * @param {Remarks} [remarks]
   */
  constructor(code, message, { hint = '', details = {}, ...cause } = {}) {
    super(message, cause);
    this.name = 'HexcastError';
    this.code = code;
    this.hint = hint;
    this.details = Object.freeze({ ...details });
  }
}

/** Where the message of a wrong job begins with the key: `geometries[0].flag is 0; ...`, `cells: invalid value ...`. */
const KEY = /^([a-z_]+(?:\[\d+\]|\.[a-z_]+)*)(?: is |: )/;
/** What hints say to users of the command line alone, and what takes its place. @type {[RegExp, string][]} */
const WORDS = [
  [/\(--spill DIR\)/, '(the option spill)'],
  [/with --unit mm \(in a job unit = "mm"\)/, 'with the key unit of the job, such as "mm"'],
  [
    /on the command line FILE:eps_r=2.2, in a job material = {[^}]*}, of flag 0 under \[background\]/,
    'as material of the job: { eps_r: 2.2 }',
  ],
  [/with --cells or --cell-size/, 'with cells or cell_size'],
  [/ \(--[^)]*\)|, --[^)]*(?=\))/g, ''],
  [/the example: hexcast job example, or docs\/job\.schema\.json/, 'the type Job of the package'],
];

/**
 * The error of whatever the core threw: JSON of `{code, message, hint}` from the wasm, or anything else.
 *
 * @param {unknown} thrown
 */
export function asError(thrown) {
  if (thrown instanceof HexcastError) return thrown;
  const facts = typeof thrown === 'string' ? factsOf(thrown) : null;
  if (facts) {
    const key = facts.code.startsWith('job-') ? KEY.exec(facts.message)?.[1] : undefined;
    const hint = WORDS.reduce((text, [words, ours]) => text.replace(words, ours), facts.hint);
    return new HexcastError(facts.code, facts.message, { hint, details: key ? { key } : {} });
  }
  const what = thrown instanceof Error ? `${thrown.name}: ${thrown.message}` : String(thrown);
  if (thrown instanceof RangeError && !/call stack/.test(what))
    return new HexcastError('memory', `there is no memory for the result: ${what}`, { hint: 'ask for less', cause: thrown });
  const hint = 'please report this with the file and the settings';
  return new HexcastError('device-failed', `hexcast failed inside: ${what}`, { hint, cause: thrown });
}

/** @param {string} text @returns {{ code: ErrorCode, message: string, hint: string } | null} */
function factsOf(text) {
  try {
    return JSON.parse(text);
  } catch {
    return null;
  }
}

/** @typedef {{ code: ErrorCode, message: string, remarks: Remarks }} Failure an error as a message contains it */

/** @param {HexcastError} error @returns {Failure} */
export function failureOf({ code, message, hint, details, cause }) {
  return { code, message, remarks: { hint, details, ...(cause === undefined ? {} : { cause }) } };
}

/** @param {Failure} failure */
export function errorOf({ code, message, remarks }) {
  return new HexcastError(code, message, remarks);
}

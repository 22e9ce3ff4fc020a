/** Errors with the codes of the native library. */
export class HexcastError extends Error {
  /**
   * @param {import('./hexcast.js').ErrorCode} code
   * @param {string} message
   * @param {string} [hint]
   */
  constructor(code, message, hint = '') {
    super(message);
    this.name = 'HexcastError';
    this.code = code;
    this.hint = hint;
  }
}

/**
 * The error that the core sent: JSON of `{code, message, hint}`, or anything else that went wrong in there.
 *
 * @param {string} text
 */
export function errorFrom(text) {
  try {
    const { code, message, hint } = JSON.parse(text);
    return new HexcastError(code, message, hint);
  } catch {
    return new HexcastError(
      'device-failed',
      `hexcast failed inside: ${text}`,
      'please report this with the file and the settings',
    );
  }
}

/** A stream of bytes that are made as they are read, also into buffers of the reader's (BYOB). */

/** Bytes that are made in advance. */
const AHEAD = 8 << 20;

/**
 * Makes a stream. `next` resolves to the next bytes, null at the end; they are given away. `cancel` is called where it ends before that, also
 * where `next` fails.
 *
 * @param {{ start: () => Promise<void>, next: () => Promise<Uint8Array<ArrayBuffer> | null>, cancel: () => void }} source
 * @returns {ReadableStream<Uint8Array<ArrayBuffer>>}
 */
export function byteStream({ start, next, cancel }) {
  const pull = async (/** @type {ReadableByteStreamController | ReadableStreamDefaultController} */ controller) => {
    const bytes = await next().catch((error) => {
      cancel();
      throw error;
    });
    if (bytes) return controller.enqueue(bytes);
    controller.close();
    // a reader that waits with a buffer of its own
    if ('byobRequest' in controller) controller.byobRequest?.respond(0);
  };
  try {
    return /** @type {any} */ (new ReadableStream({ type: 'bytes', start, pull, cancel }, { highWaterMark: AHEAD }));
  } catch {
    // browsers without streams of bytes
    return new ReadableStream(/** @type {any} */ ({ start, pull, cancel }), { highWaterMark: 2 });
  }
}

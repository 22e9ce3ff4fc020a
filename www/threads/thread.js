/** A thread of the wasm in a browser: a worker that the worker of the mesher starts, and which shares its memory. */
import init, { runThread } from '../hexcast_threads.js';

addEventListener(
  'message',
  async ({ data: { module, memory, failures } }) => {
    await init({ module_or_path: module, memory });
    postMessage(null);
    try {
      // for as long as the worker lives
      runThread();
    } catch (error) {
      // who started it waits for its work, and hears nothing
      new BroadcastChannel(failures).postMessage(String(error));
    }
  },
  { once: true },
);

/**
 * The worker: runs `core.js` and answers messages `{id, operation, args}` with `{id, result}`, `{id, error}` or, on the way,
 * `{id, progress}`. `{cancel: id}` stops a call. Bytes go back without a copy.
 */
import { Core } from './core.js';

const core = new Core();

addEventListener('message', async ({ data }) => {
  if (data.cancel !== undefined) {
    core.cancel(data.cancel);
    return;
  }
  const { id, operation, args } = data;
  try {
    const progress = (at) => postMessage({ id, progress: at });
    const result = operation === 'open' ? await core.open(args) : await core.run(operation, id, args, progress);
    postMessage({ id, result }, buffers(result));
  } catch (error) {
    postMessage({ id, error: typeof error === 'string' ? error : String(error?.stack ?? error) });
  }
});

/** The buffers of a result that was made for this answer alone. */
function buffers(result) {
  const found = [];
  const look = (value) => {
    if (ArrayBuffer.isView(value)) found.push(value.buffer);
    else if (value && typeof value === 'object') Object.values(value).forEach(look);
  };
  look(result);
  return found;
}

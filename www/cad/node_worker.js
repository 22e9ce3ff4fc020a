/** The thread of Node that converts one file, and is then ended. */
import { createRequire } from 'node:module';
import { parentPort, workerData } from 'node:worker_threads';

import { convert } from './convert.js';

/** @param {{ script: string } & import('./convert.js').Request} data */
async function answer({ script, ...request }) {
  try {
    parentPort?.postMessage({ made: await convert(createRequire(import.meta.url)(script), request) });
  } catch (error) {
    parentPort?.postMessage({ failure: String(error) });
  }
}

answer(workerData);

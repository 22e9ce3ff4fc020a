/** The thread of a page that converts one file, and is then ended. */
import { convert } from './convert.js';
import { makeNoneOfText } from './without_eval.js';

addEventListener('message', async ({ data: { script, ...request } }) => {
  try {
    postMessage({ made: await convert(await load(script), request) });
  } catch (error) {
    postMessage({ failure: String(error) });
  }
});

/** Loads Open CASCADE, a script that is no module: it gives itself to loaders of AMD. @param {string} script its address */
async function load(script) {
  /** @type {import('./convert.js').Occt | undefined} */
  let occt;
  const define = Object.assign((/** @type {[]} */ _names, /** @type {() => typeof occt} */ make) => (occt = make()), {
    amd: true,
  });
  Object.assign(globalThis, { define });
  makeNoneOfText();
  await import(/* webpackIgnore: true */ /* turbopackIgnore: true */ /* @vite-ignore */ script);
  if (!occt) throw new Error(`${script} is not Open CASCADE`);
  return occt;
}

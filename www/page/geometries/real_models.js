/** The samples that are real models: files that are loaded when one is taken. */

/** @type {Record<string, { file: string, url: string }>} */
const MODELS = {
  spot: { file: 'spot.stl', url: new URL('../../../tests/fixtures/spot.stl', import.meta.url).href },
  part: { file: 'machined-part.stl', url: new URL('../../../tests/fixtures/featuretype.stl', import.meta.url).href },
};

/** Where the models come from, and their licences. */
export const LICENCES = new URL('../../../tests/fixtures/README.md?no-inline', import.meta.url).href;

/** Files of a sample; none where it is not one of these. @param {string} id */
export async function realFiles(id) {
  const model = MODELS[id];
  if (!model) return [];
  const answer = await fetch(model.url);
  if (!answer.ok) throw new Error(`${model.file} could not be loaded: status ${answer.status}`);
  return [{ source: new File([await answer.blob()], model.file, { type: 'model/stl' }) }];
}

// HDF5 files as the reference library reads them, compiled to wasm (h5wasm).

import path from 'node:path';
import { pathToFileURL } from 'node:url';

import { TOOLS, ensureTools } from './tools.mjs';

/** @returns {Promise<(file: string) => object>} what tells the attributes of a file, and the type, shape and values of its datasets */
export async function hdf5Reader() {
  await ensureTools();
  const entry = path.join(TOOLS, 'node_modules/h5wasm/dist/node/hdf5_hl.js');
  const { default: h5wasm } = await import(pathToFileURL(entry).href);
  await h5wasm.ready;
  return (name) => {
    const file = new h5wasm.File(name, 'r');
    const typeOf = ({ type, size, signed, vlen, cset }) => ({ type, size, signed, vlen, cset });
    const told = { attributes: {}, datasets: {} };
    for (const [key, { metadata, shape, value }] of Object.entries(file.attrs)) {
      told.attributes[key] = { type: typeOf(metadata), shape, value };
    }
    for (const key of file.keys()) {
      const { metadata, shape, value, filters } = file.get(key);
      told.datasets[key] = { type: typeOf(metadata), shape, value, deflates: filters.map(({ name }) => name) };
    }
    file.close();
    return told;
  };
}

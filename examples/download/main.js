/** Meshes the chosen STL file in a worker, and downloads the cells for ParaView. */
import { createMesher } from 'hexcast';

const [input, state] = ['file', 'state'].map((id) => document.getElementById(id));
const mesher = await createMesher();

async function download([source]) {
  state.textContent = 'Meshing ...';
  const mesh = await mesher.mesh({ geometries: [{ source }], cells: 128 });
  const link = document.createElement('a');
  link.href = URL.createObjectURL(await mesh.blob('vti', { compress: 6 }));
  link.download = source.name.replace(/\.stl$/i, '.vti');
  link.click();
  URL.revokeObjectURL(link.href);
  state.textContent = `${link.download}: ${mesh.dims.join(' x ')} cells`;
  mesh.dispose();
}

input.addEventListener('change', () =>
  download(input.files).catch((error) => {
    // a HexcastError has a sentence, and what to do
    state.textContent = [error.message, error.hint].filter(Boolean).join('; ');
  }),
);
input.disabled = false;

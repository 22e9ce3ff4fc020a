/** Shows how far a mesh is, and lets the user cancel it: the page stays responsive, as the work is done in a worker. */
import { createMesher } from 'hexcast';

const [input, bar, cancel, state] = ['file', 'bar', 'cancel', 'state'].map((id) => document.getElementById(id));
const STAGES = { read: 'Reading', mesh: 'Meshing', write: 'Writing' };
const mesher = await createMesher();

/** @param {import('hexcast').Progress} progress */
function show({ stage, done, total }) {
  bar.value = total > 0 ? done / total : 0;
  state.textContent = `${STAGES[stage]}: ${Math.floor(100 * bar.value)} %`;
}

async function hash([source]) {
  const controller = new AbortController();
  const options = { signal: controller.signal, onProgress: show };
  cancel.onclick = () => controller.abort();
  cancel.disabled = false;
  try {
    const mesh = await mesher.mesh({ geometries: [{ source }], cells: 1000 }, options);
    state.textContent = `SHA-256 of ${mesh.report.cells} flags: ${await mesh.sha256(options)}`;
    mesh.dispose();
  } catch (error) {
    // an abort rejects with the reason of the signal
    state.textContent = controller.signal.aborted ? 'Cancelled' : error.message;
  } finally {
    bar.value = 0;
    cancel.disabled = true;
  }
}

input.addEventListener('change', () => hash(input.files));
input.disabled = false;

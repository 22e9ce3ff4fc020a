/** The page: meshes what is chosen or dropped in a worker, expands its flags on the page's own device, and steps the fluid there. */
import { createMesher } from 'hexcast';
import { realFiles } from '../../www/page/geometries/real_models.js';
import { sampleFiles } from '../../www/page/geometries/sample_models.js';
import { SAMPLES } from '../../www/page/geometries/samples.js';
import { Flow } from './flow.js';

/** Cells along each axis; the model fills 60 % of the longest. */
const N = 64;
const ROOM = 1 / 0.6;
/** Time between two pictures. */
const PICTURE_SECONDS = 0.25;

const element = (id) => document.getElementById(id);
const [sample, file, pause, canvas, state] = ['sample', 'file', 'pause', 'slice', 'state'].map(element);
let isPaused = false;
/** The flow that runs; another takes its place. @type {Flow | null} */
let current = null;

const mesher = await createMesher();
const adapter = await navigator.gpu?.requestAdapter();
const device = await adapter?.requestDevice();
if (!device) throw tell('This browser has no GPU (WebGPU).');

/** Meshes files into a cube of cells around them all. @param {{ source: Blob, settings?: object }[]} files */
async function meshed(files) {
  const surfaces = await Promise.all(files.map(({ source }) => mesher.read(source, { file: source.name })));
  const corner = (side, choose) => [0, 1, 2].map((axis) => choose(...surfaces.map(({ info }) => info.bounding_box[side][axis])));
  const [low, high] = [corner(0, Math.min), corner(1, Math.max)];
  const half = (ROOM * Math.max(...low.map((least, axis) => high[axis] - least))) / 2;
  const middle = low.map((least, axis) => (least + high[axis]) / 2);
  const domain = [...middle.map((at) => at - half), ...middle.map((at) => at + half)];
  const geometries = surfaces.map((source, at) => ({ ...files[at].settings, source, flag: at + 1 }));
  const mesh = await mesher.mesh({ geometries, domain, dims: [N, N, N] });
  for (const surface of surfaces) surface.dispose();
  return mesh;
}

/** Takes files and steps their flow until another takes its place. @param {{ source: Blob, settings?: object }[]} files */
async function run(files) {
  // the one that runs ends by itself
  current = null;
  tell('Meshing ...');
  const mesh = await meshed(files);
  const n_solid = mesh.report.flags.reduce((sum, { cells }) => sum + cells, 0);
  const flags = await mesh.flagsBuffer(device, { box: { start: [0, 0, 0], end: mesh.dims } });
  const flow = new Flow(device, mesh, flags);
  current = flow;
  // for whoever looks at the page from outside
  globalThis.lbm = { mesh, flow };
  let batch = 1;
  while (current === flow) {
    const [start, before] = [performance.now(), flow.steps];
    while (!isPaused && current === flow && performance.now() - start < 1e3 * PICTURE_SECONDS) {
      const begin = performance.now();
      await flow.advance(batch);
      // about ten batches a picture
      if (performance.now() - begin < 100 * PICTURE_SECONDS) batch *= 2;
    }
    const seconds = (performance.now() - start) / 1e3;
    if (current !== flow) break;
    const fastest = await draw(await flow.moments(), mesh);
    const mlups = ((N ** 3 - n_solid) * (flow.steps - before)) / seconds / 1e6;
    if (!isPaused)
      tell(
        `Step ${flow.steps}: ${mlups.toFixed(1)} MLUPS (${N ** 3 - n_solid} fluid cells), fastest ${fastest.toExponential(2)} cells a step`,
      );
    while (isPaused && current === flow) await new Promise((resolve) => setTimeout(resolve, 50));
  }
  flow.dispose();
  mesh.dispose();
}

/** Draws the middle plane across y: solid cells grey, fluid by its speed. Returns the greatest speed. @param {Float32Array} moments */
async function draw(moments, mesh) {
  const y = N / 2;
  const { flags } = await mesh.slice(1, y);
  const speed = Float32Array.from(flags, (_, at) => {
    const cell = 4 * ((at % N) + N * (y + N * Math.floor(at / N)));
    return Math.hypot(moments[cell + 1], moments[cell + 2], moments[cell + 3]);
  });
  const fastest = speed.reduce((most, one) => Math.max(most, one), 0);
  const picture = new ImageData(N, N);
  speed.forEach((one, at) => {
    const share = one / (fastest || 1);
    const colour = flags[at] ? [120, 120, 120] : [255 * share ** 2, 60 + 180 * share, 110 + 80 * (1 - share)];
    // z upwards
    picture.data.set([...colour, 255], 4 * ((at % N) + N * (N - 1 - Math.floor(at / N))));
  });
  canvas.getContext('2d').putImageData(picture, 0, 0);
  return fastest;
}

/** Shows a sentence, and is an error with it. @param {string} what */
function tell(what) {
  state.textContent = what;
  return new Error(what);
}

/** @param {{ source: Blob, settings?: object }[]} files */
const start = (files) => run(files).catch((error) => tell(`${error.message} ${error.hint ?? ''}`));
const startSample = async (id) => start([...(await realFiles(id)), ...sampleFiles(id)]);
const startFiles = (list) => list.length > 0 && start(Array.from(list, (source) => ({ source })));

sample.append(...SAMPLES.map(({ id, title }) => new Option(title, id)));
sample.addEventListener('change', () => startSample(sample.value));
file.addEventListener('change', () => startFiles(file.files));
pause.addEventListener('click', () => {
  isPaused = !isPaused;
  pause.textContent = isPaused ? 'Continue' : 'Pause';
});
for (const type of ['dragover', 'dragleave', 'drop']) {
  addEventListener(type, (event) => {
    event.preventDefault();
    document.body.classList.toggle('over', type === 'dragover');
    if (type === 'drop') startFiles(event.dataTransfer.files);
  });
}
await startSample(sample.value);

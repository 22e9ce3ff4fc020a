/**
 * Flags of a box of cells on a device of the caller's: only runs go there, and the kernel of `shaders/expand.wgsl` makes flags of them. It
 * runs here, where the device is, wherever the mesh is.
 */
import { piecesOf } from './box.js';
import { pause } from '../protocol/call.js';
import { gpuDevice, oneOf, optionsOf, threeNumbers, wrongValue } from './check.js';
import { HexcastError } from '../protocol/error.js';
import { scoped } from '../platform/guarded_device.js';

/**
 * @typedef {import('./box.js').Cell} Cell
 * @typedef {{ dims: Cell, axis: number, runs: (start: Cell, end: Cell, signal?: AbortSignal) => Promise<Uint32Array<ArrayBuffer>>,
 *   text: () => Promise<string> }} Source what a mesh tells of itself, and the kernel
 * @typedef {{ rowBytes: number, perByte: number }} Form how cells lie in memory: bytes of a row along x, cells of a byte
 * @typedef {{ buffer: GPUBuffer, offset: number }} Place where the first row of a piece goes
 */

// Node has no global with these
const USE = { COPY_SRC: 4, COPY_DST: 8, UNIFORM: 64, STORAGE: 128 };
const TEXTURE_USE = { COPY_SRC: 1, COPY_DST: 2, TEXTURE_BINDING: 4 };
/** Bytes of a row in a copy to a texture are a multiple of this. */
const TEXTURE_ROW = 256;
/** Most workgroups along a dimension, everywhere. */
const MOST_GROUPS = 65_535;

/**
 * What is known of a device: the kernel once it is compiled, and how it was lost.
 *
 * @typedef {{ pipeline: GPUComputePipeline | null, lost: GPUDeviceLostInfo | null }} Known
 */
/** @type {WeakMap<GPUDevice, Known>} */
const devices = new WeakMap();

/** @param {Source} source @param {unknown} given @param {import('../hexcast.js').FlagsBufferOptions} [options] */
export async function flagsBuffer(source, given, options) {
  const { box, bits = 8, signal } = optionsOf(options, ['box', 'bits', 'signal']);
  const device = gpuDevice('device', given);
  oneOf('bits', bits, [1, 8]);
  const [start, end] = cornersOf(box, source.dims);
  const [n_x, n_y, n_z] = sizesOf(start, end);
  const perByte = 8 / bits;
  const form = { rowBytes: Math.ceil(n_x / perByte), perByte };
  const size = 4 * Math.ceil((form.rowBytes * n_y * n_z) / 4);
  checkBytes('a buffer', size, device.limits.maxBufferSize, [n_x, n_y, n_z]);
  const create = () => device.createBuffer({ label: 'flags', size, usage: USE.STORAGE | USE.COPY_SRC | USE.COPY_DST });
  return made(source, device, create, async (buffer, act) => {
    for (const [low, high] of piecesOf(start, end)) {
      const runs = await source.runs(low, high, signal);
      const offset = form.rowBytes * (low[1] - start[1] + n_y * (low[2] - start[2]));
      act((pipeline) => expand(device, pipeline, runs, source.axis, sizesOf(low, high), form, { buffer, offset }));
    }
  });
}

/** @param {Source} source @param {unknown} given @param {import('../hexcast.js').FlagsTextureOptions} [options] */
export async function flagsTexture(source, given, options) {
  const { box, format = 'r8uint', signal } = optionsOf(options, ['box', 'format', 'signal']);
  const device = gpuDevice('device', given);
  oneOf('format', format, ['r8uint']);
  const [start, end] = cornersOf(box, source.dims);
  const size = sizesOf(start, end);
  const most = device.limits.maxTextureDimension3D;
  if (Math.max(...size) > most) {
    const message = `a texture of ${size.join(' x ')} cells; those of this device have at most ${most} along an axis`;
    throw new HexcastError('memory', message, { hint: 'take a smaller box', details: { key: 'box', allowed: most } });
  }
  const form = { rowBytes: TEXTURE_ROW * Math.ceil(size[0] / TEXTURE_ROW), perByte: 1 };
  const usage = TEXTURE_USE.TEXTURE_BINDING | TEXTURE_USE.COPY_SRC | TEXTURE_USE.COPY_DST;
  const create = () => device.createTexture({ label: 'flags', size, dimension: '3d', format: 'r8uint', usage });
  return made(source, device, create, async (texture, act) => {
    for (const [low, high] of piecesOf(start, end, form.rowBytes)) {
      const runs = await source.runs(low, high, signal);
      const piece = sizesOf(low, high);
      act((pipeline) => {
        const bytes = form.rowBytes * piece[1] * piece[2];
        const buffer = device.createBuffer({ label: 'rows', size: bytes, usage: USE.STORAGE | USE.COPY_SRC });
        expand(device, pipeline, runs, source.axis, piece, form, { buffer, offset: 0 }, (encoder) => {
          const rows = { buffer, bytesPerRow: form.rowBytes, rowsPerImage: piece[1] };
          encoder.copyBufferToTexture(rows, { texture, origin: [0, low[1] - start[1], low[2] - start[2]] }, piece);
        });
        buffer.destroy();
      });
    }
  });
}

/**
 * Makes a thing on a device and fills it; what the device refuses is an error here, and nothing is left there.
 *
 * @template {{ destroy(): void }} T
 * @param {Source} source
 * @param {GPUDevice} device
 * @param {() => T} create
 * @param {(thing: T, act: (use: (pipeline: GPUComputePipeline) => void) => void) => Promise<void>} fill
 * @returns {Promise<T>}
 */
async function made(source, device, create, fill) {
  const text = await source.text();
  const known = knownOf(device);
  // told at once of a loss that was before
  await pause();
  /** @type {Promise<(GPUError | null)[]>[]} */
  const heard = [];
  const check = async () => {
    const first = (await Promise.all(heard)).flat().find((error) => error !== null);
    if (known.lost) throw lostDevice(known.lost);
    if (first) throw refused(first);
  };
  await check();
  /** @template R @param {() => R} act @returns {R} */
  const within = (act) => scoped(device, act, (errors) => heard.push(errors));
  const thing = within(create);
  try {
    const pipeline = known.pipeline ?? within(() => compiled(device, text));
    await fill(thing, (use) => within(() => use(pipeline)));
    // the first error is the cause of those that follow
    await check();
    known.pipeline = pipeline;
    return thing;
  } catch (error) {
    thing.destroy();
    throw error;
  }
}

/** @param {GPUDevice} device */
function knownOf(device) {
  const found = devices.get(device);
  if (found) return found;
  /** @type {Known} */
  const known = { pipeline: null, lost: null };
  devices.set(device, known);
  device.lost.then((info) => {
    known.lost = info;
  });
  return known;
}

/** @param {GPUDevice} device @param {string} text */
function compiled(device, text) {
  const module = device.createShaderModule({ label: 'expand', code: text });
  return device.createComputePipeline({ label: 'expand', layout: 'auto', compute: { module, entryPoint: 'expand' } });
}

/**
 * Runs the kernel on a piece of a box, and commands after it.
 *
 * @param {GPUDevice} device
 * @param {GPUComputePipeline} pipeline
 * @param {Uint32Array<ArrayBuffer>} packed the first run of each ray of the piece, the number of runs, then the runs
 * @param {number} axis of the rays
 * @param {Cell} piece cells on x, y and z
 * @param {Form} form
 * @param {Place} place
 * @param {(encoder: GPUCommandEncoder) => void} [after]
 */
function expand(device, pipeline, packed, axis, piece, { rowBytes, perByte }, { buffer, offset }, after) {
  const n_offsets = piece.filter((_, at) => at !== axis).reduce((product, n) => product * n, 1) + 1;
  const skip = offset % device.limits.minStorageBufferOffsetAlignment;
  const slab = new Uint32Array([...piece, axis, rowBytes, skip, perByte]);
  const parts = [
    filled(device, slab, USE.UNIFORM),
    filled(device, packed.subarray(0, n_offsets), USE.STORAGE),
    filled(device, packed.subarray(n_offsets), USE.STORAGE),
  ];
  const words = Math.ceil((skip + rowBytes * piece[1] * piece[2]) / 4);
  const resources = [...parts.map((part) => ({ buffer: part })), { buffer, offset: offset - skip, size: 4 * words }];
  const entries = resources.map((resource, binding) => ({ binding, resource }));
  const groups = Math.ceil(words / 64);
  const rows = Math.ceil(groups / MOST_GROUPS);
  const encoder = device.createCommandEncoder();
  const pass = encoder.beginComputePass();
  pass.setPipeline(pipeline);
  pass.setBindGroup(0, device.createBindGroup({ layout: pipeline.getBindGroupLayout(0), entries }));
  pass.dispatchWorkgroups(Math.ceil(groups / rows), rows);
  pass.end();
  after?.(encoder);
  device.queue.submit([encoder.finish()]);
  for (const part of parts) part.destroy();
}

/** A buffer with these words. @param {GPUDevice} device @param {Uint32Array<ArrayBuffer>} words @param {number} usage */
function filled(device, words, usage) {
  // one that is empty cannot be bound
  const buffer = device.createBuffer({ size: Math.max(words.byteLength, 16), usage: usage | USE.COPY_DST });
  device.queue.writeBuffer(buffer, 0, words);
  return buffer;
}

/**
 * The first cell and the end of a box that has cells; by default the whole mesh.
 *
 * @param {any} box
 * @param {Cell} dims
 * @returns {[Cell, Cell]}
 */
function cornersOf(box, dims) {
  if (box === undefined) return [[0, 0, 0], dims];
  if (box === null || typeof box !== 'object') throw wrongValue('box', box, 'an object with start and end');
  const first = threeNumbers('box.start', box.start, [0, 0, 0], /** @type {Cell} */ (dims.map((n) => n - 1)));
  return [first, threeNumbers('box.end', box.end, /** @type {Cell} */ (first.map((n) => n + 1)), dims)];
}

/** @param {Cell} start @param {Cell} end */
function sizesOf(start, end) {
  return /** @type {Cell} */ (end.map((number, axis) => number - start[axis]));
}

/** @param {string} what @param {number} bytes @param {number} allowed @param {Cell} cells */
function checkBytes(what, bytes, allowed, cells) {
  if (bytes <= allowed) return;
  const message = `the flags of ${cells.join(' x ')} cells take ${bytes} bytes; ${what} of this device has at most ${allowed}`;
  const hint = 'take a smaller box, bits: 1, or a device with a larger limit maxBufferSize';
  throw new HexcastError('memory', message, { hint, details: { key: 'box', bytes, allowed } });
}

/** @param {GPUDeviceLostInfo} info */
function lostDevice({ reason, message }) {
  const what = `the device was lost (${reason || 'unknown'})${message && `: ${message}`}`;
  return new HexcastError('device-lost', what, { hint: 'open another device', details: { key: 'device' } });
}

/** @param {GPUError} error */
function refused(error) {
  const code = error.constructor.name === 'GPUOutOfMemoryError' ? 'memory' : 'device-failed';
  const message = `the flags cannot be expanded on this device: ${error.message}`;
  return new HexcastError(code, message, { hint: 'take a smaller box, or read the flags with box()' });
}

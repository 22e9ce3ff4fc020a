/** A flow around the flagged cells of a mesh, on a device: two buffers of distributions that take turns. */
import code from './flow.wgsl?raw';

/** Bytes of the 19 distributions of a cell, and of its moments. */
const [F_BYTES, MOMENT_BYTES] = [19 * 4, 16];

export class Flow {
  /** Steps that were submitted. */
  steps = 0;
  #device;
  #buffers;
  #groups;
  #step;
  #measure;

  /** @param {GPUDevice} device @param {import('hexcast').Mesh} mesh @param {GPUBuffer} flags of the whole mesh, a byte a cell */
  constructor(device, mesh, flags) {
    const [NX, NY, NZ] = mesh.dims;
    const n_cells = NX * NY * NZ;
    const buffer = (size, usage = 0) => device.createBuffer({ size, usage: GPUBufferUsage.STORAGE | usage });
    const moments = buffer(n_cells * MOMENT_BYTES, GPUBufferUsage.COPY_SRC);
    this.#device = device;
    this.#buffers = { flags, f: [buffer(n_cells * F_BYTES), buffer(n_cells * F_BYTES)], moments };
    this.#groups = Math.ceil(n_cells / 64);
    const module = device.createShaderModule({ code });
    const pipeline = (entryPoint) =>
      device.createComputePipeline({ layout: 'auto', compute: { module, entryPoint, constants: { NX, NY, NZ } } });
    [this.#step, this.#measure] = [pipeline('step'), pipeline('measure')];
  }

  /** Submits some steps; resolves when the device has done them. @param {number} n */
  async advance(n) {
    const encoder = this.#device.createCommandEncoder();
    for (let step = 0; step < n; step += 1, this.steps += 1) {
      const [from, to] = this.steps % 2 === 0 ? this.#buffers.f : this.#buffers.f.toReversed();
      this.#dispatch(encoder, this.#step, [this.#buffers.flags, from, to]);
    }
    this.#device.queue.submit([encoder.finish()]);
    await this.#device.queue.onSubmittedWorkDone();
  }

  /** Density less 1 and velocity of every cell: four numbers each, x fastest. @returns {Promise<Float32Array>} */
  async moments() {
    const { f, moments } = this.#buffers;
    const read = this.#device.createBuffer({ size: moments.size, usage: GPUBufferUsage.MAP_READ | GPUBufferUsage.COPY_DST });
    const encoder = this.#device.createCommandEncoder();
    this.#dispatch(encoder, this.#measure, [null, f[this.steps % 2], null, moments]);
    encoder.copyBufferToBuffer(moments, 0, read, 0, moments.size);
    this.#device.queue.submit([encoder.finish()]);
    await read.mapAsync(GPUMapMode.READ);
    const numbers = new Float32Array(read.getMappedRange()).slice();
    read.destroy();
    return numbers;
  }

  /** @param {GPUCommandEncoder} encoder @param {GPUComputePipeline} pipeline @param {(GPUBuffer | null)[]} buffers by their bindings */
  #dispatch(encoder, pipeline, buffers) {
    const entries = buffers.flatMap((buffer, binding) => (buffer ? [{ binding, resource: { buffer } }] : []));
    const pass = encoder.beginComputePass();
    pass.setPipeline(pipeline);
    pass.setBindGroup(0, this.#device.createBindGroup({ layout: pipeline.getBindGroupLayout(0), entries }));
    pass.dispatchWorkgroups(this.#groups);
    pass.end();
  }

  dispose() {
    const { flags, f, moments } = this.#buffers;
    for (const buffer of [flags, ...f, moments]) buffer.destroy();
  }
}

/** The GPU: how it describes its adapter, and how the wasm gets at it without a trace in the caller's globals. */
import { guarded } from '../platform/guarded_device.js';
import { replaced } from '../platform/replaced_property.js';

/** Adapters in software, by how browsers describe them. @type {[RegExp, string][]} */
const SOFTWARE = [
  [/swiftshader/i, 'SwiftShader'],
  [/llvmpipe/i, 'llvmpipe'],
];

/**
 * Describes the adapter that a backend takes, or that of a device. `vendor`, `architecture` and `description` are empty where the
 * browser withholds them; `name` is the description, or vendor and architecture; `software` means that it computes on the processor.
 *
 * @param {GPU | null | undefined} gpu
 * @param {GPUDevice} [device]
 */
export async function describeAdapter(gpu, device) {
  const adapter = device ? null : await gpu?.requestAdapter({ powerPreference: 'high-performance' });
  /** @type {Partial<GPUAdapterInfo>} */
  const info = device?.adapterInfo ?? adapter?.info ?? {};
  const { vendor = '', architecture = '', description = '' } = info;
  const name = description || [vendor, architecture].filter(Boolean).join(' ');
  return { name, vendor, architecture, description, software: Boolean(info.isFallbackAdapter || softwareName(info)) };
}

/** The name of a software adapter, if it is a known one. @param {Partial<GPUAdapterInfo>} info */
function softwareName({ vendor, architecture, description }) {
  const text = [vendor, architecture, description].join(' ');
  return SOFTWARE.find(([pattern]) => pattern.test(text))?.[1];
}

/**
 * Why `auto` does not take an adapter: one in software is slower than the CPU backend. Null for one of hardware.
 *
 * @param {Awaited<ReturnType<typeof describeAdapter>>} adapter
 */
export function whyNotTaken(adapter) {
  if (!adapter.software) return null;
  const name = softwareName(adapter) ?? adapter.name;
  return `the only GPU adapter${name && `, ${name},`} computes on the processor, where the CPU backend is faster`;
}

/** The devices of one mesher: first the caller's if it gives one, then those of a GPU. It is what the wasm takes for `navigator.gpu`. */
export class Devices {
  #gpu;
  #device;
  /** @type {GPUDevice[]} */
  #opened = [];

  /** @param {GPU | null | undefined} gpu @param {GPUDevice} [device] */
  constructor(gpu, device) {
    this.#gpu = gpu;
    this.#device = device;
  }

  /** @param {GPURequestAdapterOptions} options */
  async requestAdapter(options) {
    const device = this.#device;
    this.#device = undefined;
    if (device) return { ...facts(device, device.adapterInfo ?? {}), requestDevice: async () => guarded(device) };
    const adapter = await this.#gpu?.requestAdapter(options);
    if (!adapter) return null;
    const requestDevice = async (/** @type {GPUDeviceDescriptor} */ descriptor) => {
      const opened = await adapter.requestDevice(descriptor);
      this.#opened.push(opened);
      return guarded(opened);
    };
    return { ...facts(adapter, adapter.info), requestDevice };
  }

  /** Frees the devices that are not the caller's. */
  destroy() {
    for (const device of this.#opened.splice(0)) device.destroy();
  }

  /**
   * Calls a function that looks for `navigator.gpu` at once: it finds these devices. Nobody else runs meanwhile, and all is as
   * before when this returns.
   *
   * @template T
   * @param {() => T} look
   * @returns {T}
   */
  whileFound(look) {
    const isKnown = 'Window' in globalThis || 'WorkerGlobalScope' in globalThis;
    // the wasm asks whether it runs in a window or in a worker before it looks
    const act = isKnown ? look : () => replaced(globalThis, 'WorkerGlobalScope', class {}, look);
    return replaced(globalThis, 'navigator', { gpu: this }, act);
  }
}

/** What an adapter tells, as an object of its own. @param {GPUAdapter | GPUDevice} of @param {Partial<GPUAdapterInfo>} info */
function facts({ features, limits }, info) {
  return { features, limits, info };
}

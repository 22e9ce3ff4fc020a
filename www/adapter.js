/** The browser's GPU: how it describes its adapter, and how a device of the caller's reaches the wasm. */

/** Adapters in software, by how browsers describe them. @type {[RegExp, string][]} */
const SOFTWARE = [
  [/swiftshader/i, 'SwiftShader'],
  [/llvmpipe/i, 'llvmpipe'],
];

/**
 * Describes the adapter that a backend takes, or that of a device. `vendor`, `architecture` and `description` are empty where the
 * browser withholds them; `name` is the description, or vendor and architecture; `software` means that it computes on the processor.
 *
 * @param {GPUDevice} [device]
 */
export async function describeAdapter(device) {
  const adapter = device ? null : await navigator.gpu?.requestAdapter({ powerPreference: 'high-performance' });
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

/**
 * Calls `open`, which finds a device of the caller's own. The wasm requests devices from `navigator.gpu` only: that is replaced for
 * one request. A later request, after the device was lost, reaches the browser again.
 *
 * @template T
 * @param {GPUDevice} device
 * @param {() => Promise<T>} open
 */
export async function withDevice(device, open) {
  const before = Object.getOwnPropertyDescriptor(navigator, 'gpu');
  const { features, limits, adapterInfo: info = {} } = device;
  /** @type {object} */
  const substitute = {
    requestAdapter: async () => {
      restore();
      return { features, limits, info, requestDevice: async () => device };
    },
  };
  const restore = () => {
    if (navigator.gpu !== substitute) return;
    if (before) Object.defineProperty(navigator, 'gpu', before);
    else Reflect.deleteProperty(navigator, 'gpu');
  };
  Object.defineProperty(navigator, 'gpu', { value: substitute, configurable: true });
  try {
    return await open();
  } finally {
    restore();
  }
}

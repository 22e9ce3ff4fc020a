/** The browser's side of the GPU: what its adapter is called, and a device of the caller's own in place of a new one. */

/** The software adapters, by what browsers tell of them. @type {[RegExp, string][]} */
const SOFTWARE = [
  [/swiftshader/i, 'SwiftShader'],
  [/llvmpipe/i, 'llvmpipe'],
];

/**
 * What the browser tells of the adapter that a backend takes, or of that of a device: `vendor`, `architecture` and
 * `description`, empty where it does not tell, `name`, the most telling of them, and whether it is `software`, which computes
 * on the processor.
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
  const told = [vendor, architecture, description].join(' ');
  return SOFTWARE.find(([pattern]) => pattern.test(told))?.[1];
}

/**
 * Why an adapter is worse than none: a software one is slower than the CPU backend. Null for one of hardware.
 *
 * @param {Awaited<ReturnType<typeof describeAdapter>>} adapter
 */
export function whyNotTaken(adapter) {
  if (!adapter.software) return null;
  const name = softwareName(adapter) ?? adapter.name;
  return `the only GPU adapter${name && `, ${name},`} computes on the processor, where the CPU backend is faster`;
}

/**
 * Lets `open` find a device of the caller's own. The wasm knows one way to a device, through `navigator.gpu`: what stands
 * there is replaced until it has been asked once, and a later search, after the device was lost, finds the browser's again.
 *
 * @template T
 * @param {GPUDevice} device
 * @param {() => Promise<T>} open
 */
export async function lendDevice(device, open) {
  const before = Object.getOwnPropertyDescriptor(navigator, 'gpu');
  const { features, limits, adapterInfo: info = {} } = device;
  /** @type {object} */
  const lent = {
    requestAdapter: async () => {
      takeBack();
      return { features, limits, info, requestDevice: async () => device };
    },
  };
  const takeBack = () => {
    if (navigator.gpu !== lent) return;
    if (before) Object.defineProperty(navigator, 'gpu', before);
    else Reflect.deleteProperty(navigator, 'gpu');
  };
  Object.defineProperty(navigator, 'gpu', { value: lent, configurable: true });
  try {
    return await open();
  } finally {
    takeBack();
  }
}

/**
 * What browsers and Node have, for programs that are compiled without the types of either: there these are any objects, elsewhere
 * nothing changes.
 */
export {};

declare global {
  interface AbortSignal {}
  interface Blob {}
  interface GPUBuffer {}
  interface GPUTexture {}
  // biome-ignore lint/suspicious/noExplicitAny: as browsers and Node declare it
  interface ReadableStream<R = any> {}
  interface URL {}
  interface Worker {}
  namespace WebAssembly {
    interface Module {}
  }
}

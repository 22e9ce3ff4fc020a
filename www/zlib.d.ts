/** Loads zlib; `source` says where its wasm is. */
export function loadZlib(source: unknown): Promise<object>;

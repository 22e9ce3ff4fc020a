/** Reads a column file, .hxc, in JavaScript alone: `crates/core/src/cells/columns/file.rs` has its layout. */

/**
 * @typedef {object} MeshFile
 * @property {{ cells: number[], offsets: Uint32Array, runs: Uint32Array }} columns as they are drawn
 * @property {{ axis: number, origin: number[], spacing: number[] | null, dims: number[], lists: { x: number[], y: number[], z: number[] } | null }} grid
 * @property {number[]} box six numbers, the least coordinates first
 */

/** Bytes from the first to the body of the head, and of the head of a piece. */
const [BODY, PIECE] = [16, 44];
const SIGNATURE = '\x89HXC\r\n\x1a\n';
/** The last layout that is known. */
const LATEST = 4;
const END = 'ENDS';

/** @param {Uint8Array<ArrayBuffer>} bytes @returns {Promise<MeshFile>} */
export async function readMeshFile(bytes) {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.length);
  if (word(bytes, 0, 8) !== SIGNATURE) throw new Error('the file is no column file (.hxc): it begins with other bytes');
  const version = view.getUint32(8, true);
  if (version > LATEST) throw new Error(`the file has layout ${version}, and this viewer reads up to ${LATEST}: update hexcast`);
  const end = BODY + view.getUint32(12, true);
  if (end + 4 > bytes.length || crc32(bytes.subarray(0, end)) !== view.getUint32(end, true))
    throw new Error('the head of the file is damaged: copy it or write it again');
  let at = BODY;
  if (version > 1) at += view.getUint8(at) ? 33 : 1;
  const dims = [0, 4, 8].map((by) => view.getUint32(at + by, true));
  const [axis, compression, kind] = [12, 13, 14].map((by) => view.getUint8(at + by));
  const numbers = (/** @type {number} */ from, /** @type {number} */ n) =>
    Array.from({ length: n }, (_, k) => view.getFloat64(from + 8 * k, true));
  at += 16;
  /** @type {MeshFile['grid']} */
  const grid = { axis, origin: numbers(at, 3), spacing: null, dims, lists: null };
  let high;
  if (kind === 0) {
    const spacing = numbers(at + 24, 3);
    grid.spacing = spacing;
    high = dims.map((n, k) => grid.origin[k] + n * spacing[k]);
  } else {
    const ends = dims.map((_, k) => at + 8 * dims.slice(0, k).reduce((sum, n) => sum + n + 1, 0));
    const [x, y, z] = ends.map((from, k) => numbers(from, dims[k] + 1));
    grid.lists = { x, y, z };
    grid.origin = [x[0], y[0], z[0]];
    high = [x, y, z].map((list) => list[list.length - 1]);
  }
  const across = [0, 1, 2].filter((one) => one !== axis);
  const n_rays = dims[across[0]] * dims[across[1]];
  const offsets = new Uint32Array(n_rays + 1);
  /** @type {Uint32Array[]} */
  const parts = [];
  let [ray, n_runs] = [0, 0];
  /** Some of the bytes, whose sum is at a place. @param {number} from @param {number} end @param {number} sum */
  const checked = (from, end, sum) => {
    if (end > bytes.length || sum + 4 > bytes.length)
      throw new Error('the file ends before its cells do: it was not written to its end, or not loaded whole');
    const some = bytes.subarray(from, end);
    if (crc32(some) !== view.getUint32(sum, true))
      throw new Error(`the file is damaged after byte ${at}: copy it or write it again`);
    return some;
  };
  for (at = end + 4; word(bytes, at, 4) !== END; ) {
    checked(at, at + PIECE - 4, at + PIECE - 4);
    const [rays, runs, , stored] = [4, 8, 12, 16].map((by) => view.getUint32(at + by, true));
    const content = checked(at + PIECE, at + PIECE + stored, at + 20);
    parts.push(runsOf(compression ? await inflated(content) : content, rays, runs, offsets, ray));
    ray += rays;
    n_runs += runs;
    at += PIECE + stored;
  }
  if (ray !== n_rays) throw new Error(`the file has ${ray} of its ${n_rays} rays: write it again`);
  const all = new Uint32Array(n_runs);
  for (let part = 0, from = 0; part < parts.length; from += parts[part].length, part += 1) all.set(parts[part], from);
  const cells = [dims[across[0]], dims[across[1]], dims[axis]];
  return { columns: { cells, offsets, runs: all }, grid, box: [...grid.origin, ...high] };
}

/** The runs of a piece as `first cell << 8 | flag`; `offsets` gets the ends of its rays. @param {Uint8Array} bytes @param {number} n_rays @param {number} n_runs @param {Uint32Array} offsets @param {number} ray */
function runsOf(bytes, n_rays, n_runs, offsets, ray) {
  let at = 0;
  const varint = () => {
    for (let value = 0, scale = 1; ; scale *= 128) {
      const byte = bytes[at++];
      value += (byte & 127) * scale;
      if (byte < 128 || byte === undefined) return value;
    }
  };
  for (let k = 0; k < n_rays; k += 1) offsets[ray + k + 1] = offsets[ray + k] + varint();
  const runs = new Uint32Array(n_runs);
  const flags = bytes.length - n_runs;
  let [n, before, n_before] = [0, 0, 0];
  for (let k = 0; k < n_rays; k += 1) {
    const n_own = offsets[ray + k + 1] - offsets[ray + k];
    for (let own = 0; own < n_own; own += 1) {
      const code = varint();
      const guess = own < n_before ? runs[before + own] >>> 8 : own > 0 ? runs[n + own - 1] >>> 8 : 0;
      const first = guess + (code % 2 ? -(code + 1) / 2 : code / 2);
      runs[n + own] = (first << 8) | bytes[flags + n + own];
    }
    [before, n_before] = [n, n_own];
    n += n_own;
  }
  return runs;
}

/** Remainders of the bytes, for the sums of zlib. */
const TABLE = Uint32Array.from({ length: 256 }, (_, byte) => {
  let rest = byte;
  for (let bit = 0; bit < 8; bit += 1) rest = rest & 1 ? (rest >>> 1) ^ 0xedb88320 : rest >>> 1;
  return rest;
});

/** @param {Uint8Array} bytes */
function crc32(bytes) {
  let sum = -1;
  for (let at = 0; at < bytes.length; at += 1) sum = TABLE[(sum ^ bytes[at]) & 255] ^ (sum >>> 8);
  return ~sum >>> 0;
}

/** @param {Uint8Array<ArrayBuffer>} bytes */
async function inflated(bytes) {
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream('deflate'));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** @param {Uint8Array} bytes @param {number} at @param {number} n */
function word(bytes, at, n) {
  return String.fromCharCode(...bytes.subarray(at, at + n));
}

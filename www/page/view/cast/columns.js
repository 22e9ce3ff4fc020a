/** The runs of a mesh as they are drawn: packed, in tiles, and coarser by a factor of two each. */

/**
 * Runs along w in columns across it. Column u + n_u * v has the runs from `offsets[u + n_u * v]` to that of the next; a run is
 * `cell << 8 | flag` and lasts to the next one or the end. Before the first the flag is 0.
 *
 * @typedef {object} Columns
 * @property {number[]} cells n_u, n_v, n_w
 * @property {Uint32Array} offsets n_u * n_v + 1
 * @property {Uint32Array} runs
 */

/** Columns along an edge of a tile. */
const TILE = 8;

/** Packs runs, in the place of the first cells. @param {import('hexcast').AllRuns} all @param {number[]} cells @returns {Columns} */
export function packed({ offsets, starts, flags }, cells) {
  for (let run = 0; run < starts.length; run += 1) starts[run] = (starts[run] << 8) | flags[run];
  return { cells, offsets, runs: starts };
}

/** Cells of each flag. @param {Columns} columns */
export function countsOf({ cells, offsets, runs }) {
  const counts = new Float64Array(256);
  for (let column = 0; column + 1 < offsets.length; column += 1) {
    const end = offsets[column + 1];
    for (let run = offsets[column]; run < end; run += 1) {
      counts[runs[run] & 255] += (run + 1 < end ? runs[run + 1] >>> 8 : cells[2]) - (runs[run] >>> 8);
    }
  }
  return counts;
}

/**
 * Ranges of cells with flags in the tiles of 8 and of 64 columns: the first, and the end of the last; none where the first is not before it.
 *
 * @param {Columns} columns
 * @returns {[Uint32Array, Uint32Array]}
 */
export function tilesOf({ cells: [nu, nv, nw], offsets, runs }) {
  const across = Math.ceil(nu / TILE);
  const small = emptyTiles(across * Math.ceil(nv / TILE));
  for (let v = 0, column = 0; v < nv; v += 1) {
    for (let u = 0; u < nu; u += 1, column += 1) {
      const [first, end] = [offsets[column], offsets[column + 1]];
      if (first === end) continue;
      // the first run has a flag; the last has one only where it goes to the end
      const last = runs[end - 1];
      widen(small, (u >> 3) + across * (v >> 3), runs[first] >>> 8, last & 255 ? nw : last >>> 8);
    }
  }
  const acrossLarge = Math.ceil(nu / TILE ** 2);
  const large = emptyTiles(acrossLarge * Math.ceil(nv / TILE ** 2));
  for (let tile = 0; 2 * tile < small.length; tile += 1) {
    const [u, v] = [tile % across, Math.floor(tile / across)];
    widen(large, (u >> 3) + acrossLarge * (v >> 3), small[2 * tile], small[2 * tile + 1]);
  }
  return [small, large];
}

/** Signed numbers must hold them, too. */
const NONE = 2 ** 31 - 1;

/** @param {number} n */
function emptyTiles(n) {
  return Uint32Array.from({ length: 2 * n }, (_, at) => (at % 2 ? 0 : NONE));
}

/** @param {Uint32Array} tiles @param {number} tile @param {number} first @param {number} end */
function widen(tiles, tile, first, end) {
  if (first < tiles[2 * tile]) tiles[2 * tile] = first;
  if (end > tiles[2 * tile + 1]) tiles[2 * tile + 1] = end;
}

/**
 * Columns of cells twice as long each way. A cell has the flag of the least rank that any of its eight has, so that what is rare, such as
 * a wire, stays; ranks of 0 are those of what is not seen.
 *
 * @param {Columns} columns
 * @param {Uint8Array} ranks of all flags
 * @returns {Columns}
 */
export function coarser({ cells: [nu, nv, nw], offsets, runs }, ranks) {
  const cells = [nu, nv, nw].map((n) => Math.ceil(n / 2));
  const coarse = new Uint32Array(cells[0] * cells[1] + 1);
  // a run more than the columns have is that of the end
  const made = new Uint32Array(runs.length + coarse.length);
  const merge = new Merge(runs, nw, ranks);
  let n = 0;
  for (let v = 0, column = 0; v < cells[1]; v += 1) {
    for (let u = 0; u < cells[0]; u += 1, column += 1) {
      merge.clear();
      for (let j = 2 * v; j < Math.min(2 * v + 2, nv); j += 1) {
        const fine = 2 * u + nu * j;
        merge.add(offsets[fine], offsets[fine + 1]);
        if (2 * u + 1 < nu) merge.add(offsets[fine + 1], offsets[fine + 2]);
      }
      n = merge.write(made, n);
      coarse[column + 1] = n;
    }
  }
  return { cells, offsets: coarse, runs: made.slice(0, n) };
}

/** Merges the runs of four columns or fewer into one of half as many cells. */
class Merge {
  /** Run of each column that is looked at, and the end. */
  #at = [0, 0, 0, 0];
  #end = [0, 0, 0, 0];
  #n = 0;
  #next = 0;
  /** @type {Uint32Array} */
  #runs;
  /** @type {number} */
  #nw;
  /** @type {Uint8Array} */
  #ranks;

  /** @param {Uint32Array} runs @param {number} nw @param {Uint8Array} ranks */
  constructor(runs, nw, ranks) {
    this.#runs = runs;
    this.#nw = nw;
    this.#ranks = ranks;
  }

  clear() {
    this.#n = 0;
  }

  /** @param {number} first @param {number} end */
  add(first, end) {
    if (first === end) return;
    this.#at[this.#n] = first;
    this.#end[this.#n] = end;
    this.#n += 1;
  }

  /** Writes the runs of the coarse column from `n` on, and returns where they end. @param {Uint32Array} to @param {number} n */
  write(to, n) {
    if (this.#n === 0) return n;
    const most = Math.ceil(this.#nw / 2);
    let [last, place, written] = [0, 0, n];
    while (place < most) {
      const flag = this.#flagAt(place);
      if (flag !== last) {
        to[written++] = (place << 8) | flag;
        last = flag;
      }
      place = Math.min(this.#next, most);
    }
    return written;
  }

  /** The flag of a coarse cell; `#next` becomes the next one that may have another. @param {number} place */
  #flagAt(place) {
    const [runs, ranks] = [this.#runs, this.#ranks];
    let flag = 0;
    this.#next = NONE;
    for (let column = 0; column < this.#n; column += 1) {
      const end = this.#end[column];
      let at = this.#at[column];
      // past all that ends before the cell
      while (at < end && this.#stop(at, end) <= 2 * place) at += 1;
      this.#at[column] = at;
      // two runs at most lie in two cells
      for (let run = at; run < Math.min(at + 2, end); run += 1) {
        const begin = runs[run] >>> 9;
        if (begin > place) {
          this.#next = Math.min(this.#next, begin);
          break;
        }
        this.#next = Math.min(this.#next, Math.max(this.#stop(run, end) >> 1, place + 1));
        const own = runs[run] & 255;
        if (ranks[own] !== 0 && (flag === 0 || ranks[own] < ranks[flag])) flag = own;
      }
    }
    return flag;
  }

  /** The cell before which a run ends. @param {number} run @param {number} end */
  #stop(run, end) {
    return run + 1 < end ? this.#runs[run + 1] >>> 8 : this.#nw;
  }
}

// The runs that the 3-D view draws: coarser ones, and tiles of columns, held to what single cells say.

import assert from 'node:assert/strict';

import { test } from '@playwright/test';

import { coarser, countsOf, packed, tilesOf } from '../../www/page/view/cast/columns.js';
import { randomFrom } from './random.mjs';

/** Flags of a box of cells, u fastest, that change every few cells along w. */
function randomFlags([nu, nv, nw], random) {
  const flags = new Uint8Array(nu * nv * nw);
  for (let column = 0; column < nu * nv; column += 1) {
    const isEmpty = random() < 0.2;
    let flag = 0;
    for (let w = 0; w < nw; w += 1) {
      if (random() < 0.4) flag = isEmpty ? 0 : Math.floor(4 * random());
      flags[column + nu * nv * w] = flag;
    }
  }
  return flags;
}

/** The runs of all columns as a mesh gives them: none of flag 0 before the first other. */
function runsOf(flags, [nu, nv, nw]) {
  const [offsets, starts, own] = [[0], [], []];
  for (let column = 0; column < nu * nv; column += 1) {
    for (let w = 0, last = 0; w < nw; w += 1) {
      const flag = flags[column + nu * nv * w];
      if (flag !== last) {
        starts.push(w);
        own.push(flag);
      }
      last = flag;
    }
    offsets.push(starts.length);
  }
  return { offsets: Uint32Array.from(offsets), starts: Uint32Array.from(starts), flags: Uint8Array.from(own) };
}

/** Flags of the cells again. */
function expanded({ cells: [nu, nv, nw], offsets, runs }) {
  const flags = new Uint8Array(nu * nv * nw);
  for (let column = 0; column < nu * nv; column += 1) {
    for (let run = offsets[column]; run < offsets[column + 1]; run += 1) {
      for (let w = runs[run] >>> 8; w < nw; w += 1) flags[column + nu * nv * w] = runs[run] & 255;
    }
  }
  return flags;
}

/** Flags of cells twice as long: of the eight, that of the least rank that is not 0. */
function coarserFlags(flags, [nu, nv, nw], ranks) {
  const [mu, mv, mw] = [nu, nv, nw].map((n) => Math.ceil(n / 2));
  const rankOf = (flag) => ranks[flag] || Infinity;
  return Uint8Array.from({ length: mu * mv * mw }, (_, cell) => {
    const [u, v, w] = [cell % mu, Math.floor(cell / mu) % mv, Math.floor(cell / mu / mv)];
    let best = 0;
    for (let at = 0; at < 8; at += 1) {
      const [i, j, k] = [2 * u + (at & 1), 2 * v + ((at >> 1) & 1), 2 * w + (at >> 2)];
      if (i >= nu || j >= nv || k >= nw) continue;
      const flag = flags[i + nu * (j + nv * k)];
      if (rankOf(flag) < rankOf(best)) best = flag;
    }
    return best;
  });
}

for (const [seed, cells] of [
  [1, [7, 5, 40]],
  [2, [16, 9, 33]],
  [3, [1, 1, 5]],
  [4, [70, 11, 12]],
]) {
  test(`coarser runs have the rarest flag of eight cells, and tiles the range of theirs: ${cells}, seed ${seed}`, () => {
    const flags = randomFlags(cells, randomFrom(seed));
    const columns = packed(runsOf(flags, cells), cells);
    assert.deepEqual(expanded(columns), flags);
    const counts = countsOf(columns);
    for (const flag of [1, 2, 3]) assert.equal(counts[flag], flags.filter((one) => one === flag).length, `flag ${flag}`);
    // flag 2 is hidden
    const ranks = new Uint8Array(256);
    [ranks[3], ranks[1]] = [1, 2];
    const once = coarser(columns, ranks);
    const flagsOnce = coarserFlags(flags, cells, ranks);
    assert.deepEqual(expanded(once), flagsOnce);
    assert.deepEqual(expanded(coarser(once, ranks)), coarserFlags(flagsOnce, once.cells, ranks));
    const [nu, nv, nw] = cells;
    for (const [at, edge] of [8, 64].entries()) {
      const tiles = tilesOf(columns)[at];
      const across = Math.ceil(nu / edge);
      assert.equal(tiles.length, 2 * across * Math.ceil(nv / edge));
      for (let tile = 0; 2 * tile < tiles.length; tile += 1) {
        const isIn = (cell) =>
          Math.floor((cell % nu) / edge) === tile % across &&
          Math.floor((Math.floor(cell / nu) % nv) / edge) === Math.floor(tile / across);
        const ws = [...flags.keys()].filter((cell) => flags[cell] > 0 && isIn(cell)).map((cell) => Math.floor(cell / nu / nv));
        const [low, high] = ws.length > 0 ? [Math.min(...ws), Math.max(...ws) + 1] : [nw, 0];
        if (ws.length > 0) assert.deepEqual([tiles[2 * tile], tiles[2 * tile + 1]], [low, high], `tile ${tile} of ${edge}`);
        else assert.ok(tiles[2 * tile] >= tiles[2 * tile + 1]);
      }
    }
  });
}

//! Puts the runs that `shaders/columns.wgsl` and `columns_deep.wgsl` wrote, chunk by chunk in no order, into the order of the rays.
//!
//! A chunk is one row of rays of one bin, at most [`BIN`] rays: the place of its runs, and how many each ray has, 4 bits each;
//! a place holds [`PLACE`] runs, and each ray begins a new one. Or, if some have more, [`DEEP`]: then the counts stand before
//! the runs, a word each, without gaps.
//! Cost: each run is copied once, as it has to be anyway to come out of the device's memory.

use super::layout::{BIN, Params};
use crate::parallel::*;

/// Marks a chunk with its counts before its runs; `DEEP` in `shaders/shared/chunks.wgsl`.
const DEEP: u32 = u32::MAX;
/// Words of a place.
const PLACE: usize = 4;
/// Most runs of a ray of a chunk that is not deep.
const MOST_RUNS: usize = 2 * PLACE;
/// Ray rows that one task puts in order.
const ROWS: usize = 16;

/// Where a chunk's runs are in `raw`, and how many each ray has.
#[derive(Clone, Copy)]
enum Chunk<'a> {
    Packed { raw: &'a [u32], counts: u32 },
    Deep { runs: &'a [u32], counts: &'a [u32] },
}

impl Chunk<'_> {
    fn new([place, counts]: [u32; 2], raw: &[u32]) -> Chunk<'_> {
        let raw = &raw[PLACE * place as usize..];
        if counts == DEEP {
            let (counts, runs) = raw.split_at(BIN as usize);
            return Chunk::Deep { runs, counts };
        }
        Chunk::Packed { raw, counts }
    }

    fn n_runs(&self) -> usize {
        match *self {
            Chunk::Packed { counts, .. } => sum_of_counts(counts),
            Chunk::Deep { counts, .. } => counts.iter().map(|&n| n as usize).sum(),
        }
    }

    /// Copies the runs of its rays to the front of `out`, which may be overwritten beyond them, and notes where each ends;
    /// returns their number.
    fn copy_to(&self, out: &mut [u32], first: u32, ends: &mut [u32]) -> usize {
        let mut at = 0;
        match *self {
            Chunk::Packed { mut raw, counts } => {
                for (ray, end) in ends.iter_mut().enumerate() {
                    let n = (counts >> (4 * ray)) as usize & 15;
                    // always as many, where there is room: far cheaper than as many as there are
                    match (out.get_mut(at..at + MOST_RUNS), raw.get(..MOST_RUNS)) {
                        (Some(out), Some(runs)) => out.copy_from_slice(runs),
                        _ => out[at..at + n].copy_from_slice(&raw[..n]),
                    }
                    raw = &raw[n.next_multiple_of(PLACE)..];
                    at += n;
                    *end = first + at as u32;
                }
            }
            Chunk::Deep { runs, counts } => {
                for (end, &n) in ends.iter_mut().zip(counts) {
                    at += n as usize;
                    *end = first + at as u32;
                }
                out[..at].copy_from_slice(&runs[..at]);
            }
        }
        at
    }
}

/// The columns of a band: the end of each ray's runs, and the runs.
///
/// `chunks` holds two words for each row of each bin, `n_across` chunks a ray row; `raw` the runs that they point into.
pub(crate) fn gather(params: &Params, chunks: &[[u32; 2]], raw: &[u32]) -> (Vec<u32>, Vec<u32>) {
    let n_i = params.n_i as usize;
    let n_across = params.n_across as usize;
    let totals: Vec<usize> = chunks
        .par_chunks(ROWS * n_across)
        .map(|part| part.iter().map(|&chunk| Chunk::new(chunk, raw).n_runs()).sum())
        .collect();
    let mut ends = vec![0; params.n_rays() as usize];
    let mut runs = vec![0; totals.iter().sum()];
    let mut tasks = Vec::with_capacity(totals.len());
    let (mut rest, mut before) = (&mut runs[..], 0);
    for ((part, ends), &total) in chunks.chunks(ROWS * n_across).zip(ends.chunks_mut(ROWS * n_i)).zip(&totals) {
        let (own, after) = rest.split_at_mut(total);
        tasks.push((part, ends, own, before));
        rest = after;
        before += total;
    }
    tasks.into_par_iter().for_each(|(part, ends, own, before)| {
        let mut at = 0;
        for (row, ends) in part.chunks(n_across).zip(ends.chunks_mut(n_i)) {
            for (&chunk, ends) in row.iter().zip(ends.chunks_mut(BIN as usize)) {
                at += Chunk::new(chunk, raw).copy_to(&mut own[at..], (before + at) as u32, ends);
            }
        }
    });
    (ends, runs)
}

/// The sum of eight counts of 4 bits.
fn sum_of_counts(counts: u32) -> usize {
    let pairs = (counts & 0x0f0f_0f0f) + ((counts >> 4) & 0x0f0f_0f0f);
    (pairs.wrapping_mul(0x0101_0101) >> 24) as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_eight_counts() {
        assert_eq!(sum_of_counts(0x8888_8888), 64);
        assert_eq!(sum_of_counts(0x8000_0001), 9);
    }

    #[test]
    fn runs_come_out_in_the_order_of_the_rays() {
        // two rows of 10 rays: chunks of 8 and 2 rays, written in another order than that of the rays
        let params = Params { n_i: 10, n_across: 2, first_row: 4, end_row: 6, ..bytemuck::Zeroable::zeroed() };
        let chunks = [[5, 0x2000_0001], [0, 0x12], [2, DEEP], [7, 0x50]];
        #[rustfmt::skip]
        let raw = [
            10, 11, 99, 99, 12, 99, 99, 99,
            0, 0, 2, 0, 0, 0, 0, 0, 14, 15, 99, 99,
            1, 99, 99, 99, 2, 3, 99, 99,
            20, 21, 22, 23, 24, 99, 99, 99,
        ];
        let (ends, runs) = gather(&params, &chunks, &raw);
        assert_eq!(runs, [1, 2, 3, 10, 11, 12, 14, 15, 20, 21, 22, 23, 24]);
        assert_eq!(ends[..10], [1, 1, 1, 1, 1, 1, 1, 3, 5, 6]);
        assert_eq!(ends[10..], [6, 6, 8, 8, 8, 8, 8, 8, 8, 13]);
    }
}

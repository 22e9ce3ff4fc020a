//! Puts the runs that `shaders/columns.wgsl` and `columns_deep.wgsl` wrote, chunk by chunk in no order, into the order of the rays.
//!
//! A chunk is one row of rays of one bin, at most [`BIN`] rays: where its runs start, and how many each ray has, 4 bits each;
//! or, if some have more, [`DEEP`]: then the counts stand before the runs, a word each.
//! Cost: each run is copied once, as it has to be anyway to come out of the device's memory.

use super::layout::{BIN, Params};
use crate::parallel::*;

/// Marks a chunk with its counts before its runs; `DEEP` in `shaders/shared/chunks.wgsl`.
const DEEP: u32 = u32::MAX;
/// Ray rows that one task puts in order.
const ROWS: usize = 16;

/// Where a chunk's runs are in `raw`, and how many each ray has.
#[derive(Clone, Copy)]
struct Chunk<'a> {
    start: usize,
    counts: Counts<'a>,
}

#[derive(Clone, Copy)]
enum Counts<'a> {
    Packed(u32),
    Words(&'a [u32]),
}

impl Chunk<'_> {
    fn new([start, counts]: [u32; 2], raw: &[u32]) -> Chunk<'_> {
        let start = start as usize;
        if counts == DEEP {
            let first = start + BIN as usize;
            return Chunk { start: first, counts: Counts::Words(&raw[start..first]) };
        }
        Chunk { start, counts: Counts::Packed(counts) }
    }

    fn n_runs(&self) -> usize {
        match self.counts {
            Counts::Packed(counts) => sum_of_counts(counts),
            Counts::Words(words) => words.iter().map(|&n| n as usize).sum(),
        }
    }

    fn count(&self, ray: usize) -> u32 {
        match self.counts {
            Counts::Packed(counts) => (counts >> (4 * ray)) & 15,
            Counts::Words(words) => words[ray],
        }
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
                let chunk = Chunk::new(chunk, raw);
                let n = chunk.n_runs();
                own[at..at + n].copy_from_slice(&raw[chunk.start..chunk.start + n]);
                let mut end = (before + at) as u32;
                for (ray, slot) in ends.iter_mut().enumerate() {
                    end += chunk.count(ray);
                    *slot = end;
                }
                at += n;
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
        let chunks = [[6, 0x2000_0001], [1, 0x12], [9, DEEP], [4, 0x11]];
        let raw = [99, 10, 11, 12, 20, 21, 1, 2, 3, 0, 0, 2, 0, 0, 0, 0, 0, 14, 15];
        let (ends, runs) = gather(&params, &chunks, &raw);
        assert_eq!(runs, [1, 2, 3, 10, 11, 12, 14, 15, 20, 21]);
        assert_eq!(ends[..10], [1, 1, 1, 1, 1, 1, 1, 3, 5, 6]);
        assert_eq!(ends[10..], [6, 6, 8, 8, 8, 8, 8, 8, 9, 10]);
    }
}

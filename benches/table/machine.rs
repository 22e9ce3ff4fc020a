//! What the machine could do at most: loops over all cores that do nothing but what a pass cannot leave out.
//!
//! `benches/limits.mjs` holds the passes against these. The drivers of GPUs in software share these cores. Cost: a second.

use std::hint::black_box;
use std::time::Instant;

use rayon::prelude::*;
use serde::Serialize;

/// Bytes of the array that is scanned and cleared: more than any cache holds.
const BYTES: usize = 256 << 20;
/// Words of a row of the scan: two rows stay in a core's cache.
const ROW: usize = 1 << 10;
/// Rays along both sides of a bin.
const BIN: i64 = 8;
/// Bins that are tested.
const N_BINS: usize = 1 << 21;
/// Repetitions, of which the fastest counts.
const RUNS: u32 = 5;

/// Most that all cores did in a second.
#[derive(Debug, Clone, Copy, Serialize)]
pub(crate) struct Machine {
    /// Bytes read and written by an XOR scan in place, each row by the one before it.
    pub(crate) scan: f64,
    /// Bytes cleared.
    pub(crate) clear: f64,
    /// Tests of a ray against the three edges of a facet in 64-bit integers.
    pub(crate) hits: f64,
}

/// Measures all three.
pub(crate) fn measure() -> Machine {
    let mut words: Vec<u64> = (0..BYTES as u64 / 8).collect();
    let chunk = words.len() / rayon::current_num_threads().max(1);
    let scan = fastest(|| {
        words.par_chunks_mut(chunk).for_each(scan_rows);
    });
    let clear = fastest(|| words.par_chunks_mut(ROW * 64).for_each(|words| black_box(words).fill(0)));
    let hits = fastest(|| {
        black_box((0..N_BINS).into_par_iter().with_min_len(4096).map(|bin| hits_of_bin(bin as i64)).sum::<u64>());
    });
    let n_tests = N_BINS as f64 * (BIN * BIN) as f64;
    Machine { scan: 2.0 * BYTES as f64 / scan, clear: BYTES as f64 / clear, hits: n_tests / hits }
}

/// XORs every row into the one behind it.
fn scan_rows(words: &mut [u64]) {
    for start in (ROW..words.len()).step_by(ROW) {
        let (before, now) = words.split_at_mut(start);
        now.iter_mut().zip(&before[start - ROW..]).for_each(|(now, before)| *now ^= before);
    }
}

/// Number of rays of a bin inside a facet, by its three edge functions.
fn hits_of_bin(bin: i64) -> u64 {
    let [a, b, start] = black_box([[3, -5, 2], [7, 1, -8], [(bin & 63) - 40, 21 - (bin & 31), 1]]);
    let mut n_hits = 0;
    for j in 0..BIN {
        for i in 0..BIN {
            let edge = |edge: usize| start[edge] + a[edge] * i + b[edge] * j;
            n_hits += u64::from((edge(0) | edge(1) | edge(2)) >= 0);
        }
    }
    n_hits
}

/// Least seconds of some runs.
fn fastest(mut run: impl FnMut()) -> f64 {
    let seconds = |run: &mut dyn FnMut()| {
        let start = Instant::now();
        run();
        start.elapsed().as_secs_f64()
    };
    (0..RUNS).map(|_| seconds(&mut run)).fold(f64::INFINITY, f64::min)
}

//! The check of a band: a sample of its rays, cast again by the CPU definition. A driver that is wrong is wrong in many rays, so a few
//! tell; cost: as many rays of the CPU's as are in the sample, 1 in 256.

use std::ops::Range;

use crate::columns::Band;
use crate::cpu::Window;

/// Of so many rays one is cast again.
const ONE_IN: u32 = 256;
/// Least rays of a sample, if there are as many.
const LEAST_RAYS: u32 = 64;

/// The ray rows of the sample of a band with rows of `n_i` rays: one of each stretch of equal length, in a place that is different in
/// each, but the same in every run.
pub(crate) fn sample(rows: &Range<u32>, n_i: u32) -> Vec<Window> {
    let n_rows = rows.end - rows.start;
    let n = n_rows.div_ceil(ONE_IN).max(LEAST_RAYS.div_ceil(n_i)).min(n_rows);
    let row = |index: u32| {
        let [start, end] = [index, index + 1].map(|k| (u64::from(k) * u64::from(n_rows) / u64::from(n)) as u32);
        // Knuth's multiplicative hash: rows at equal distances could all miss what is wrong
        let hash = (rows.start + start).wrapping_mul(2_654_435_761) >> 7;
        rows.start + start + hash % (end - start)
    };
    (0..n).map(|index| [0..n_i, row(index)..row(index) + 1]).collect()
}

/// Rays of the sample whose runs differ from those of a band.
pub(crate) fn differing(band: &Band, sample: &[Band]) -> u64 {
    let of_one = |cast: &Band| {
        let first = (cast.first_ray - band.first_ray) as usize;
        (0..cast.ends.len()).filter(|&ray| cast.ray(ray) != band.ray(first + ray)).count() as u64
    };
    sample.iter().map(of_one).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sample_is_spread_over_its_band() {
        for (rows, n_i, n) in [(0..1024, 1024, 4), (8..9, 5, 1), (0..40, 2, 32), (100..4196, 1, 64), (0..3, 7, 3)] {
            let sample = sample(&rows, n_i);
            assert_eq!(sample.len(), n, "{rows:?}");
            let starts: Vec<u32> = sample.iter().map(|window| window[1].start).collect();
            assert!(starts.is_sorted_by(|a, b| a < b) && starts.iter().all(|row| rows.contains(row)), "{starts:?}");
        }
    }

    #[test]
    fn rays_that_differ_are_counted() {
        let band = Band { first_ray: 10, ends: vec![1, 2, 2, 3], runs: vec![5, 6, 7], ..Band::default() };
        let cast = Band { first_ray: 11, ends: vec![1, 2], runs: vec![6, 7], ..Band::default() };
        assert_eq!(differing(&band, std::slice::from_ref(&cast)), 1);
        assert_eq!(differing(&band, &[Band { ends: vec![1, 1], runs: vec![6], ..cast }]), 0);
    }
}

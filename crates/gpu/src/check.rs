//! The check of a band: a sample of its rays, cast again by the CPU definition. A driver that is wrong is wrong in many rays, so a
//! sample shows it. Cost: the CPU casts the rays of the sample, 1 in 256.

use crate::layout::Params;
use hexcast_core::cells::columns::Band;
use hexcast_core::stages::cast::sizes::BIN;
use hexcast_core::stages::cpu::Window;

/// Of so many chunks, rows of 8 rays, one is cast again.
const ONE_IN: u64 = 256;
/// Least chunks of a sample, if there are as many: 64 rays.
const LEAST: u64 = 8;

/// The sample of a band: a chunk of each of some stretches of equal length, in a place that is different in each, but the same in every
/// run.
pub(crate) fn sample(params: &Params) -> Vec<Window> {
    let n_chunks = params.n_chunks();
    let n = n_chunks.div_ceil(ONE_IN).max(LEAST).min(n_chunks);
    let chunk = |index: u64| {
        let [start, end] = [index, index + 1].map(|k| k * n_chunks / n);
        // Knuth's multiplicative hash: chunks at equal distances could all miss what is wrong
        let hash = (params.first_row.wrapping_add(start as u32)).wrapping_mul(2_654_435_761) >> 7;
        (start + u64::from(hash) % (end - start)) as usize
    };
    (0..n).map(|index| window(params, chunk(index))).collect()
}

/// The rays of a chunk.
pub(crate) fn window(params: &Params, chunk: usize) -> Window {
    let (column, row) = (chunk as u32 % params.n_across, params.first_row + chunk as u32 / params.n_across);
    [column * BIN..((column + 1) * BIN).min(params.n_i), row..row + 1]
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
    use hexcast_core::set;

    use super::*;

    #[test]
    fn a_sample_is_spread_over_its_band() {
        for (rows, n_i, n) in [(0..1024, 1024u32, 512), (8..9, 5, 1), (0..40, 2, 8), (100..4196, 1, 16), (0..3, 17, 8)]
        {
            let n_across = n_i.div_ceil(BIN);
            let (first_row, end_row) = (rows.start, rows.end);
            let params = Params { n_i, n_across, first_row, end_row, ..bytemuck::Zeroable::zeroed() };
            let sample = sample(&params);
            assert_eq!(sample.len(), n, "{rows:?}");
            let starts: Vec<(u32, u32)> = sample.iter().map(|[i, j]| (j.start, i.start)).collect();
            assert!(starts.is_sorted_by(|a, b| a < b), "{starts:?}");
            assert!(
                sample.iter().all(|[i, j]| i.end <= n_i && i.start < i.end && rows.contains(&j.start)),
                "{sample:?}"
            );
        }
    }

    #[test]
    fn rays_that_differ_are_counted() {
        let band = set!(Band { first_ray: 10, ends: vec![1, 2, 2, 3], runs: vec![5, 6, 7], ..Band::default() });
        let cast = set!(Band { first_ray: 11, ends: vec![1, 2], runs: vec![6, 7], ..Band::default() });
        assert_eq!(differing(&band, std::slice::from_ref(&cast)), 1);
        assert_eq!(differing(&band, &[set!(Band { ends: vec![1, 1], runs: vec![6], ..cast })]), 0);
    }
}

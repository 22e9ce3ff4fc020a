//! The paper's optimum: the largest uniform cell size that puts all end points on mesh lines.
//!
//! End points of an axis, a largest size, a tolerance -> the size s. With d_i the distances of the end points from the
//! first, wanted is the largest `s <= s_max` with `|d_i / s - round(d_i / s)| <= tolerance` for all i: the number of cells of
//! Eq. 1-3 is least where s is largest, under the paper's two restrictions. The paper gives no algorithm; AEG Mesher [30]
//! minimises the distance of each ratio to an integer. Here the sizes that an end point allows are intervals,
//! `d_i / (m + tolerance) ..= d_i / (m - tolerance)` for m = 1, 2, ...: from s_max downwards, as long as an end point objects,
//! s jumps to the top of the next lower interval of the one that objects most. No size between is allowed, so the first
//! size that nobody objects to is the largest of all. Cost: O(end points) a jump, at most one jump an interval.

/// How far below the largest allowed size the search goes before it gives up.
const SMALLEST_SHARE: f64 = 1.0 / 16.0;

/// Finds the largest size of at most `s_max` that puts all end points within `tolerance` cells of a line that starts at
/// the first of them; None if there is none down to a sixteenth of `s_max`.
pub(crate) fn optimal_cell_size(end_points: &[f64], s_max: f64, tolerance: f64) -> Option<f64> {
    let distances: Vec<f64> = end_points[1..].iter().map(|end| end - end_points[0]).collect();
    let mut size = s_max;
    while size >= s_max * SMALLEST_SHARE {
        let next = distances.iter().map(|distance| largest_allowed(*distance, size, tolerance)).fold(size, f64::min);
        if next == size {
            return Some(size);
        }
        size = next;
    }
    None
}

/// The largest size of at most `size` that one end point allows.
fn largest_allowed(distance: f64, size: f64, tolerance: f64) -> f64 {
    let ratio = distance / size;
    let cells = ratio.round();
    // a few ulps of forgiveness, so that the size computed below satisfies its own test
    if cells >= 1.0 && (ratio - cells).abs() <= tolerance + 4.0 * f64::EPSILON * ratio {
        return size;
    }
    distance / ((ratio + tolerance).floor() + 1.0 - tolerance)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The worst distance from a line, in cells.
    fn residual(ends: &[f64], size: f64) -> f64 {
        let off = |end: &f64| {
            let ratio = (end - ends[0]) / size;
            if ratio < 0.5 { 1.0 } else { (ratio - ratio.round()).abs() }
        };
        ends[1..].iter().map(off).fold(0.0, f64::max)
    }

    #[test]
    fn a_common_divisor_is_found_exactly() {
        assert_eq!(optimal_cell_size(&[0.0, 6.0, 15.0], 4.0, 0.0), Some(3.0));
        assert_eq!(optimal_cell_size(&[0.0, 6.0, 15.0], 3.0, 0.0), Some(3.0));
        assert_eq!(optimal_cell_size(&[0.0, 6.0, 15.0], 2.9, 0.0), Some(1.5));
        assert_eq!(optimal_cell_size(&[-1.0, 1.0], 1.9, 0.0), Some(1.0));
    }

    #[test]
    fn a_size_that_fits_as_it_is_is_kept() {
        assert_eq!(optimal_cell_size(&[0.0, 10.04], 1.0, 0.05), Some(1.0));
    }

    #[test]
    fn an_interval_smaller_than_the_largest_size_is_one_cell() {
        let size = optimal_cell_size(&[0.0, 0.3, 10.2], 1.0, 0.0).unwrap();
        assert!((size - 0.3).abs() < 1e-12, "{size}");
    }

    #[test]
    fn nothing_in_common_is_nothing() {
        assert_eq!(optimal_cell_size(&[0.0, 1.0, 1.0 + std::f64::consts::SQRT_2], 0.9, 0.001), None);
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(64) })]

        /// Against a dense scan downwards that tests every size on its own.
        #[test]
        fn no_larger_size_fits(gaps in prop::collection::vec(0.2f64..5.0, 1..4), s_max in 0.3f64..2.0, tolerance in 0.02f64..0.2) {
            let mut ends = vec![-3.0];
            for gap in gaps {
                ends.push(ends[ends.len() - 1] + gap);
            }
            let found = optimal_cell_size(&ends, s_max, tolerance);
            let floor = found.map_or(s_max / 16.0, |size| {
                assert!(size <= s_max);
                assert!(residual(&ends, size) <= tolerance + 1e-9);
                size
            });
            let steps = 20_000;
            for step in 0..steps {
                let size = s_max * (1.0 - (15.0 / 16.0) * f64::from(step) / f64::from(steps));
                if size <= floor * (1.0 + 1e-9) {
                    break;
                }
                prop_assert!(residual(&ends, size) > tolerance, "size {size} fits, found {found:?}");
            }
        }
    }
}

use proptest::prelude::*;

use super::*;
use crate::input::job::Job;
use crate::set;

fn optimum(distances: &[f64], s_max: f64, tolerance: f64) -> Option<f64> {
    let intervals = Intervals { distances: distances.to_vec(), thinnest: f64::INFINITY };
    intervals.optimal_cell_size(s_max, tolerance)
}

#[test]
fn a_common_divisor_is_found_exactly() {
    for tolerance in [0.0, 0.01, 0.05] {
        assert_eq!(optimum(&[6.0, 15.0], 4.0, tolerance), Some(3.0));
        assert_eq!(optimum(&[6.0, 15.0], 3.0, tolerance), Some(3.0));
        assert_eq!(optimum(&[6.0, 15.0], 2.9, tolerance), Some(1.5));
        assert_eq!(optimum(&[2.0], 1.9, tolerance), Some(1.0));
        assert_eq!(optimum(&[1.0], 0.3, tolerance), Some(0.25));
    }
}

#[test]
fn sizes_are_searched_down_to_a_part_of_the_extent_and_the_thinnest_geometry() {
    let searched = |distances: &[f64], thinnest: f64, s_max: f64, tolerance: f64| {
        Intervals { distances: distances.to_vec(), thinnest }.searched(s_max, tolerance)
    };
    let of = |greatest: f64| [greatest / 256.0, greatest];
    assert_eq!(searched(&[0.25, 0.5], f64::INFINITY, 2.0, 0.05), of(0.5));
    assert_eq!(searched(&[4.0, 8.0], f64::INFINITY, 2.0, 0.05), of(2.0));
    assert_eq!(searched(&[4.0, 8.0], 0.5, 2.0, 0.25), of(1.0));
    // the least one is among them
    assert_eq!(optimum(&[1.0 / 256.0, 1.0], 1.0, 0.0), Some(1.0 / 256.0));
    assert_eq!(optimum(&[1.0 / 257.0, 1.0], 1.0, 0.0), None);
}

#[test]
fn ends_and_geometries_nearer_than_the_rounding_of_files_do_not_count() {
    // coordinates up to 8 are rounded by a millionth
    let r = 1.0 / f64::from(1 << 20);
    let near = 1.0 + 1e-3;
    let job = set!(Job { domain: Some([0.0, 0.0, 0.0, 8.0, 8.0, 8.0]), ..Job::default() });
    let all = f64::INFINITY;
    // ends of a body -> distances between the ends of the domain, and the thinnest geometry in it
    for (ends, distances, thinnest) in [
        ([2.0, 3.0], &[2.0, 3.0][..], 1.0),
        ([r, 4.0], &[4.0], 4.0 - r),
        ([near * r, 4.0], &[near * r, 4.0], 4.0 - near * r),
        ([4.0, 8.0 - r], &[4.0], 4.0 - r),
        ([4.0, 8.0 - near * r], &[4.0, 8.0 - near * r], 4.0 - near * r),
        ([3.0, 3.0], &[3.0], all),
        ([3.0, 3.0 + r], &[3.0, 3.0 + r], all),
        ([3.0, 3.0 + near * r], &[3.0, 3.0 + near * r], 3.0 + near * r - 3.0),
        ([7.0, 8.0], &[7.0], 1.0),
        ([0.0, 1.0], &[1.0], 1.0),
        ([-r, 1.0], &[1.0], 1.0 + r),
        ([-near * r, 1.0], &[1.0], all),
        ([-1.0, 1.0], &[1.0], all),
        ([7.0, 8.0 + near * r], &[7.0], all),
        ([-1.0, 9.0], &[], all),
    ] {
        // a flat body at 8 gives the rounding
        let boxes = [[[8.0; 3]; 2], [[ends[0], 2.0, 2.0], [ends[1], 3.0, 3.0]]];
        let found = Intervals::new(&Domain::new(&job, &boxes).unwrap(), 0);
        assert_eq!((&found.distances[..], found.thinnest), (&[distances, &[8.0]].concat()[..], thinnest), "{ends:?}");
    }
}

#[test]
fn of_sizes_that_keep_the_lines_the_one_that_comes_nearest_is_taken() {
    // an end point on the first line lies between two others
    assert_eq!(optimum(&[1.0, 1.98, 2.02], 1.01, 0.05), Some(1.0));
}

#[test]
fn the_largest_size_itself_is_not_exceeded_to_come_nearer() {
    assert_eq!(optimum(&[10.04], 1.0, 0.05), Some(1.0));
    assert_eq!(optimum(&[9.98], 1.0, 0.05), Some(0.998));
}

#[test]
fn an_interval_smaller_than_the_largest_size_is_one_cell() {
    let size = optimum(&[0.3, 10.2], 1.0, 0.0).unwrap();
    assert!((size - 0.3).abs() < 1e-12, "{size}");
}

#[test]
fn a_thin_geometry_keeps_a_cell() {
    let plate = Intervals { distances: vec![5.0, 5.02, 10.0], thinnest: 0.02 };
    let size = plate.optimal_cell_size(1.0, 0.05).unwrap();
    assert!((5.02 / size).round() > (5.0 / size).round(), "{size}");
    assert!(size <= 0.02 / 0.9 && size > 0.02 / 1.1, "{size}");
}

#[test]
fn a_divisor_far_below_the_largest_size_is_found() {
    assert_eq!(optimum(&[10.0, 10.5], 10.0, 0.0), Some(0.5));
}

#[test]
fn nothing_in_common_is_nothing() {
    assert_eq!(optimum(&[1.0, 1.0 + std::f64::consts::SQRT_2], 0.9, 0.0001), None);
}

#[test]
fn rounding_of_the_files_makes_no_intervals() {
    let tenth = f64::from(0.1f32);
    let boxes = [[[0.1; 3], [10.1; 3]], [[tenth; 3], [5.1, 5.1, f64::from(10.1f32)]]];
    let domain = Domain::new(&Job::default(), &boxes).unwrap();
    assert_eq!(Intervals::new(&domain, 0).distances.len(), 2);
    assert_eq!(Intervals::new(&domain, 2).distances.len(), 1);
    assert!((Intervals::new(&domain, 0).thinnest - 5.0).abs() < 1e-6);
    let size = Intervals::new(&domain, 0).optimal_cell_size(1.1, 0.05).unwrap();
    assert!((size - 1.0).abs() < 1e-6, "{size}");
}

/// The worst distance from a line, in cells, counted in whole cells rather than by rounding.
fn worst(distances: &[f64], size: f64) -> f64 {
    let off = |distance: &f64| {
        let rest = distance.rem_euclid(size) / size;
        rest.min(1.0 - rest)
    };
    distances.iter().map(off).fold(0.0, f64::max)
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(64) })]

    /// Against a dense scan downwards that tests every size on its own: no allowed size has fewer cells.
    #[test]
    fn no_larger_size_fits(
        gaps in prop::collection::vec(0.2f64..5.0, 1..4), s_max in 0.3f64..2.0, tolerance in 0.02f64..0.2,
    ) {
        let distances: Vec<f64> = gaps.iter().scan(0.0, |sum, gap| { *sum += gap; Some(*sum) }).collect();
        let found = optimum(&distances, s_max, tolerance);
        let extent = distances[distances.len() - 1];
        let greatest = s_max.min(extent);
        if let Some(size) = found {
            prop_assert!(size <= s_max);
            prop_assert!(worst(&distances, size) <= tolerance + 1e-9);
        }
        let steps = 20_000;
        for step in 0..steps {
            let size = greatest * (1.0 - 0.95 * f64::from(step) / f64::from(steps));
            if worst(&distances, size) <= tolerance - 1e-9 {
                let found = found.expect("the scan found a size");
                let cells = |s: f64| (extent / s).round();
                prop_assert!(cells(found) <= cells(size), "size {size} fits, found {found}");
                break;
            }
        }
    }

    /// Multiples of a divisor, moved by less than the rounding of a file, still give the divisor or its double, triple, ...
    #[test]
    fn a_disturbed_divisor_is_found(
        steps in prop::collection::vec(1u32..40, 1..5), noise in -1e-7f64..1e-7, scale in -6i32..4,
    ) {
        let unit = 10f64.powi(scale);
        let mut sum = 0;
        let distances: Vec<f64> =
            steps.iter().map(|step| { sum += step; unit * (f64::from(sum) + noise) }).collect();
        let size = optimum(&distances, 1.2 * unit, 0.01).unwrap();
        prop_assert!(size >= unit * (1.0 - 1e-6) && size <= 1.2 * unit, "{size}");
    }
}

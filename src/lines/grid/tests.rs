use super::*;

/// Some lists that are not equally spaced.
fn graded() -> Lines {
    Lines::from_lists([vec![0.0, 1.0, 3.0, 3.5], vec![-2.0, 0.0, 2.0], vec![10.0, 10.25, 11.0]]).unwrap()
}

#[test]
fn lists_that_are_equally_spaced_are_uniform_lines() {
    for (origin, spacing, n) in
        [(0.0, 0.1, 10), (-3.7, 1.0 / 3.0, 1000), (1e6, 0.25, 7), (0.3, 1e-7, 4096), (-0.05, 0.7, 1)]
    {
        let uniform = Lines::new([origin; 3], [spacing; 3], [n; 3]).unwrap();
        let listed = Lines::from_lists([0, 1, 2].map(|axis| uniform.list(axis))).unwrap();
        assert!(!listed.is_graded());
        for axis in 0..3 {
            assert_eq!(listed.list(axis), uniform.list(axis), "{n} cells of {spacing} from {origin}");
        }
        if n > 1 {
            assert_eq!(listed, uniform);
        }
    }
    let mut last_bit = Lines::new([0.0; 3], [0.1; 3], [10; 3]).unwrap().list(0);
    last_bit[5] = last_bit[5].next_up();
    let even = || vec![0.0, 1.0];
    assert!(Lines::from_lists([last_bit, even(), even()]).unwrap().is_graded());
}

#[test]
fn lists_know_sizes_places_and_windows() {
    let lines = graded();
    assert_eq!((lines.dims(), lines.origin(), lines.smallest()), ([3, 2, 2], [0.0, -2.0, 10.0], [0.5, 2.0, 0.25]));
    assert_eq!((lines.spacing(), lines.cell_volume(), lines.n_cells()), (None, None, 12));
    assert_eq!([lines.cell_size(0, 0), lines.cell_size(0, 1), lines.centre(0, 1)], [1.0, 2.0, 2.0]);
    assert_eq!([lines.at(0, 2.5), lines.at(0, -1.0), lines.at(0, 5.0)], [3.25, -1.0, 4.5]);
    for cells in [-2.0, 0.0, 0.25, 1.0, 1.75, 3.0, 7.5] {
        assert_eq!(lines.position(0, lines.at(0, cells)), cells);
    }
    let window = lines.window([[1, 0, 1], [3, 1, 2]]);
    assert_eq!((window.list(0), window.dims(), window.smallest()), (vec![1.0, 3.0, 3.5], [2, 1, 1], lines.smallest()));
    let halo = lines.with_halo([[1, 0, 1], [3, 1, 2]], 1);
    assert_eq!((halo.list(0), halo.list(1)), (vec![0.0, 1.0, 3.0, 3.5, 4.0], vec![-4.0, -2.0, 0.0, 2.0]));
}

#[test]
fn wrong_lists_are_refused_with_their_numbers() {
    let too_many = (0..super::super::MAX_LISTED + 1).map(|index| index as f64).collect::<Vec<f64>>();
    for (list, part) in [
        (vec![], "lines.y has 0 lines"),
        (vec![1.0], "lines.y has 1 lines"),
        (vec![0.0, 2.0, 2.0], "lines.y[2] is 2.0 and lines.y[1] before it 2.0"),
        (vec![0.0, 2.0, 1.0], "lines.y[2] is 1.0 and lines.y[1] before it 2.0"),
        (vec![0.0, f64::NAN], "lines.y[1] is NaN"),
        (vec![f64::NEG_INFINITY, 0.0], "lines.y[0] is -inf"),
        (vec![f64::MIN, 0.0, f64::MAX], "lines.y reaches from"),
        (too_many, "lines.y has 262144 lines: at most 262143 fit"),
    ] {
        let error = Lines::from_lists([vec![0.0, 1.0], list, vec![0.0, 1.0]]).unwrap_err();
        assert!(error.code() == "lines-wrong" && error.to_string().contains(part), "{error}");
    }
}

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
    assert_eq!(Lines::new([0.0; 3], [1.0, 0.5, 3.0], [1, 2, 3]).unwrap().cell_volume(), Some(1.5));
    let uneven = Lines::new([0.0, 1.0, 2.0], [0.1, 0.2, 0.3], [2, 3, 4]).unwrap();
    assert!(uneven.as_lists().is_graded());
    (0..3).for_each(|axis| assert_eq!(uneven.as_lists().list(axis), uneven.list(axis)));
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
    let cells = [[1, 0, 1], [3, 1, 2]];
    assert_eq!(lines.corners(cells), [[1.0, -2.0, 10.25], [3.5, 0.0, 11.0]]);
    let window = lines.window(cells);
    assert_eq!((window.origin(), window.dims(), window.smallest()), ([1.0, -2.0, 10.25], [2, 1, 1], lines.smallest()));
    assert_eq!([0, 1, 2].map(|axis| window.list(axis)), [vec![1.0, 3.0, 3.5], vec![-2.0, 0.0], vec![10.25, 11.0]]);
    let halo = lines.with_halo(cells, 2);
    assert_eq!((halo.origin(), halo.dims()), ([-1.0, -6.0, 9.75], [6, 5, 5]));
    let lists = [
        vec![-1.0, 0.0, 1.0, 3.0, 3.5, 4.0, 4.5],
        vec![-6.0, -4.0, -2.0, 0.0, 2.0, 4.0],
        vec![9.75, 10.0, 10.25, 11.0, 11.75, 12.5],
    ];
    assert_eq!([0, 1, 2].map(|axis| halo.list(axis)), lists);
    // a whole number is a line, to the last bit, also where the cell before it is too long to end there
    for n in 2..9u32 {
        let mut list: Vec<f64> = (0..n).map(|k| f64::from(k).powf(1.7) - 100.0).collect();
        list.push(1e-17);
        let lines = Lines::from_lists([list.clone(), vec![0.0, 1.0], vec![0.0, 1.0]]).unwrap();
        (0..=n).for_each(|k| assert_eq!(lines.at(0, f64::from(k)), list[k as usize]));
    }
}

#[test]
fn places_are_shown_to_a_thousandth_of_a_cell() {
    let text = |size: f64, place: [f64; 3]| Lines::new([0.0; 3], [size; 3], [1; 3]).unwrap().text_of(place);
    assert_eq!(text(1.0, [1.23456, -0.0001, 20.0]), "(1.235, 0, 20)");
    assert_eq!(text(100.0, [1.26, 5.0, -7.31]), "(1.3, 5, -7.3)");
    assert_eq!(text(1e6, [1.6, 5100.0, -70.0]), "(2, 5100, -70)");
    assert_eq!(text(0.05, [1.23456, 0.5, 2.0]), "(1.23456, 0.5, 2)");
}

#[test]
fn lines_without_cells_are_refused() {
    let new = |origin: f64, spacing: f64, n: u32| {
        [0, 1, 2].map(|axis| {
            let (mut origins, mut sizes, mut dims) = ([0.0; 3], [1.0; 3], [2; 3]);
            (origins[axis], sizes[axis], dims[axis]) = (origin, spacing, n);
            Lines::new(origins, sizes, dims).map(|_| ()).map_err(|error| error.code())
        })
    };
    assert_eq!(new(0.0, 1.0, 1), [Ok(()); 3]);
    for (spacing, n) in [(0.0, 1), (-1.0, 1), (f64::INFINITY, 1), (f64::NAN, 1), (1.0, 0)] {
        assert_eq!(new(0.0, spacing, n), [Err("domain-empty"); 3], "{n} of {spacing}");
    }
    assert_eq!([new(f64::NAN, 1.0, 1), new(f64::INFINITY, 1.0, 1)], [[Err("job-value"); 3]; 2]);
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
        (too_many, "lines.y has 262144 lines: at most 262143 fit"),
    ] {
        for (axis, name) in ["lines.x", "lines.y", "lines.z"].iter().enumerate() {
            let mut lists = [const { Vec::new() }; 3].map(|_: Vec<f64>| vec![0.0, 1.0]);
            lists[axis] = list.clone();
            let error = Lines::from_lists(lists).unwrap_err();
            let part = part.replace("lines.y", name);
            assert!(error.code() == "lines-wrong" && error.to_string().contains(&part), "{error}");
        }
    }
    // as many as fit, and as close as they may be
    let most = (0..super::super::MAX_LISTED).map(|index| index as f64).collect::<Vec<f64>>();
    for list in [most, vec![0.0, 1e-38], vec![-1e38, 1e38]] {
        let n = list.len() as u32 - 1;
        assert_eq!(Lines::from_lists([vec![0.0, 1.0], list, vec![0.0, 1.0]]).unwrap().dims(), [1, n, 1]);
    }
}

#[test]
fn lengths_that_files_do_not_hold_are_refused() {
    let refused = |made: crate::base::error::Result<Lines>, what: &str| {
        let error = made.unwrap_err();
        assert!(error.code() == "job-value" && error.to_string().contains(what), "{error}");
    };
    let uniform = |origin: f64, size: f64, n: u32| Lines::new([0.0, origin, 0.0], [1.0, size, 1.0], [1, n, 1]);
    refused(
        uniform(0.0, 1e300, 1),
        "cells of 1e300 along y, from 0.0 to 1e300: cells can have 1e-38 and more, and coordinates up to 1e38",
    );
    refused(uniform(0.0, 1e-300, 4), "cells of 1e-300 along y");
    refused(uniform(-2e38, 1e37, 20), "from -2e38 to 0.0");
    refused(uniform(0.0, 1e37, 11), "from 0.0 to 1.1e38");
    refused(uniform(f64::MAX, f64::MAX, 2), "to inf");
    let unit = || vec![0.0, 1.0];
    refused(Lines::from_lists([unit(), vec![f64::MIN, 0.0, f64::MAX], unit()]), "along y");
    refused(
        Lines::from_lists([unit(), unit(), vec![0.0, f64::MIN_POSITIVE, 1.0]]),
        "cells of 2.2250738585072014e-308 along z",
    );
    assert!(uniform(0.0, 1e37, 10).is_ok() && uniform(0.0, 1e-38, 1).is_ok());
}

use super::*;
use crate::base::finding::sentences;
use crate::input::job::PerAxis;
use crate::set;

fn chosen(job: Job, low: [f64; 3], high: [f64; 3]) -> Lines {
    lines(&job, &Domain::new(&job, &[[low, high]]).unwrap()).unwrap()
}

fn cells(n: u32) -> Job {
    set!(Job { cells: Some(n), ..Job::default() })
}

#[test]
fn cubic_cells_along_the_longest_axis() {
    let lines = chosen(cells(8), [0.0; 3], [4.0, 2.0, 0.7]);
    assert_eq!((lines.dims(), lines.smallest(), lines.origin()), ([8, 4, 2], [0.5; 3], [0.0; 3]));
}

#[test]
fn rounding_never_adds_a_cell() {
    for scale in [1e-6, 1e-3, 0.1, 1.0, 3.0, 1e3] {
        for n in [8, 10, 671, 672, 1000] {
            let lines = chosen(cells(n), [0.0; 3], [0.1 * scale, 0.1 * scale, 0.3 * scale / 3.0]);
            assert_eq!(lines.dims(), [n; 3], "scale {scale}");
        }
    }
    let lines = chosen(cells(400), [150.1, 400.1, 150.1], [550.1, 800.1, 550.1]);
    assert_eq!(lines.dims(), [400; 3]);
}

#[test]
fn dims_give_exactly_that_grid() {
    let job = set!(Job { dims: Some([3, 7, 11]), domain: Some([-1.0, 0.0, 0.1, 2.0, 0.7, 0.2]), ..Job::default() });
    let lines = chosen(job, [0.0; 3], [1.0; 3]);
    assert_eq!((lines.dims(), lines.origin(), lines.smallest()[0]), ([3, 7, 11], [-1.0, 0.0, 0.1], 1.0));
    let of = |axis: usize, size: f64| (lines.smallest()[axis] / size - 1.0).abs() < 1e-12;
    assert!(of(1, 0.1) && of(2, 0.1 / 11.0), "{:?}", lines.smallest());
    // also where the size is rounded by more than a part of a cell that is called rounding
    for n in 4_000_000_000..4_000_000_050 {
        let job = set!(Job { dims: Some([n, 1, 1]), domain: Some([0.0, 0.0, 0.0, 0.7, 1.0, 1.0]), ..Job::default() });
        assert_eq!(chosen(job, [0.0; 3], [1.0; 3]).dims(), [n, 1, 1]);
    }
}

#[test]
fn padding_by_cells_keeps_the_lines() {
    let job = set!(Job { padding: Some(Padding::Cells(PerAxis::Each([1, 0, 2]))), ..cells(4) });
    let lines = chosen(job.clone(), [0.0; 3], [2.0, 2.0, 1.0]);
    assert_eq!((lines.dims(), lines.origin()), ([6, 4, 6], [-0.5, 0.0, -1.0]));
    // also those of a given box
    let job = set!(Job { domain: Some([-1.0, 0.0, 0.0, 1.0, 1.0, 0.5]), ..job });
    let lines = chosen(job, [0.0; 3], [2.0, 2.0, 1.0]);
    assert_eq!((lines.dims(), lines.origin()), ([6, 2, 5], [-1.5, 0.0, -1.0]));
}

#[test]
fn cell_sizes_may_differ_and_overshoot() {
    let job = set!(Job { cell_size: Some(PerAxis::Each([1.0, 0.5, 0.3])), ..Job::default() });
    let lines = chosen(job, [0.0; 3], [2.5, 2.0, 1.0]);
    assert_eq!(lines.dims(), [3, 4, 4]);
}

#[test]
fn the_optimum_meets_all_end_points_and_reports_the_rest() {
    let job = set!(Job { max_cell_size: Some(1.0), ..Job::default() });
    let boxes = [[[0.0, 0.0, 0.0], [6.0, 1.0, 10.04]], [[1.5, 0.0, 0.0], [4.5, 1.0, 1.0]]];
    let domain = Domain::new(&job, &boxes).unwrap();
    let lines = lines(&job, &domain).unwrap();
    assert_eq!(lines.smallest()[0], 0.75);
    assert!(lines.smallest().iter().all(|&size| size <= 1.0));
    assert_eq!((lines.dims()[1], lines.dims()[2]), (1, 10));
    let ends = residuals(&lines, &domain).map(|of| of.iter().map(|of| of.end_point).collect::<Vec<_>>());
    assert_eq!(ends, domain.end_points);
    for residual in residuals(&lines, &domain).iter().flatten() {
        assert!(residual.cells.abs() <= DEFAULT_TOLERANCE + 1e-9, "{residual:?}");
    }
}

#[test]
fn an_impossible_optimum_says_so() {
    let job = set!(Job { max_cell_size: Some(0.9), tolerance: Some(0.0001), ..Job::default() });
    let boxes = [[[0.0; 3], [2.5, 1.0, 1.0]], [[0.0; 3], [std::f64::consts::SQRT_2, 1.0, 1.0]]];
    let error = lines(&job, &Domain::new(&job, &boxes).unwrap()).unwrap_err();
    assert_eq!(error.code(), "lines-no-common-size");
    assert!(error.to_string().contains("along x"), "{error}");
    assert!(error.hint().contains("tolerance of 0.05 would give cells of 0."), "{}", error.hint());
}

#[test]
fn the_rounding_of_a_file_adds_no_layer() {
    let size = |size| set!(Job { cell_size: Some(PerAxis::All(size)), ..Job::default() });
    let [low, high] = [0.1f32, 1.1f32].map(f64::from);
    assert_eq!(chosen(size(0.1), [low; 3], [high; 3]).dims(), [10; 3]);
    // sides of 400 and 200 whose f32 corners leave a little more than 400 and 200
    for low in [150.1f32, 0.3, 1000.7, -77.7] {
        let at = |length: f32| f64::from(low + length);
        let lines = chosen(cells(400), [low.into(); 3], [at(400.0), at(200.0), at(100.0)]);
        assert_eq!(lines.dims(), [400, 200, 100], "{low}");
    }
    // a real excess does add one
    assert_eq!(chosen(size(1.0), [0.0; 3], [10.001; 3]).dims(), [11; 3]);
    let given = set!(Job { domain: Some([0.0, 0.0, 0.0, 10.0 + 1e-7, 10.0, 10.0]), ..size(1.0) });
    assert_eq!(chosen(given, [0.0; 3], [10.0; 3]).dims(), [11, 10, 10]);
}

#[test]
fn the_optimum_of_a_cube_divides_it() {
    for scale in [1e-6, 1e-3, 1.0, 1e3] {
        let job = set!(Job { max_cell_size: Some(0.3 * scale), ..Job::default() });
        let lines = chosen(job, [0.0; 3], [scale; 3]);
        assert_eq!((lines.dims(), lines.smallest()), ([4; 3], [scale / 4.0; 3]));
    }
}

#[test]
fn places_are_said_to_a_thousandth_of_a_cell() {
    let lines = Lines::new([0.0; 3], [0.1, 20.0, 1e9], [1; 3]).unwrap();
    assert_eq!(lines.text_of([3.855_100_280, -0.0, 123_456_789.6]), "(3.8551, 0, 123456790)");
    assert_eq!(lines.text_of([2.0, 100.0, -1.0]), "(2, 100, -1)");
}

#[test]
fn lists_of_a_job_are_its_lines() {
    let lists = [vec![0.0, 1.0, 3.0], vec![-1.0, 0.0], vec![2.0, 2.5, 4.0, 7.0]];
    let [x, y, z] = lists.clone();
    let lines = chosen(
        set!(Job { lines: Some(crate::input::job::LinesJob { x, y, z }), ..Job::default() }),
        [0.0; 3],
        [1.0; 3],
    );
    assert_eq!((lines.dims(), [0, 1, 2].map(|axis| lines.list(axis))), ([2, 1, 3], lists));
}

#[test]
fn light_takes_as_long_as_the_unit_of_lengths_says() {
    // cells of 3 x 4 x 12 in size, and larger ones: 1 / sqrt(1/9 + 1/16 + 1/144) = 12 / sqrt(26)
    let lines = Lines::from_lists([vec![0.0, 3.0, 7.0], vec![0.0, 6.0, 10.0], vec![0.0, 12.0]]).unwrap();
    let metres =
        [("m", 1.0), ("dm", 0.1), ("cm", 0.01), ("mm", 0.001), ("um", 1e-6), ("\u{b5}m", 1e-6), ("\u{3bc}m", 1e-6)];
    let others = [("nm", 1e-9), ("km", 1e3), ("in", 0.0254), ("mil", 2.54e-5), ("ft", 0.3048), ("yards", 0.9144)];
    for (unit, metres) in metres.into_iter().chain(others) {
        let seconds = Grading::of(&lines, Some(unit)).unwrap().courant_seconds.unwrap();
        let expected = 12.0 / 26f64.sqrt() * metres / 299_792_458.0;
        assert!((seconds / expected - 1.0).abs() < 1e-12, "{unit}: {seconds}");
    }
    let of = |unit| Grading::of(&lines, unit).unwrap();
    assert_eq!((of(None).courant_seconds, of(Some("parsec")).courant_seconds), (None, None));
    assert_eq!(
        (of(None).smallest, of(None).largest, of(None).ratio),
        ([3.0, 4.0, 12.0], [4.0, 6.0, 12.0], [4.0 / 3.0, 1.5, 1.0])
    );
    assert_eq!(Grading::of(&Lines::new([0.0; 3], [1.0; 3], [2; 3]).unwrap(), Some("m")), None);
}

#[test]
fn cells_of_less_than_half_the_largest_size_are_explained() {
    // a plate 0.1 thick, and a body whose ends have no common divisor near the largest size
    for (end, tolerance, cause) in
        [(3.1, 0.05, "the thinnest geometry is 0.1"), (10.0, 0.01, "no larger size puts all")]
    {
        let job = set!(Job { max_cell_size: Some(1.0), tolerance: Some(tolerance), ..Job::default() });
        let start = if end == 10.0 { 3.37 } else { 3.0 };
        let boxes = [[[0.0; 3], [10.0; 3]], [[start, 0.0, 0.0], [end, 10.0, 10.0]]];
        let domain = Domain::new(&job, &boxes).unwrap();
        let lines = lines(&job, &domain).unwrap();
        let found = sentences(&about_fine_cells(&job, &domain, &lines));
        let (size, ends) = (lines.smallest()[0], [0.0, start, end, 10.0]);
        let off = ends.map(|end: f64| (end / size - (end / size).round()).abs()).into_iter().fold(0.0, f64::max);
        assert!(size < 0.5 && off <= tolerance && found.len() == 1, "{size}: {found:?}");
        let numbers = format!("which makes {} of them: {cause}", (10.0 / size).round());
        assert!(found[0].contains(&numbers) && found[0].contains(" along x"), "{}", found[0]);
        assert!(found[0].contains(&format!("most {off:.1e} cells off")), "{off:e}: {}", found[0]);
    }
    let job = set!(Job { max_cell_size: Some(1.0), ..Job::default() });
    let domain = Domain::new(&job, &[[[0.0; 3], [1.0, 2.0, 0.25]]]).unwrap();
    // one cell of a quarter along z is as few as can be
    assert_eq!(about_fine_cells(&job, &domain, &lines(&job, &domain).unwrap()), vec![]);
    // the size, a tolerance, the first end of a body and its second, in a box of 10 -> what is said of cells along x
    let more = "a tolerance of 0.1 would give cells of 0.2564102564102564, 39 along x";
    for (s_max, tolerance, ends, size, said) in [
        (1.0, 0.05, [3.5, 7.0], 0.5, None),
        (2.0, 0.05, [3.5, 7.0], 0.5, Some("less than half of 2, which makes 20 of them: no larger size")),
        // a body of two cells is not what makes them small; of tolerances the first that gives fewer cells is offered
        (1.0, 0.01, [0.25, 0.75], 0.25, Some("which makes 40 of them: no larger size puts all 4 end points on lines")),
        (1.0, 0.01, [0.25, 0.75], 0.25, Some(more)),
    ] {
        let job = set!(Job { max_cell_size: Some(s_max), tolerance: Some(tolerance), ..Job::default() });
        let boxes = [[[0.0; 3], [10.0; 3]], [[ends[0], 0.0, 0.0], [ends[1], 10.0, 10.0]]];
        let domain = Domain::new(&job, &boxes).unwrap();
        let lines = lines(&job, &domain).unwrap();
        assert_eq!(lines.smallest()[0], size);
        let found = sentences(&about_fine_cells(&job, &domain, &lines));
        assert_eq!(found.len(), said.iter().len(), "{found:?}");
        assert!(said.is_none_or(|said| found[0].contains(said)), "{found:?}");
    }
    // two cells could be one
    let domain = Domain::new(&job, &[[[0.0; 3], [0.5, 1.0, 1.0]], [[0.0; 3], [0.25, 1.0, 1.0]]]).unwrap();
    let found = sentences(&about_fine_cells(&job, &domain, &lines(&job, &domain).unwrap()));
    assert!(found.len() == 1 && found[0].contains("which makes 2 of them"), "{found:?}");
}

#[test]
fn the_cells_of_a_box_are_limited_where_a_job_says_so() {
    let lines = Lines::new([0.0; 3], [1.0; 3], [3, 4, 5]).unwrap();
    let checked = |max_cells| check_n_cells(&set!(Job { max_cells, ..Job::default() }), &lines);
    assert_eq!([checked(None), checked(Some(60)), checked(Some(61))], [Ok(()), Ok(()), Ok(())]);
    let error = checked(Some(59)).unwrap_err();
    assert_eq!(
        (error.code(), error.to_string().as_str()),
        ("too-many-cells", "3 x 4 x 5 = 60 cells: at most 59 are allowed")
    );
}

#[test]
fn too_many_cells_along_an_axis_are_counted() {
    let wrong = |size: f64| {
        let job = set!(Job { cell_size: Some(PerAxis::Each([1.0, size, 1.0])), ..Job::default() });
        lines(&job, &Domain::new(&job, &[[[0.0; 3], [1.0; 3]]]).unwrap()).unwrap_err()
    };
    assert_eq!(wrong(1e-10).to_string(), "10000000000 cells of size 1e-10 along y");
    assert_eq!(wrong(1e-15).to_string(), "1000000000000000 cells of size 1e-15 along y");
    // the most that a u32 counts
    let of = |n: f64| {
        let job = set!(Job {
            domain: Some([0.0, 0.0, 0.0, 1.0, n, 1.0]),
            cell_size: Some(PerAxis::All(1.0)),
            ..Job::default()
        });
        lines(&job, &Domain::new(&job, &[]).unwrap()).map(|lines| lines.dims()[1]).map_err(|error| error.code())
    };
    assert_eq!([of(4_294_967_295.0), of(4_294_967_296.0)], [Ok(u32::MAX), Err("too-many-cells")]);
    assert_eq!(
        (wrong(1e-16).to_string().as_str(), wrong(1e-16).code()),
        ("1e16 cells of size 1e-16 along y", "too-many-cells")
    );
}

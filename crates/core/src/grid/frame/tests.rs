use super::*;

fn corner(at: [f32; 3]) -> Geometry {
    Geometry::new("g", 1, vec![[at; 3]]).unwrap()
}

#[test]
fn cell_centres_and_lines_are_exact() {
    let lines = Lines::new([0.0; 3], [0.1; 3], [10; 3]).unwrap();
    let frame = Frame::new(&[corner([1.0, 0.0, 0.5])], &lines).unwrap();
    let half = 1 << (frame.fraction_bits - 1);
    assert_eq!(frame.facets[0][0], [19 * half, -half, 9 * half]);
}

#[test]
fn the_span_decides_the_fraction_bits() {
    for (cells, bits) in [(1u32, 25), (6, 23), (14, 22), (1000, 16), (10_000, 12), (MAX_CELLS_PER_AXIS, 8)] {
        let lines = Lines::new([0.0; 3], [1.0; 3], [cells, 1, 1]).unwrap();
        assert_eq!(Frame::new(&[corner([0.5; 3])], &lines).unwrap().fraction_bits, bits, "{cells} cells");
    }
}

#[test]
fn a_far_geometry_is_named() {
    let lines = Lines::new([0.0; 3], [1.0; 3], [8; 3]).unwrap();
    let far = Geometry::new("antenna", 1, vec![[[1e6, 0.0, 0.0]; 3]]).unwrap();
    let error = Frame::new(&[corner([0.5; 3]), far], &lines).unwrap_err();
    assert_eq!(error.code(), "geometry-too-far");
    assert!(error.to_string().contains("antenna"), "{error}");
}

#[test]
fn higher_priority_then_later_wins() {
    let mut geometries = [corner([0.0; 3]), corner([0.0; 3]), corner([0.0; 3])];
    geometries[0].priority = 1;
    geometries[0].flag = 7;
    assert_eq!(Ranks::new(&geometries).geometry_at, [1, 2, 0]);
    assert_eq!(Ranks::new(&geometries).flag_of_rank, [1, 1, 7]);
}

#[test]
fn nearest_integers_are_found_from_bits() {
    let halves = (-8..8).map(|half| f64::from(half) / 2.0);
    for value in [-1e9, -2.6, -0.4, 0.0, 0.4, 1.6, 134_217_728.3, 1_073_741_823.5].into_iter().chain(halves) {
        assert_eq!(f64::from(nearest(value)), libm::rint(value), "{value}");
    }
}

use super::*;

fn tenths(corner: [i32; 3]) -> DVec3 {
    DVec3::from(corner.map(f64::from)) / 10.0
}

#[test]
fn the_gradient_is_that_of_theta() {
    let triangle = Triangle::new([[0, 1, 2], [30, 3, -1], [4, 20, 5]], tenths).unwrap();
    for point in [[1.0, 0.5, 2.0], [-3.0, 4.0, -2.0], [0.9, 0.8, -0.6]].map(DVec3::from) {
        let step = 1e-5;
        let difference = [DVec3::X, DVec3::Y, DVec3::Z]
            .map(|axis| (triangle.theta(point + axis * step) - triangle.theta(point - axis * step)) / (2.0 * step));
        let gradient = triangle.gradient(point);
        assert!((gradient - DVec3::from(difference)).length() < 1e-8, "{gradient} {difference:?}");
    }
}

/// Every cell of a box has the m that all triangles give it; a cell is 256 units of the snap.
fn assert_alone(caps: &[SnappedFacet], dims: [u32; 3], sizes: [f64; 3]) {
    let unit = 1.0 / 256.0;
    let scale = DVec3::from(sizes) / sizes[0];
    let place = |corner: [i32; 3]| DVec3::from(corner.map(f64::from)) * unit * scale;
    let triangles: Vec<Triangle> = caps.iter().filter_map(|&cap| Triangle::new(cap, place)).collect();
    let cells = Cells { first: [0; 3], dims, centre: &|_, cell| i64::from(cell) << 8 };
    let found = shifts(caps, &cells, 8, sizes);
    let mut n_moved = 0;
    for z in 0..dims[2] {
        for y in 0..dims[1] {
            for x in 0..dims[0] {
                let point = DVec3::from([x, y, z].map(f64::from)) * scale
                    - DVec3::from(BEFORE.map(f64::from)) / 32.0 * unit * scale;
                let theta: f64 = triangles
                    .iter()
                    .map(|triangle| triangle.theta_of_centre([x, y, z].map(|i| i64::from(i) << 8), point))
                    .sum();
                let holds = |shift: &&Shift| {
                    [x, y, z]
                        .iter()
                        .zip(shift.low.iter().zip(shift.high))
                        .all(|(&c, (&low, high))| low <= c && c < high)
                };
                let m: i32 = found.iter().filter(holds).map(|shift| shift.m).sum();
                assert_eq!(m, (0.5 - theta).floor() as i32, "cell {x} {y} {z}, theta {theta}");
                n_moved += usize::from(m != 0);
            }
        }
    }
    assert!(n_moved > 0, "no cell is moved in {dims:?}");
}

#[test]
fn a_dipole_is_the_triangle_from_afar_and_its_derivatives_are_those_of_its_theta() {
    let triangle = Triangle::new([[0, 1, 2], [30, 3, -1], [4, 20, 5]], tenths).unwrap();
    for point in [[10.0, 5.0, 20.0], [-9.0, 12.0, -7.0], [2.0, 1.0, 9.0]].map(DVec3::from) {
        let distance = triangle.distance(point, DVec3::ZERO);
        let off = (triangle.dipole(point) - triangle.theta(point)).abs();
        assert!(off <= triangle.dipole_error(distance), "{off} at {point}");
        let step = 1e-4;
        let (gradient, curvature) = triangle.dipole_derivatives(point);
        for (axis, unit) in [DVec3::X, DVec3::Y, DVec3::Z].into_iter().enumerate() {
            let [before, after] = [-step, step].map(|step| point + unit * step);
            let slope = (triangle.dipole(after) - triangle.dipole(before)) / (2.0 * step);
            assert!((gradient[axis] - slope).abs() < 1e-9, "{gradient} {slope}");
            let [before, after] = [before, after].map(|point| triangle.dipole_derivatives(point).0);
            let turn = (after - before) / (2.0 * step);
            assert!((curvature.col(axis) - turn).length() < 1e-8, "{curvature} {turn}");
        }
    }
}

#[test]
fn many_small_caps_give_every_cell_what_it_has_by_itself() {
    // a tenth of the facets of a ball is missing, and some of its neighbours
    let mut state = 1u64;
    let mut random = |n: i32| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as i32 % n
    };
    let corner = |u: i32, v: i32| {
        let (u, v) = (f64::from(u) * PI / 24.0, f64::from(v) * PI / 24.0);
        [v.sin() * u.cos(), v.sin() * u.sin(), v.cos()].map(|c| ((20.0 + 17.0 * c) * 256.0) as i32)
    };
    let loops: Vec<Vec<[i32; 3]>> = (0..120)
        .map(|_| {
            let (u, v) = (random(48), 2 + random(20));
            match random(3) {
                0 => vec![corner(u, v), corner(u, v + 1), corner(u + 1, v)],
                1 => vec![corner(u, v), corner(u, v + 1), corner(u + 1, v + 1), corner(u + 1, v)],
                _ => vec![corner(u, v), corner(u, v + 2), corner(u + 2, v + 1), corner(u + 2, v)],
            }
        })
        .collect();
    assert_alone(&caps(&loops), [40; 3], [1.0; 3]);
}

#[test]
fn blocks_give_every_cell_what_it_has_by_itself() {
    // a bent loop of 16 corners, one of 3, and one far outside, in boxes of cells that are not cubes
    let bent: Vec<[i32; 3]> = (0..16)
        .map(|k| {
            let angle = f64::from(k) * PI / 8.0;
            let place = [8.0 + 5.0 * angle.cos(), 7.0 + 5.0 * angle.sin(), 6.0 + 4.0 * (3.0 * angle).cos()];
            place.map(|c| (c * 256.0) as i32)
        })
        .collect();
    let small = vec![[300, 500, 700], [900, 520, 650], [610, 1100, 900]];
    let beyond = vec![[-9000, 0, 0], [-9000, 4000, 0], [-9000, 4000, 4000], [-9000, 0, 4000]];
    let caps = caps(&[bent, small, beyond]);
    for (dims, sizes) in [([16, 16, 12], [1.0, 1.0, 1.0]), ([17, 5, 23], [0.1, 0.25, 0.07])] {
        assert_alone(&caps, dims, sizes);
    }
}

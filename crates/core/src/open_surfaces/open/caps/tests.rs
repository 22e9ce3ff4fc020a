use super::*;
use crate::base::control::at_once;
use crate::open_surfaces::open::orient::orient;

fn closed(loops: &[Vec<[i32; 3]>]) -> Vec<SnappedFacet> {
    at_once(caps(loops, &Control::default())).unwrap()
}

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
    let found = at_once(shifts(caps, &cells, 8, sizes, &Control::default())).unwrap();
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
                assert_eq!(m, (HALF - theta).floor() as i32, "cell {x} {y} {z}, theta {theta}");
                n_moved += usize::from(m != 0);
            }
        }
    }
    assert!(n_moved > 0, "no cell is moved in {dims:?}");
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
    assert_alone(&closed(&loops), [40; 3], [1.0; 3]);
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
    let caps = closed(&[bent, small, beyond]);
    for (dims, sizes) in [([16, 16, 12], [1.0, 1.0, 1.0]), ([17, 5, 23], [0.1, 0.25, 0.07])] {
        assert_alone(&caps, dims, sizes);
    }
}

/// A small generator of numbers.
struct Random(u64);

impl Random {
    fn below(&mut self, n: u64) -> u64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) % n
    }

    fn place(&mut self, span: u64) -> [i32; 3] {
        [0; 3].map(|_| self.below(256 * span) as i32 - 256)
    }
}

/// Caps of loops of all sizes: single triangles in a crowd, long loops, both in and around a box of cells that need not be cubes.
#[test]
fn hundreds_of_random_caps_give_every_cell_what_the_exact_sum_gives_it() {
    for seed in 0..500 {
        let mut random = Random(seed);
        let dims = [0; 3].map(|_| 1 + random.below(3) as u32);
        let sizes = [0; 3].map(|_| [1.0, 0.5, 0.1, 3.0][random.below(4) as usize]);
        let n_loops = [1, 3, 10, 40][random.below(4) as usize];
        let size = [1, 3, 12][random.below(3) as usize];
        let loops: Vec<Vec<[i32; 3]>> = (0..n_loops)
            .map(|_| {
                let (at, n) = (random.place(10), [3, 4, 7, 40][random.below(4) as usize]);
                (0..n).map(|_| [0, 1, 2].map(|axis| at[axis] + random.place(size)[axis])).collect()
            })
            .collect();
        let all = assert_same(&closed(&loops), dims, sizes, seed);
        assert!(all > 0, "seed {seed}");
    }
}

/// Of a pattern that leaves exactly a half open, no cell is a matter of rounding.
#[test]
fn where_half_of_a_ball_is_missing_cells_agree_with_the_exact_sum() {
    let at = |u: i32, v: i32| {
        let (u, v) = (f64::from(u) * PI / 12.0, f64::from(v) * PI / 12.0);
        [v.sin() * u.cos(), v.sin() * u.sin(), v.cos()].map(|c| ((10.0 + 9.0 * c) * 256.0).round() as i32)
    };
    let every_second = (0..24).flat_map(|u| (1..11).map(move |v| (u, v))).filter(|(u, v)| (u + v) % 2 == 0);
    let loops: Vec<_> =
        every_second.map(|(u, v)| vec![at(u, v), at(u, v + 1), at(u + 1, v + 1), at(u + 1, v)]).collect();
    assert_same(&closed(&loops), [20; 3], [1.0; 3], 0);
}

/// Of a ball whose facets are missing two by two, like the black squares of a board, so that theta is nearly a half all through it.
#[test]
fn where_every_second_square_of_a_ball_is_missing_cells_agree_with_the_exact_sum() {
    let at = |u: i32, v: i32| {
        let (u, v) = (f64::from(u % 40) * PI / 20.0, f64::from(v) * PI / 20.0);
        [v.sin() * u.cos(), v.sin() * u.sin(), v.cos()].map(|c| ((8.0 + 7.5 * c) * 256.0).round() as i32)
    };
    let squares = (0..40).flat_map(|u| (1..19).map(move |v| (u, v))).filter(|(u, v)| (u + v) % 2 == 0);
    let facets = squares.flat_map(|(u, v)| {
        let [a, b, c, d] = [at(u, v), at(u, v + 1), at(u + 1, v + 1), at(u + 1, v)];
        [[a, b, c], [a, c, d]]
    });
    let loops = at_once(orient(&facets.collect::<Vec<_>>(), [1.0; 3], &Control::default())).unwrap().loops;
    assert!(loops.len() > 300 && loops.iter().all(|corners| corners.len() == 4), "loops of four corners");
    assert_same(&closed(&loops), [16; 3], [1.0; 3], 0);
}

/// A sum of many turns, also of more than a whole one, is that of the arctangents.
#[test]
fn products_of_complex_numbers_are_sums_of_angles() {
    let mut random = Random(3);
    for _ in 0..500 {
        let at = random.place(6);
        let triangles: Vec<Triangle> =
            (0..random.below(300)).filter_map(|_| Triangle::new([0; 3].map(|_| random.place(6)), tenths)).collect();
        let (mut turn, point) = (Turn::new(), tenths(at) + DVec3::splat(0.013));
        triangles.iter().for_each(|triangle| turn.add(triangle, point));
        let angles = triangles.iter().map(|triangle| triangle.theta(point));
        let (sum, most) = angles.fold((0.0, 0.0), |(sum, most), theta| (sum + theta, most + theta.abs()));
        assert!((turn.theta() - sum).abs() < 1e-11 && turn.magnitude >= most * (1.0 - 1e-12), "{sum}");
    }
}

/// Every cell has the m of the sum over all triangles in order; returns the number of cells.
fn assert_same(caps: &[SnappedFacet], dims: [u32; 3], sizes: [f64; 3], seed: u64) -> usize {
    let (unit, scale) = (1.0 / 256.0, DVec3::from(sizes) / sizes[0]);
    let place = |corner: [i32; 3]| DVec3::from(corner.map(f64::from)) * unit * scale;
    let triangles: Vec<Triangle> = caps.iter().filter_map(|&cap| Triangle::new(cap, place)).collect();
    let cells = Cells { first: [0; 3], dims, centre: &|_, cell| i64::from(cell) << 8 };
    let found = at_once(shifts(caps, &cells, 8, sizes, &Control::default())).unwrap();
    let mut n = 0;
    for z in 0..dims[2] {
        for y in 0..dims[1] {
            for x in 0..dims[0] {
                let centre = [x, y, z].map(|i| i64::from(i) << 8);
                let before = DVec3::from(BEFORE.map(f64::from)) / 32.0 * unit * scale;
                let point = DVec3::from(centre.map(|units| units as f64)) * unit * scale - before;
                let theta = triangles.iter().fold(0.0, |sum, one| sum + one.theta_of_centre(centre, point));
                let holds = |shift: &&Shift| {
                    (0..3).all(|axis| shift.low[axis] <= [x, y, z][axis] && [x, y, z][axis] < shift.high[axis])
                };
                let m: i32 = found.iter().filter(holds).map(|shift| shift.m).sum();
                assert_eq!(m, (HALF - theta).floor() as i32, "seed {seed}, cell {x} {y} {z}, theta {theta}");
                n += 1;
            }
        }
    }
    n
}

/// Moments far away, expansions around a point, and both moved: all within the bound that is proven, of the sum over the triangles.
#[test]
fn expansions_are_within_their_bound() {
    assert_bound::<LOW>();
    assert_bound::<HIGH>();
}

fn assert_bound<const N: usize>() {
    for seed in 0..200 {
        let mut random = Random(seed);
        let near_by = |random: &mut Random| DVec3::from(random.place(4).map(f64::from)) / 512.0;
        let triangles: Vec<[DVec3; 3]> = (0..9).map(|_| [0; 3].map(|_| near_by(&mut random))).collect();
        let (centre, middle) = (near_by(&mut random), near_by(&mut random));
        let point = DVec3::from(random.place(30).map(f64::from)).normalize() * 9.0;
        let step = near_by(&mut random) * 0.3;
        let mut moments = Terms::<N>::zero();
        triangles.iter().for_each(|corners| harmonics::add_triangle(&mut moments, corners.map(|c| c - centre)));
        let mut other = Terms::zero();
        harmonics::add_moved(&mut other, &moments, centre - middle);
        let mut local = Terms::zero();
        add_around(&mut local, &other, point - middle);
        let local = moved(&local, step);
        let area = |[a, b, c]: &[DVec3; 3]| 0.5 * (*b - *a).cross(*c - *a).length();
        let (all, reach) = (triangles.iter().map(area).sum(), |from: DVec3| {
            triangles.iter().flatten().map(|corner| corner.distance(from)).fold(0.0, f64::max)
        });
        let at = point + step;
        let exact: f64 = triangles.iter().map(|corners| solid_angle(corners.map(|corner| corner - at))).sum();
        let by_moments = far(&moments, at - centre);
        assert!(
            (by_moments - exact).abs() <= tail(degree(N), all, reach(centre), at.distance(centre)) + 1e-15,
            "seed {seed}"
        );
        let bound = tail(degree(N), all, reach(middle) + step.length(), point.distance(middle));
        let (by_local, change) = value_and_change(&local, 0.1);
        assert!((by_local - exact).abs() <= bound + 1e-15, "seed {seed}: {by_local} {exact} {bound}");
        let beside = DVec3::new(0.06, -0.06, 0.05);
        assert!((near(&local, beside) - by_local).abs() <= change, "seed {seed}");
    }
}

/// Over 4 pi, by the angles between the planes through the edges: another formula than that of the mesher.
fn solid_angle([a, b, c]: [DVec3; 3]) -> f64 {
    let between = |one: DVec3, two: DVec3, apex: DVec3| {
        let (u, v) = (apex.cross(one), apex.cross(two));
        libm::acos((u.dot(v) / (u.length() * v.length())).clamp(-1.0, 1.0))
    };
    let excess = between(b, c, a) + between(c, a, b) + between(a, b, c) - PI;
    libm::copysign(excess, a.dot(b.cross(c))) / (4.0 * PI)
}

/// The work is announced, rests again and again, and ends where it is cancelled at any of its rests.
#[test]
fn it_rests_and_ends_at_any_rest() {
    use std::sync::Arc;
    use std::sync::atomic::{AtomicUsize, Ordering};

    let mut random = Random(7);
    let loops: Vec<Vec<[i32; 3]>> = (0..60)
        .map(|_| {
            let at = random.place(30);
            (0..5).map(|_| [0, 1, 2].map(|axis| at[axis] + random.place(4)[axis])).collect()
        })
        .collect();
    let caps = closed(&loops);
    let cells = Cells { first: [0; 3], dims: [32; 3], centre: &|_, cell| i64::from(cell) << 8 };
    let run = |last: usize| {
        let (n_rests, n_works) = (Arc::new(AtomicUsize::new(0)), Arc::new(AtomicUsize::new(0)));
        let (rests, works, token) = (n_rests.clone(), n_works.clone(), CancelToken::default());
        let cancel = token.clone();
        let mut control = Control::default()
            .pausing(move || {
                if rests.fetch_add(1, Ordering::Relaxed) + 1 == last {
                    cancel.cancel();
                }
                Box::pin(async {})
            })
            .on_holes(move |work| {
                assert!(work.triangles > 150 && (100..=32 * 32 * 32).contains(&work.cells));
                works.fetch_add(1, Ordering::Relaxed);
            });
        control.cancel = token;
        let result = at_once(shifts(&caps, &cells, 8, [1.0; 3], &control));
        assert_eq!(n_works.load(Ordering::Relaxed), 1);
        (result.is_ok(), n_rests.load(Ordering::Relaxed))
    };
    let (is_done, n_rests) = run(usize::MAX);
    assert!(is_done && n_rests >= 4, "{n_rests} rests");
    for last in [1, 2, n_rests / 2, n_rests] {
        assert_eq!(run(last), (false, last));
    }
}

/// Turning facets, holes, loops and caps rest at least once in so many facets, and end where they are cancelled at any rest.
#[test]
fn what_is_linear_in_facets_rests_and_ends_at_any_rest() {
    use std::sync::Arc;
    use std::sync::atomic::{AtomicUsize, Ordering};

    let corner = |u: i32, v: i32| [16 * u, 16 * v, (u * u + 3 * v * v) % 11];
    let squares = (0..300).flat_map(|u| (0..300).map(move |v| (u, v))).filter(|(u, v)| (u + v) % 2 == 0);
    let facets: Vec<SnappedFacet> = squares
        .flat_map(|(u, v)| {
            let [a, b, c, d] = [corner(u, v), corner(u + 1, v), corner(u + 1, v + 1), corner(u, v + 1)];
            [[a, b, c], [a, c, d]]
        })
        .collect();
    let run = |last: usize| {
        let (n_rests, token) = (Arc::new(AtomicUsize::new(0)), CancelToken::default());
        let (rests, cancel) = (n_rests.clone(), token.clone());
        let mut control = Control::default().pausing(move || {
            if rests.fetch_add(1, Ordering::Relaxed) + 1 == last {
                cancel.cancel();
            }
            Box::pin(async {})
        });
        control.cancel = token;
        let work = async { caps(&orient(&facets, [1.0; 3], &control).await?.loops, &control).await };
        (at_once(work).is_ok(), n_rests.load(Ordering::Relaxed))
    };
    let (is_done, n_rests) = run(usize::MAX);
    assert!(is_done && n_rests >= facets.len() / 8192, "{n_rests} rests in {} facets", facets.len());
    for last in [1, 4, n_rests / 2, n_rests] {
        assert_eq!(run(last), (false, last));
    }
}

//! The cells along surfaces, against their definitions in big integers: a facet clipped by the box of a cell, and the steps from
//! centre to centre that a surface crosses.

use std::collections::VecDeque;

use hexcast::geometry::{Facet, Geometry};
use hexcast::job::{Fill, GeometryJob, Job, LinesJob, Rule};
use hexcast::lines::Lines;
use hexcast::pipeline::Engine;
use num_bigint::{BigInt, Sign};

use super::models::{self, Facets};
use super::open_surfaces::{Exact, crossed, flags_of, meshed, without};
use super::oracle;
use super::soups::Random;

const DOMAIN: [f64; 6] = [0.0, 0.0, 0.0, 8.0, 8.0, 8.0];

fn job(dims: [u32; 3], fill: Fill, shell: bool) -> Job {
    let geometry = set!(GeometryJob { fill: Some(fill), shell, ..GeometryJob::default() });
    set!(Job { dims: Some(dims), domain: Some(DOMAIN), geometries: vec![geometry], ..Job::default() })
}

/// Flags of a mesh, and the cells that its report says were added.
fn filled(facets: &Facets, job: &Job, axis: usize) -> (Vec<u8>, u64, Lines) {
    let (mesh, report) = meshed(std::slice::from_ref(facets), job, axis, &mut Engine::cpu()).expect("a mesh");
    (flags_of(&mesh), report.filled.iter().map(|filled| filled.added_cells).sum(), mesh.lines().clone())
}

fn snapped(facets: &Facets, lines: &Lines) -> (Vec<[Exact; 3]>, u64) {
    oracle::snapped_facets(&Geometry::new("g", 1, facets.clone()).unwrap(), lines)
}

fn index([x, y, z]: [usize; 3], [nx, ny, _]: [usize; 3]) -> usize {
    x + nx * (y + ny * z)
}

fn cells([nx, ny, nz]: [usize; 3]) -> impl Iterator<Item = [usize; 3]> {
    (0..nz).flat_map(move |z| (0..ny).flat_map(move |y| (0..nx).map(move |x| [x, y, z])))
}

/// The same on lines that are not equally spaced; some of them lie where lines and centres of equal cells would.
fn graded(dims: [u32; 3], job: Job, random: &mut Random) -> Job {
    let mut list = |n: u32| {
        let mut places: Vec<u64> = (1..64).collect();
        let inner = (1..n).map(|_| places.swap_remove(random.below(places.len() as u64) as usize) as f64 / 8.0);
        let mut list: Vec<f64> = inner.chain([0.0, 8.0]).collect();
        list.sort_by(f64::total_cmp);
        list
    };
    let [x, y, z] = dims.map(&mut list);
    set!(Job { lines: Some(LinesJob { x, y, z }), dims: None, domain: None, ..job })
}

/// Whether a facet has a point in the closed box of a cell: it is clipped by the six sides, in homogeneous coordinates.
fn touches(facet: &[Exact; 3], cell: [usize; 3], faces: &[Vec<BigInt>; 3]) -> bool {
    let mut polygon: Vec<[BigInt; 4]> =
        facet.iter().map(|[x, y, z]| [x.clone(), y.clone(), z.clone(), BigInt::from(1)]).collect();
    for axis in 0..3 {
        for (sign, bound) in [(1, &faces[axis][cell[axis]]), (-1, &faces[axis][cell[axis] + 1])] {
            let within = |p: &[BigInt; 4]| -> BigInt { (&p[axis] - bound * &p[3]) * sign };
            let mut clipped = Vec::new();
            for (from, to) in polygon.iter().zip(polygon.iter().cycle().skip(1)) {
                let (of_from, of_to) = (within(from), within(to));
                if of_from.sign() != Sign::Minus {
                    clipped.push(from.clone());
                }
                if of_from.sign() != of_to.sign() && (of_from.sign() == Sign::Minus || of_to.sign() == Sign::Minus) {
                    let (w, v) = (BigInt::from(of_from.magnitude().clone()), BigInt::from(of_to.magnitude().clone()));
                    clipped.push(std::array::from_fn(|k| &from[k] * &v + &to[k] * &w));
                }
            }
            polygon = clipped;
        }
    }
    !polygon.is_empty()
}

/// Facets with everything that is awkward: corners on lines, on centres and anywhere, parallel to axes, of no area, far beyond.
fn awkward(random: &mut Random, n: usize) -> Facets {
    let mut coordinate = |scale: u64| match random.below(4) {
        0 => random.below(17) as f32 * 0.5,
        1 => random.below(9) as f32,
        2 => (random.below(scale) as f32 / scale as f32) * 24.0 - 8.0,
        _ => random.below(scale) as f32 / scale as f32 * 8.0,
    };
    let mut facets: Facets =
        (0..n).map(|_| std::array::from_fn(|_| std::array::from_fn(|_| coordinate(1 << 20)))).collect();
    for (at, facet) in facets.iter_mut().enumerate() {
        match at % 6 {
            0 => (facet[1][2], facet[2][2]) = (facet[0][2], facet[0][2]),
            1 => facet[2] = facet[1],
            2 => *facet = [facet[0]; 3],
            3 => facet[2] = std::array::from_fn(|axis| 0.5 * (facet[0][axis] + facet[1][axis])),
            _ => {}
        }
    }
    facets
}

#[test]
fn conservative_is_every_cell_that_a_facet_touches() {
    let mut random = Random::new(11);
    let dims = [7usize, 5, 8];
    let (mut n_touched, mut n_free) = (0, 0);
    for round in 0..120 {
        let facets = awkward(&mut random, 1 + round % 4);
        let sizes = dims.map(|n| n as u32);
        let equal = job(sizes, Fill::Conservative, true);
        let job = if round % 2 == 0 { equal } else { graded(sizes, equal, &mut random) };
        let (flags, added, lines) = filled(&facets, &job, round % 3);
        assert_eq!(lines.is_graded(), round % 2 == 1);
        let (exact, bits) = snapped(&facets, &lines);
        let faces = [0, 1, 2].map(|axis| oracle::faces(&lines, axis, bits));
        for cell in cells(dims) {
            let expected = exact.iter().any(|facet| touches(facet, cell, &faces));
            assert_eq!(flags[index(cell, dims)] != 0, expected, "round {round}, cell {cell:?} of {facets:?}");
            *(if expected { &mut n_touched } else { &mut n_free }) += 1;
        }
        assert_eq!(added, flags.iter().map(|&flag| u64::from(flag)).sum::<u64>());
    }
    assert!(n_touched > 1500 && n_free > 20_000, "{n_touched} touched, {n_free} not");
}

/// The number of facets that cross the step from a cell to its neighbour above. Centres stand a little before themselves, by lengths
/// that no two facets can mistake: units of 2^-200 of the snap.
fn crossed_step(exact: &[[Exact; 3]], cell: [usize; 3], axis: usize, centres: &[Vec<BigInt>; 3]) -> usize {
    let at = |cell: [usize; 3]| -> Exact {
        let before = [130u32, 65, 0].map(|power| BigInt::from(1) << power);
        std::array::from_fn(|k| (&centres[k][cell[k]] << 200u32) - &before[k])
    };
    let mut next = cell;
    next[axis] += 1;
    let (from, to) = (at(cell), at(next));
    let is_crossed = |facet: &&[Exact; 3]| {
        let facet = std::slice::from_ref(*facet);
        crossed(facet, &from, axis).0 != crossed(facet, &to, axis).0
    };
    exact.iter().filter(is_crossed).count()
}

/// The cells that can be reached from a cell over face neighbours whose flag is 0.
fn flooded(flags: &[u8], dims: [usize; 3], from: [usize; 3]) -> Vec<bool> {
    let mut reached = vec![false; flags.len()];
    let mut next = VecDeque::from([from]);
    reached[index(from, dims)] = true;
    while let Some(cell) = next.pop_front() {
        for axis in 0..3 {
            for step in [usize::MAX, 1] {
                let mut neighbour = cell;
                neighbour[axis] = cell[axis].wrapping_add(step);
                if neighbour[axis] >= dims[axis] {
                    continue;
                }
                let at = index(neighbour, dims);
                if flags[at] == 0 && !std::mem::replace(&mut reached[at], true) {
                    next.push_back(neighbour);
                }
            }
        }
    }
    reached
}

/// A closed body or a sheet with an edge, of coordinates on lines, on centres and anywhere.
fn body(seed: u64) -> Facets {
    let mut random = Random::new(seed);
    let mut place = || match random.below(3) {
        0 => 1.0 + random.below(13) as f32 * 0.5,
        _ => 0.7 + random.below(1 << 20) as f32 / (1 << 20) as f32 * 6.6,
    };
    match seed % 5 {
        0 => models::tetrahedron(std::array::from_fn(|_| std::array::from_fn(|_| place()))),
        1 => models::octahedron([place(), 1.0, 0.5], [7.5, place(), 7.0]),
        2 => models::cuboid([1.0, 1.5, 0.25 * place()], [2.0 + 0.5 * place(), 6.5, 7.5]),
        3 => models::sphere([place() * 0.25 + 3.0, 4.0, 4.0], 3.1, 7),
        _ => models::cone([4.0, 4.0, 1.0], 3.0, [place(), place(), 7.0], 9),
    }
}

#[test]
fn no_step_between_two_cells_outside_of_a_separating_sheet_crosses_the_surface() {
    let dims = [8usize, 9, 8];
    let mut n_sheet = 0;
    for seed in 0..200 {
        let whole = body(seed);
        let is_open = seed % 2 == 1;
        let facets = if is_open { without(&whole, 0.3, seed) } else { whole };
        let sizes = dims.map(|n| n as u32);
        let with = |fill: Fill, shell: bool| {
            let equal = job(sizes, fill, shell);
            if seed % 4 < 2 { equal } else { graded(sizes, equal, &mut Random::new(seed)) }
        };
        let (sheet, _, lines) = filled(&facets, &with(Fill::Separating, true), seed as usize % 3);
        assert_eq!(lines.is_graded(), seed % 4 >= 2);
        let (mut exact, bits) = snapped(&facets, &lines);
        let centres = [0, 1, 2].map(|axis| oracle::centres(&lines, axis, bits));
        exact.iter_mut().flatten().flatten().for_each(|coordinate| *coordinate <<= 200);
        for cell in cells(dims) {
            for axis in (0..3).filter(|&axis| cell[axis] + 1 < dims[axis]) {
                let mut next = cell;
                next[axis] += 1;
                if sheet[index(cell, dims)] == 0 && sheet[index(next, dims)] == 0 {
                    assert_eq!(crossed_step(&exact, cell, axis, &centres), 0, "seed {seed}, {cell:?} along {axis}");
                }
            }
        }
        n_sheet += sheet.iter().filter(|&&flag| flag != 0).count();
        if is_open {
            continue;
        }
        let (inside, _, _) = filled(&facets, &with(Fill::Centre, false), 0);
        let reached = flooded(&sheet, dims, [0; 3]);
        for (at, &is_reached) in reached.iter().enumerate() {
            assert!(!is_reached || inside[at] == 0, "seed {seed}: the inside is reached at cell {at}");
        }
        // with the cells inside nothing but the outside is left
        let (solid, added, _) = filled(&facets, &with(Fill::Separating, false), 1);
        for at in 0..solid.len() {
            assert_eq!(solid[at] != 0, sheet[at] != 0 || inside[at] != 0, "seed {seed}, cell {at}");
        }
        let n_added = (0..solid.len()).filter(|&at| solid[at] != 0 && inside[at] == 0).count();
        assert_eq!(added, n_added as u64, "seed {seed}");
    }
    assert!(n_sheet > 10_000, "{n_sheet} cells in all");
}

#[test]
fn a_sheet_through_the_domain_separates_its_two_sides() {
    let dims = [9usize, 8, 10];
    for seed in 0..100 {
        let mut random = Random::new(1000 + seed);
        let heights: Vec<f32> = (0..36).map(|_| 1.5 + random.below(11) as f32 * 0.5).collect();
        let at = |i: usize, j: usize| [i as f32 * 2.0 - 1.0, j as f32 * 2.0 - 1.0, heights[i + 6 * j]];
        let mut facets: Facets = Vec::new();
        for (i, j) in (0..5).flat_map(|i| (0..5).map(move |j| (i, j))) {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            facets.extend([[a, b, c], [a, c, d]]);
        }
        // turned about, so that it lies across each axis
        let turn = |corner: [f32; 3]| std::array::from_fn(|axis| corner[(axis + seed as usize) % 3]);
        let facets = models::mapped(&facets, turn);
        let (sheet, _, lines) = filled(&facets, &job(dims.map(|n| n as u32), Fill::Separating, true), 0);
        assert_eq!(lines.dims().map(|n| n as usize), dims);
        let reached = flooded(&sheet, dims, [0; 3]);
        let end = dims.map(|n| n - 1);
        assert!(sheet[0] == 0 && sheet[index(end, dims)] == 0, "seed {seed}: both ends are free");
        assert!(!reached[index(end, dims)], "seed {seed}: a path leads through the sheet");
    }
}

#[test]
fn a_plate_without_thickness_is_one_layer_or_two() {
    let plate = |z: f32| -> Facets {
        let [a, b, c, d] = [[1.0, 1.0, z], [7.0, 1.0, z], [7.0, 7.0, z], [1.0, 7.0, z]];
        vec![[a, b, c], [a, c, d]]
    };
    let layers = |z: f32, fill: Fill| -> Vec<usize> {
        let (flags, _, _) = filled(&plate(z), &job([8; 3], fill, false), 0);
        (0..8).map(|layer| flags[layer * 64..][..64].iter().filter(|&&flag| flag != 0).count()).collect()
    };
    // inside of a cell, through its centre, and between two
    for z in [3.2, 3.5, 3.9] {
        assert_eq!(layers(z, Fill::Separating), [0, 0, 0, 36, 0, 0, 0, 0], "{z}");
        assert_eq!(layers(z, Fill::Conservative), [0, 0, 0, 64, 0, 0, 0, 0], "{z}");
        assert_eq!(layers(z, Fill::Centre), [0; 8], "{z}");
    }
    assert_eq!(layers(4.0, Fill::Separating).iter().sum::<usize>(), 36);
    assert_eq!(layers(4.0, Fill::Conservative), [0, 0, 0, 64, 64, 0, 0, 0]);
    // at the end of the domain there is nothing beyond
    assert_eq!(layers(8.0, Fill::Conservative), [0, 0, 0, 0, 0, 0, 0, 64]);
    assert_eq!(layers(9.0, Fill::Conservative), [0; 8]);
    assert_eq!(layers(-0.1, Fill::Separating), [0; 8]);
}

#[test]
fn whose_cells_win_does_not_depend_on_who_is_filled() {
    let low: Vec<Facet> = models::cuboid([1.0; 3], [4.2, 6.0, 6.0]);
    let high: Vec<Facet> = models::cuboid([4.2, 1.0, 1.0], [7.0, 6.0, 6.0]);
    let geometry =
        |fill: Fill, priority: i32| set!(GeometryJob { fill: Some(fill), priority, ..GeometryJob::default() });
    let with = |fills: [Fill; 2], priorities: [i32; 2]| {
        let geometries = vec![geometry(fills[0], priorities[0]), geometry(fills[1], priorities[1])];
        let job = set!(Job { geometries, rule: Rule::Nonzero, ..job([8; 3], Fill::Centre, false) });
        let (mesh, report) = meshed(&[low.clone(), high.clone()], &job, 1, &mut Engine::cpu()).expect("a mesh");
        let flags = flags_of(&mesh);
        let row: Vec<u8> = (0..8).map(|x| flags[index([x, 3, 3], [8; 3])]).collect();
        (row, report.filled.iter().map(|filled| (filled.geometry.clone(), filled.added_cells)).collect::<Vec<_>>())
    };
    let centre = [0, 1, 1, 1, 2, 2, 2, 0];
    assert_eq!(with([Fill::Centre; 2], [0, 0]), (centre.to_vec(), vec![]));
    // the wall between them is in cell 4, which both touch
    let (row, added) = with([Fill::Conservative, Fill::Centre], [1, 0]);
    assert_eq!(row, [1, 1, 1, 1, 1, 2, 2, 0]);
    // 7 x 7 of layers 0 and 4, and around the 3 between them 49 less 25
    assert_eq!(added, [("0".into(), 2 * 49 + 3 * 24)]);
    let (row, added) = with([Fill::Conservative, Fill::Centre], [0, 1]);
    assert_eq!(row, [1, 1, 1, 1, 2, 2, 2, 0]);
    assert_eq!(added, [("0".into(), 49 + 3 * 24 + 49 - 25)]);
}

#[test]
fn a_plate_that_would_have_no_cell_is_warned_about_unless_it_is_filled() {
    let plate = models::cuboid([1.0, 1.0, 3.1], [7.0, 7.0, 3.3]);
    let warnings = |fill: Fill| {
        let job = job([8; 3], fill, false);
        meshed(std::slice::from_ref(&plate), &job, 2, &mut Engine::cpu()).expect("a mesh").1.warnings
    };
    assert!(matches!(&warnings(Fill::Centre)[..], [one] if one.contains("keep it with fill")));
    for fill in [Fill::Separating, Fill::Conservative] {
        // it is kept, and thicker than it is
        assert!(matches!(&warnings(fill)[..], [one] if one.contains(" times the volume of its surface")));
    }
}

#[test]
fn an_inverted_geometry_has_the_cells_that_are_outside() {
    let ball = models::sphere([4.0; 3], 3.1, 12);
    let bodies = [
        ball.clone(),
        without(&ball, 0.05, 1),
        models::joined([models::sphere([3.0; 3], 2.4, 7), models::sphere([5.2; 3], 2.3, 6)]),
        models::cuboid([-1.0; 3], [9.0, 9.0, 4.0]),
        models::cuboid([20.0; 3], [21.0; 3]),
    ];
    for (index, body) in bodies.iter().enumerate() {
        for rule in [Rule::Parity, Rule::Nonzero] {
            for axis in 0..3 {
                let with = |invert: bool| {
                    let mut job = set!(Job { rule, ..job([9, 8, 10], Fill::Centre, false) });
                    job.geometries[0].invert = invert;
                    let meshed = meshed(std::slice::from_ref(body), &job, axis, &mut Engine::cpu());
                    let (mesh, report) = meshed.expect("a mesh");
                    (flags_of(&mesh), report.crossings)
                };
                let ((inside, n_crossings), (outside, n_again)) = (with(false), with(true));
                let other: Vec<u8> = inside.iter().map(|flag| 1 - flag).collect();
                assert_eq!(outside, other, "body {index}, {rule:?}, axis {axis}");
                assert_eq!(n_crossings, n_again);
            }
        }
    }
}

//! Fractions of cells and faces in random jobs. Of boxes they are known in closed form, whatever these overlap; of bodies at angles by the clipped
//! tetrahedra of [`super::fractions`]. Every bound that is documented must hold for every cell, whether a ray meets what cuts it or not.

use std::collections::BTreeMap;

use hexcast::fractions::{Fraction, Fractions};
use hexcast::geometry::Geometry;
use hexcast::job::FractionsJob;
use hexcast::lines::Lines;

use super::fractions::{Point, exact, measured_as, minus, triple, turned};
use super::models::{self, Facets};
use super::soups::Random;

/// A box and its flag; a later one wins.
type Body = ([[f32; 3]; 2], u8);

const DIMS: [u32; 3] = [4, 3, 5];

/// What is known of a cell: the fraction of each flag, and those of its six faces.
type Known = (BTreeMap<u8, f64>, [BTreeMap<u8, f64>; 6]);

/// An entry of each flag of each cell.
type Rows = BTreeMap<[u32; 3], BTreeMap<u8, (f32, [f32; 6])>>;

fn rows(found: &Fractions) -> Rows {
    let entries: Vec<(Fraction, [f32; 6])> = found.iter().copied().zip(found.faces().copied()).collect();
    assert_eq!((entries.len(), found.faces().count()), (found.len(), found.len()));
    let mut rows = Rows::new();
    for (of, faces) in entries {
        let [nx, ny, _] = DIMS.map(u64::from);
        let cell = [of.cell % nx, of.cell / nx % ny, of.cell / (nx * ny)].map(|at| at as u32);
        assert!((0.0..=1.0).contains(&of.fraction), "{of:?}");
        assert!(rows.entry(cell).or_default().insert(of.flag, (of.fraction, faces)).is_none(), "{of:?} twice");
    }
    rows
}

fn ends(cell: [u32; 3], lines: &Lines) -> [Point; 2] {
    [0, 1].map(|by| [0, 1, 2].map(|axis| lines.line(axis, cell[axis] + by)))
}

/// Lines of unit cells, or of some that differ in size; all are exact in f32.
fn lines_of(random: &mut Random) -> Lines {
    let is_graded = random.below(2) == 0;
    let list = |axis: usize, random: &mut Random| {
        let mut list = vec![0.0];
        for cell in 0..DIMS[axis] as usize {
            let size = if is_graded { random.between(3, 12) as f64 / 8.0 } else { 1.0 };
            list.push(list[cell] + size);
        }
        list
    };
    Lines::from_lists([list(0, random), list(1, random), list(2, random)]).unwrap()
}

/// Boxes of which some are plates of a twentieth of a cell, and some end on lines.
fn bodies(random: &mut Random, lines: &Lines) -> Vec<Body> {
    let body = |flag: u8, random: &mut Random| {
        let mut bounds = [[0.0f32; 3]; 2];
        for axis in 0..3 {
            let last = lines.line(axis, DIMS[axis]);
            let anywhere = |random: &mut Random| (random.below(1 << 16) as f64 / 65536.0 * (last + 1.0) - 0.5) as f32;
            let on_a_line =
                |random: &mut Random| lines.line(axis, random.below(u64::from(DIMS[axis]) + 1) as u32) as f32;
            let one = |random: &mut Random| if random.below(3) == 0 { on_a_line(random) } else { anywhere(random) };
            let (low, high) = (one(random), one(random));
            (bounds[0][axis], bounds[1][axis]) = match random.below(5) {
                0 => (low, low + 0.05),
                _ if low == high => (low, low + 0.5),
                _ => (low.min(high), low.max(high)),
            };
        }
        (bounds, flag)
    };
    let n = 1 + random.below(4) as usize;
    [1, 2, 1, 7][..n].iter().map(|flag| body(*flag, random)).collect()
}

/// The shares of flags in a box of points, by the pieces into which the ends of all boxes divide it.
fn shares(bodies: &[Body], [low, high]: [Point; 2]) -> BTreeMap<u8, f64> {
    let pieces = [0, 1, 2].map(|axis: usize| {
        let ends = bodies.iter().flat_map(|(bounds, _)| bounds.map(|corner| f64::from(corner[axis])));
        let mut places: Vec<f64> =
            ends.filter(|at| low[axis] < *at && *at < high[axis]).chain([low[axis], high[axis]]).collect();
        places.sort_by(f64::total_cmp);
        places.dedup();
        let whole = high[axis] - low[axis];
        places.windows(2).map(|two| (0.5 * (two[0] + two[1]), (two[1] - two[0]) / whole)).collect::<Vec<_>>()
    });
    let mut shares = BTreeMap::new();
    for &(x, of_x) in &pieces[0] {
        for &(y, of_y) in &pieces[1] {
            for &(z, of_z) in &pieces[2] {
                let holds = |(bounds, _): &&Body| {
                    [x, y, z]
                        .iter()
                        .enumerate()
                        .all(|(axis, at)| f64::from(bounds[0][axis]) < *at && *at < f64::from(bounds[1][axis]))
                };
                let flag = bodies.iter().rev().find(holds).map_or(0, |body| body.1);
                *shares.entry(flag).or_insert(0.0) += of_x * of_y * of_z;
            }
        }
    }
    shares
}

/// A face is what lies a little below it, thinner than any plate.
fn box_of_face([mut low, mut high]: [Point; 2], face: usize) -> [Point; 2] {
    let (axis, at) = (face / 2, if face.is_multiple_of(2) { low[face / 2] } else { high[face / 2] });
    (low[axis], high[axis]) = (at - 1e-5, at);
    [low, high]
}

/// Places across axes at which walls of boxes pass through the inside of a cell.
fn n_walls(bodies: &[Body], [low, high]: [Point; 2], axes: &[usize]) -> usize {
    let of_axis = |&axis: &usize| {
        let ends = bodies.iter().flat_map(|(bounds, _)| bounds.map(|corner| f64::from(corner[axis])));
        let mut places: Vec<f64> = ends.filter(|at| low[axis] < *at && *at < high[axis]).collect();
        places.sort_by(f64::total_cmp);
        places.dedup();
        places.len()
    };
    axes.iter().map(of_axis).sum()
}

/// Holds what is found to the rules that need no knowledge of the bodies; `own` is the flag of a cell without an entry.
fn check_rows(rows: &Rows, own: &dyn Fn([u32; 3]) -> u8, label: &str) {
    for (cell, of_cell) in rows {
        let sum: f64 = of_cell.values().map(|of| f64::from(of.0)).sum();
        assert!((sum - 1.0).abs() < 1e-6, "{label}, cell {cell:?}: fractions add up to {sum}");
        for face in 0..6usize {
            let sum: f64 = of_cell.values().map(|of| f64::from(of.1[face])).sum();
            assert!(
                (sum - 1.0).abs() < 1e-6,
                "{label}, cell {cell:?}, face {face}: flags add up to {sum}, {of_cell:?}"
            );
        }
    }
    let of_face = |cell: [u32; 3], face: usize| -> BTreeMap<u8, u32> {
        match rows.get(&cell) {
            Some(of) => {
                of.iter().filter(|of| of.1.1[face] > 0.0).map(|(flag, of)| (*flag, of.1[face].to_bits())).collect()
            }
            None => BTreeMap::from([(own(cell), 1.0f32.to_bits())]),
        }
    };
    for cell in cells() {
        for axis in 0..3 {
            let mut next = cell;
            next[axis] += 1;
            if next[axis] < DIMS[axis] {
                let [one, other] = [of_face(cell, 2 * axis + 1), of_face(next, 2 * axis)];
                assert_eq!(one, other, "{label}: the face between {cell:?} and {next:?}");
            }
        }
    }
}

fn cells() -> impl Iterator<Item = [u32; 3]> {
    let [nx, ny, nz] = DIMS;
    (0..nx * ny * nz).map(move |index| [index % nx, index / nx % ny, index / (nx * ny)])
}

/// How far numbers of flags are from those that are known, at most.
fn off<'a>(found: impl Iterator<Item = (&'a u8, f64)>, known: &BTreeMap<u8, f64>) -> f64 {
    let mut all = known.clone();
    found.for_each(|(flag, of)| *all.entry(*flag).or_insert(0.0) -= of);
    all.values().fold(0.0, |most, of| f64::max(most, of.abs()))
}

/// Holds fractions of boxes to what is known, and returns the number of cells that are cut and have an entry of one flag alone.
fn check_boxes(bodies: &[Body], lines: &Lines, rays: u32, label: &str) -> usize {
    let geometries: Vec<Geometry> = bodies
        .iter()
        .map(|([low, high], flag)| Geometry::new("box", *flag, models::cuboid(*low, *high)).unwrap())
        .collect();
    let found = measured_as(
        &geometries,
        lines,
        set!(FractionsJob { rays: Some(rays), faces: true, ..FractionsJob::default() }),
    );
    let (rows, m, mut n_unmet) = (rows(&found), f64::from(rays), 0);
    let known: BTreeMap<[u32; 3], Known> = cells()
        .map(|cell| {
            let of = ends(cell, lines);
            (cell, (shares(bodies, of), [0, 1, 2, 3, 4, 5].map(|face| shares(bodies, box_of_face(of, face)))))
        })
        .collect();
    let most = |of: &BTreeMap<u8, f64>| of.iter().max_by(|one, other| one.1.total_cmp(other.1)).map_or(0, |of| *of.0);
    check_rows(&rows, &|cell| most(&known[&cell].0), label);
    let mut sums = BTreeMap::new();
    let mut bound = 0.0;
    for (cell, (of_cell, of_faces)) in &known {
        let of = ends(*cell, lines);
        let size: f64 = minus(of[1], of[0]).iter().product();
        of_cell.iter().for_each(|(flag, share)| *sums.entry(*flag).or_insert(0.0) += share * size);
        let own = n_walls(bodies, of, &[1, 2]) as f64 / (2.0 * m);
        // strips are across the axis that is neither that of the face nor that of its rays
        let of_strips = |face: usize| n_walls(bodies, of, &[[2, 2, 2, 2, 1, 1][face]]) as f64 / (2.0 * m) + 1e-5;
        let Some(rows) = rows.get(cell) else {
            assert!(of_cell[&most(of_cell)] > 1.0 - 1e-6, "{label}, cell {cell:?} has no entry: {of_cell:?}");
            for (face, of_face) in of_faces.iter().enumerate() {
                let far = off([(&most(of_cell), 1.0)].into_iter(), of_face);
                assert!(far <= of_strips(face), "{label}, cell {cell:?} has no entry, face {face}: {of_face:?}");
            }
            continue;
        };
        bound += own * size;
        n_unmet += usize::from(of_cell.len() > 1 && rows.values().any(|of| of.0 == 1.0));
        let far = off(rows.iter().map(|(flag, of)| (flag, f64::from(of.0))), of_cell);
        assert!(far <= own + 1e-5, "{label}, cell {cell:?}: {rows:?}, known {of_cell:?}, off by {far}, at most {own}");
        for (face, of_face) in of_faces.iter().enumerate() {
            let most = of_strips(face);
            let far = off(rows.iter().map(|(flag, of)| (flag, f64::from(of.1[face]))), of_face);
            assert!(far <= most, "{label}, cell {cell:?}, face {face}: {rows:?}, known {of_face:?}, at most {most}");
        }
    }
    for (flag, volume) in sums {
        let far = (found.volumes[usize::from(flag)] - volume).abs();
        assert!(far <= bound + 1e-4, "{label}: flag {flag} off by {far}, at most {bound}");
    }
    n_unmet
}

#[test]
fn fractions_of_boxes_are_as_near_as_is_said_in_300_jobs() {
    let mut n_unmet = 0;
    for seed in 27_000..27_300 {
        let mut random = Random::new(seed);
        let lines = lines_of(&mut random);
        let bodies = bodies(&mut random, &lines);
        let rays = random.one_of(&[1, 2, 4, 8]);
        n_unmet += check_boxes(&bodies, &lines, rays, &format!("seed {seed}, {rays} rays"));
    }
    println!("seeds 27000 to 27299: {n_unmet} cells are cut where no ray meets what cuts them");
    assert!(n_unmet > 300, "{n_unmet}");
}

/// The planes of facets that pass through the inside of a cell, as normals and heights, each once.
fn planes(facets: &Facets, [low, high]: [Point; 2]) -> Vec<[f64; 4]> {
    let mut found: Vec<[f64; 4]> = Vec::new();
    for [a, b, c] in facets.iter().map(|facet| facet.map(|corner| corner.map(f64::from))) {
        let (u, v) = (minus(b, a), minus(c, a));
        let normal = [0, 1, 2].map(|i: usize| u[(i + 1) % 3] * v[(i + 2) % 3] - u[(i + 2) % 3] * v[(i + 1) % 3]);
        let norm = normal.iter().map(|of| of * of).sum::<f64>().sqrt();
        let of_corner = |corner: usize| {
            let at = [0, 1, 2].map(|axis| if corner >> axis & 1 == 0 { low[axis] } else { high[axis] });
            triple(minus(at, a), u, v) / norm
        };
        let heights: Vec<f64> = (0..8).map(of_corner).collect();
        if heights.iter().any(|of| *of > 1e-6) && heights.iter().any(|of| *of < -1e-6) {
            let [x, y, z] = normal.map(|of| of / norm);
            let plane = [x, y, z, x * a[0] + y * a[1] + z * a[2]];
            let is_same = |other: &[f64; 4]| (0..4).all(|i| (other[i] - plane[i]).abs() < 1e-3);
            if !found.iter().any(is_same) {
                found.push(plane);
            }
        }
    }
    found
}

/// A convex body: a half-space, as far as the box is concerned; a plate at an angle; a tetrahedron.
fn convex(random: &mut Random) -> Facets {
    let mut at = |low: i32, high: i32| random.between(low * 64, high * 64) as f32 / 64.0;
    let by = [at(1, 3), at(1, 3), at(1, 4)];
    let far = |facets: &Facets| models::moved(&turned(facets), by);
    match at(0, 3) as u32 {
        0 => far(&models::cuboid([-20.0, -20.0, -20.0], [20.0, 20.0, 0.0])),
        1 => far(&models::cuboid([-20.0, -20.0, 0.0], [20.0, 20.0, at(0, 1) * 0.4 + 0.02])),
        _ => models::outwards(models::tetrahedron([0, 1, 2, 3].map(|_| [at(-1, 6), at(-1, 5), at(-1, 7)]))),
    }
}

#[test]
fn fractions_of_bodies_at_angles_are_as_near_as_is_said_in_200_jobs() {
    let (mut n_cut, mut n_unmet) = (0, 0);
    for seed in 28_000..28_200 {
        let mut random = Random::new(seed);
        let lines = lines_of(&mut random);
        let facets = convex(&mut random);
        let rays = random.one_of(&[1, 2, 4, 8]);
        let (m, label) = (f64::from(rays), format!("seed {seed}, {rays} rays"));
        let Ok(geometry) = Geometry::new("body", 3, facets.clone()) else { continue };
        let found = measured_as(
            &[geometry],
            &lines,
            set!(FractionsJob { rays: Some(rays), faces: true, ..FractionsJob::default() }),
        );
        let rows = rows(&found);
        let share = |[low, high]: [Point; 2]| exact(&facets, low, high) / minus(high, low).iter().product::<f64>();
        check_rows(&rows, &|cell| if share(ends(cell, &lines)) > 0.5 { 3 } else { 0 }, &label);
        for cell in cells() {
            let of = ends(cell, &lines);
            let known = share(of);
            let Some(rows) = rows.get(&cell) else {
                assert!(known.min(1.0 - known).abs() < 1e-4, "{label}, cell {cell:?} has no entry: {known}");
                continue;
            };
            let planes = planes(&facets, of);
            let most = match planes[..] {
                [] => 0.0,
                [_] => 1.0 / m,
                [one, other] if (0..3).all(|i| (one[i] + other[i]).abs() < 1e-3) => 2.0 / m,
                _ => 4.0 / m,
            };
            let own = rows.get(&3).map_or(0.0, |of| f64::from(of.0));
            assert!((own - known).abs() <= most + 1e-3, "{label}, cell {cell:?}: {own} of {known}, at most {most}");
            n_cut += usize::from(known.min(1.0 - known) > 1e-4);
            n_unmet += usize::from(known.min(1.0 - known) > 1e-4 && (own == 0.0 || own == 1.0));
            for face in 0..6 {
                let [mut low, mut high] = box_of_face(of, face);
                (low[face / 2], high[face / 2]) = (low[face / 2], high[face / 2] + 1e-5);
                let known = share([low, high]);
                let own = rows.get(&3).map_or(0.0, |of| f64::from(of.1[face]));
                assert!((own - known).abs() <= 1.0 / m + 1e-3, "{label}, cell {cell:?}, face {face}: {own} of {known}");
            }
        }
    }
    println!("seeds 28000 to 28199: {n_cut} cells are cut, {n_unmet} where no ray meets what cuts them");
    assert!(n_cut > 2000 && n_unmet > 50, "{n_cut} cut, {n_unmet} unmet");
}

#[test]
fn plates_that_rays_miss_are_cut_and_within_the_bound() {
    // across z, a twentieth of a cell thick: rays are at an eighth of a cell and every fourth from there
    let lines = Lines::new([0.0; 3], [1.0; 3], [4, 4, 5]).unwrap();
    for (low, of_cell) in [(2.6f32, 0.25f32), (2.2, 0.0)] {
        let plate = models::cuboid([0.0, 0.0, low], [4.0, 4.0, low + 0.05]);
        let found = measured_as(
            &[Geometry::new("plate", 5, plate).unwrap()],
            &lines,
            set!(FractionsJob { rays: Some(4), ..FractionsJob::default() }),
        );
        let volume = found.volumes[5];
        assert!(
            (volume - 16.0 * f64::from(of_cell)).abs() < 1e-6 && (volume - 0.8).abs() < 16.0 * 2.0 / 4.0,
            "{volume}"
        );
        let cells: std::collections::BTreeSet<u64> = found.iter().map(|of| of.cell).collect();
        assert_eq!(cells.len(), 16, "{low}");
        for of in found.iter() {
            let known = if of.flag == 5 { of_cell } else { 1.0 - of_cell };
            assert!((of.fraction - known).abs() < 1e-6, "{low}: {of:?}");
        }
    }
}

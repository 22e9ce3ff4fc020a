//! The fractions of cells against an oracle that casts nothing: a surface is the sum of the tetrahedra that its facets span with one point, each
//! with its sign, and each is clipped to a cell by the six planes of that.

use hexcast::control::Control;
use hexcast::fractions::{Fraction, Fractions, fractions};
use hexcast::geometry::{Facet, Geometry};
use hexcast::job::{FractionsJob, Rule};
use hexcast::lines::Lines;
use hexcast_core::grid::frame::Frame;
use hexcast_core::grid::window::CellWindow;
use hexcast_core::stages::inside::Kind;
use hexcast_derived::cut_cells::{CutBy, exact_fractions};

use super::models::{self, Facets};

pub(super) type Point = [f64; 3];

pub(super) fn minus(a: Point, b: Point) -> Point {
    [0, 1, 2].map(|axis| a[axis] - b[axis])
}

pub(super) fn triple(a: Point, b: Point, c: Point) -> f64 {
    (0..3).map(|i| a[i] * (b[(i + 1) % 3] * c[(i + 2) % 3] - b[(i + 2) % 3] * c[(i + 1) % 3])).sum()
}

/// Volume of a tetrahedron within a box.
fn volume_in(corners: [Point; 4], low: Point, high: Point) -> f64 {
    // cut into tetrahedra: those of one side of a plane are at most three
    let mut fractions = vec![corners];
    for axis in 0..3 {
        for (place, is_below) in [(low[axis], false), (high[axis], true)] {
            fractions = fractions.into_iter().flat_map(|fraction| side(fraction, axis, place, is_below)).collect();
        }
    }
    fractions.iter().map(|[a, b, c, d]| triple(minus(*b, *a), minus(*c, *a), minus(*d, *a)).abs() / 6.0).sum()
}

/// What of a tetrahedron lies on a side of a plane across an axis, as tetrahedra.
fn side(corners: [Point; 4], axis: usize, place: f64, is_below: bool) -> Vec<[Point; 4]> {
    let depth = |point: &Point| if is_below { place - point[axis] } else { point[axis] - place };
    let (inner, outer): (Vec<Point>, Vec<Point>) = corners.iter().partition(|point| depth(point) >= 0.0);
    let cut = |from: Point, to: Point| {
        let fraction = depth(&from) / (depth(&from) - depth(&to));
        [0, 1, 2].map(|axis| from[axis] + fraction * (to[axis] - from[axis]))
    };
    match (&inner[..], &outer[..]) {
        (_, []) => vec![corners],
        ([], _) => vec![],
        (&[a], &[b, c, d]) => vec![[a, cut(a, b), cut(a, c), cut(a, d)]],
        (&[a, b], &[c, d]) => wedge([a, cut(a, c), cut(a, d)], [b, cut(b, c), cut(b, d)]),
        (&[a, b, c], &[d]) => wedge([a, b, c], [cut(a, d), cut(b, d), cut(c, d)]),
        _ => unreachable!("four corners"),
    }
}

/// A body between two triangles.
fn wedge([a, b, c]: [Point; 3], [d, e, f]: [Point; 3]) -> Vec<[Point; 4]> {
    vec![[a, b, c, d], [b, c, d, e], [c, d, e, f]]
}

/// Volume of a closed surface within a cell.
pub(super) fn exact(facets: &[Facet], low: Point, high: Point) -> f64 {
    let from = [0.123, -0.371, 0.717];
    let of_facet = |facet: &Facet| {
        let [a, b, c] = facet.map(|corner| corner.map(f64::from));
        let sign = triple(minus(a, from), minus(b, from), minus(c, from)).signum();
        sign * volume_in([from, a, b, c], low, high)
    };
    facets.iter().map(of_facet).sum()
}

fn measured(geometries: &[Geometry], lines: &Lines, rays: u32) -> Fractions {
    measured_as(geometries, lines, set!(FractionsJob { rays: Some(rays), ..FractionsJob::default() }))
}

pub(super) fn measured_as(geometries: &[Geometry], lines: &Lines, job: FractionsJob) -> Fractions {
    let frame = Frame::new(geometries, lines).unwrap();
    let (kinds, window) = (vec![Kind::Cast; geometries.len()], CellWindow::all(lines.dims()));
    let (rule, control) = (Rule::Parity, Control::default());
    let Some(rays) = job.by_rays() else {
        let is_oriented = vec![true; geometries.len()];
        let by = CutBy { frame: &frame, lines, rule, kinds: &kinds, is_oriented: &is_oriented };
        return pollster::block_on(exact_fractions(by, window, job, u64::MAX, &control)).unwrap();
    };
    pollster::block_on(fractions((&frame, lines), window, (rule, &kinds), (job, rays), u64::MAX, &control)).unwrap()
}

/// Of every cell, in their order: where it is, its size, and what a closed surface has of it.
fn known(facets: &[Facet], lines: &Lines) -> Vec<([u32; 3], f64, f64)> {
    let [nx, ny, nz] = lines.dims();
    let of_cell = |index: u32| {
        let cell = [index % nx, index / nx % ny, index / (nx * ny)];
        let low = [0, 1, 2].map(|axis| lines.line(axis, cell[axis]));
        let high = [0, 1, 2].map(|axis| lines.line(axis, cell[axis] + 1));
        let size: f64 = (0..3).map(|axis| high[axis] - low[axis]).product();
        (cell, size, exact(facets, low, high) / size)
    };
    (0..nx * ny * nz).map(of_cell).collect()
}

/// Turned about an axis that is none of the grid's.
pub(super) fn turned(facets: &Facets) -> Facets {
    let (s, c) = (0.6f32, 0.8f32);
    let turn = |[x, y, z]: [f32; 3]| {
        let [x, y] = [c * x - s * y, s * x + c * y];
        let [y, z] = [c * y - s * z, s * y + c * z];
        [x, y, z]
    };
    models::mapped(facets, turn)
}

pub(super) fn bodies() -> Vec<(&'static str, Facets)> {
    vec![
        ("ball", models::sphere([0.1, -0.2, 0.3], 3.1, 24)),
        ("cone", models::cone([0.3, 0.2, -2.5], 2.4, [0.1, -0.4, 3.0], 24)),
        ("box", models::cuboid([-2.2, -1.7, -2.9], [1.9, 2.3, 2.6])),
        ("box at an angle", turned(&models::cuboid([-2.2, -1.7, -1.9], [1.9, 2.3, 1.6]))),
        ("cone at an angle", turned(&models::cone([0.3, 0.2, -2.5], 2.4, [0.1, -0.4, 3.0], 24))),
    ]
}

pub(super) fn grids() -> [Lines; 2] {
    let equal = Lines::new([-5.0; 3], [1.0; 3], [10; 3]).unwrap();
    let list = vec![-5.0, -4.0, -2.75, -2.0, -1.5, -1.0, -0.25, 0.5, 1.0, 2.0, 3.0, 3.5, 5.0];
    [equal, Lines::from_lists([list.clone(), list.clone(), list]).unwrap()]
}

#[test]
fn parts_of_cells_are_as_near_to_those_of_clipped_tetrahedra_as_is_said() {
    for (name, facets) in bodies() {
        let geometry = Geometry::new(name, 7, facets.clone()).unwrap();
        for lines in grids() {
            let cells = known(&facets, &lines);
            for rays in [2, 4, 8] {
                let found = measured(std::slice::from_ref(&geometry), &lines, rays);
                let mut dense = vec![None; cells.len()];
                for fraction in found.iter().filter(|fraction| fraction.flag == 7) {
                    dense[fraction.cell as usize] = Some(f64::from(fraction.fraction));
                }
                let (mut sum, mut sum_of_squares, mut n_cut, mut volume_cut) = (0.0, 0.0, 0.0, 0.0);
                for (&(cell, size, known), measured) in cells.iter().zip(&dense) {
                    sum += known * size;
                    let off = match measured {
                        Some(fraction) => (fraction - known).abs(),
                        None => known.abs().min((1.0 - known).abs()),
                    };
                    assert!(off < 1.0 / f64::from(rays), "{name}, {rays} rays, cell {cell:?}: {off} off {known}");
                    if known > 1e-6 && known < 1.0 - 1e-6 {
                        (sum_of_squares, n_cut) = (sum_of_squares + off * off, n_cut + 1.0);
                        volume_cut += size;
                    }
                }
                // on average far better, but where whole walls run along the rays
                let most = if name == "box" { 0.5 } else { 0.2 };
                let off = (sum_of_squares / n_cut).sqrt();
                assert!(off < most / f64::from(rays), "{name}, {rays} rays: {off} on average over {n_cut} cells");
                let volume = models::signed_volume(&facets);
                assert!((sum - volume).abs() < 1e-6 * volume, "{name}: the oracle has {sum} of {volume}");
                let off = (found.volumes[7] - volume).abs() / volume_cut;
                assert!(off < 0.5 / f64::from(rays), "{name}, {rays} rays: off by {off} of the volume of cut cells");
            }
        }
    }
}

/// Corners are snapped, by far less than the ten thousandth of a cell, which the oracle does not know.
#[test]
fn exact_parts_of_cells_are_those_of_clipped_tetrahedra() {
    for (name, facets) in bodies() {
        let geometry = Geometry::new(name, 7, facets.clone()).unwrap();
        for lines in grids() {
            let job = FractionsJob::default();
            let found = measured_as(std::slice::from_ref(&geometry), &lines, job);
            let cells = known(&facets, &lines);
            let mut parts = vec![None; cells.len()];
            found.iter().filter(|of| of.flag == 7).for_each(|of| parts[of.cell as usize] = Some(of.fraction));
            for ((cell, _, known), part) in cells.into_iter().zip(parts) {
                let off = match part {
                    Some(part) => (f64::from(part) - known).abs(),
                    None => known.abs().min((1.0 - known).abs()),
                };
                assert!(off < 1e-4, "{name}, cell {cell:?}: {part:?} where {known} is known");
            }
            let volume = models::signed_volume(&facets);
            assert!((found.volumes[7] / volume - 1.0).abs() < 1e-5, "{name}: {} of {volume}", found.volumes[7]);
            assert_eq!((found.rays, found.sampled_cells), (0, 0));
        }
    }
}

/// What of a segment along an axis lies in a convex body: the facets are turned outwards. None where it lies in the plane of a facet, but for rounding.
fn length_within(facets: &[Facet], from: Point, axis: usize, length: f64) -> Option<f64> {
    let (mut start, mut end) = (0.0f64, length);
    for facet in facets {
        let [a, b, c] = facet.map(|corner| corner.map(f64::from));
        let (u, v) = (minus(b, a), minus(c, a));
        let out = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
        let height: f64 = (0..3).map(|of| out[of] * (from[of] - a[of])).sum();
        let flat = 1e-6 * out.iter().map(|of| of.abs()).sum::<f64>();
        if height.abs() < flat && (height + out[axis] * length).abs() < flat {
            return None;
        }
        let place = -height / out[axis];
        match out[axis].total_cmp(&0.0) {
            std::cmp::Ordering::Greater => end = end.min(place),
            std::cmp::Ordering::Less => start = start.max(place),
            std::cmp::Ordering::Equal if height > 0.0 => return Some(0.0),
            std::cmp::Ordering::Equal => {}
        }
    }
    Some((end - start).max(0.0))
}

/// The first moments of a closed surface, by tetrahedra from the origin.
fn moments_of(facets: &[Facet]) -> Point {
    let mut moments = [0.0; 3];
    for facet in facets {
        let [a, b, c] = facet.map(|corner| corner.map(f64::from));
        let volume = triple(a, b, c) / 6.0;
        (0..3).for_each(|axis| moments[axis] += volume * (a[axis] + b[axis] + c[axis]) / 4.0);
    }
    moments
}

#[test]
fn edges_are_the_lengths_in_convex_bodies_and_centroids_have_their_moments() {
    for (name, facets) in bodies() {
        let geometry = Geometry::new(name, 7, facets.clone()).unwrap();
        for lines in grids() {
            let job = FractionsJob::default();
            let job = set!(FractionsJob { faces: true, edges: true, centroids: true, ..job });
            let found = measured_as(std::slice::from_ref(&geometry), &lines, job);
            let (mut moments, mut n_partial) = ([0.0; 3], 0);
            let (dims, mut cells) = (lines.dims(), known(&facets, &lines));
            let entries = found.iter().zip(found.edges()).zip(found.centroids()).zip(found.face_centroids());
            for (((of, edges), centroid), face_centroids) in entries.filter(|(((of, _), _), _)| of.flag == 7) {
                let [nx, ny, _] = dims.map(u64::from);
                let cell = [of.cell % nx, of.cell / nx % ny, of.cell / (nx * ny)].map(|at| at as u32);
                let low = [0, 1, 2].map(|axis| lines.line(axis, cell[axis]));
                let size = [0, 1, 2].map(|axis| lines.line(axis, cell[axis] + 1) - low[axis]);
                for (edge, &length) in edges.iter().enumerate() {
                    let (axis, place) = (edge / 4, edge % 4);
                    let mut from = low;
                    let others = (0..3).filter(|other| *other != axis);
                    others
                        .enumerate()
                        .for_each(|(bit, other)| from[other] += size[other] * f64::from(place as u32 >> bit & 1));
                    let Some(known) = length_within(&facets, from, axis, size[axis]) else { continue };
                    let off = (f64::from(length) - known / size[axis]).abs();
                    assert!(off < 1e-3, "{name}, {cell:?}, edge {edge}: {length}, {known} of {}", size[axis]);
                    n_partial += u32::from(length > 0.0 && length < 1.0);
                }
                let volume: f64 = f64::from(of.fraction) * size.iter().product::<f64>();
                (0..3).for_each(|axis| moments[axis] += volume * (low[axis] + size[axis] * f64::from(centroid[axis])));
                assert!(face_centroids.as_flattened().iter().all(|place| (0.0..=1.0).contains(place)));
                cells[of.cell as usize].2 = 0.0;
            }
            // all others are of one flag
            for &(cell, size, part) in &cells {
                let centre =
                    [0, 1, 2].map(|axis| 0.5 * (lines.line(axis, cell[axis]) + lines.line(axis, cell[axis] + 1)));
                (0..3).for_each(|axis| moments[axis] += part.round() * size * centre[axis]);
            }
            let known = moments_of(&facets);
            let off = (0..3).map(|axis| (moments[axis] - known[axis]).abs()).fold(0.0, f64::max);
            assert!(off < 1e-3, "{name}: moments {moments:?} of {known:?}");
            assert!(n_partial > 40, "{name}: {n_partial} edges are divided");
        }
    }
}

#[test]
fn parts_of_a_cell_add_up_to_one_in_the_order_of_cells_and_flags() {
    let ball = |at: f32, flag: u8| Geometry::new("ball", flag, models::sphere([at, 0.2, 0.1], 2.4, 12)).unwrap();
    let geometries = [ball(-1.0, 9), ball(0.7, 2), ball(1.5, 9)];
    let (mut n_of_three, mut n) = (0, 0);
    for lines in grids() {
        let found = measured(&geometries, &lines, 4);
        let keys: Vec<(u64, u8)> = found.iter().map(|fraction| (fraction.cell, fraction.flag)).collect();
        assert!(keys.is_sorted_by(|one, other| one < other));
        let all: Vec<Fraction> = found.iter().copied().collect();
        for of_cell in all.chunk_by(|one, other| one.cell == other.cell) {
            let sum: f64 = of_cell.iter().map(|fraction| f64::from(fraction.fraction)).sum();
            assert!((sum - 1.0).abs() < 2e-7, "{of_cell:?}");
            // of one flag where no ray meets the surface
            let most = if of_cell.len() > 1 { 1.0f32.next_down() } else { 1.0 };
            assert!(of_cell.iter().all(|of| of.fraction > 0.0 && of.fraction <= most), "{of_cell:?}");
            n_of_three += usize::from(of_cell.len() == 3);
            n += 1;
        }
        assert!((found.volumes.iter().sum::<f64>() - 1000.0).abs() < 1e-9, "all of the box");
    }
    assert!(n > 300 && n_of_three > 5, "{n} cells, {n_of_three} of three flags");
}

#[test]
fn a_wall_along_the_rays_between_two_of_them_is_seen() {
    // no ray meets the walls across y and z; the fraction is that of the rays inside
    let facets = models::cuboid([-9.0, -0.25, -9.0], [9.0, 9.0, 9.0]);
    let lines = Lines::new([0.0, -1.0, 0.0], [1.0; 3], [3, 2, 1]).unwrap();
    let found = measured(&[Geometry::new("g", 1, facets).unwrap()], &lines, 4);
    let fractions: Vec<(u64, u8, f32)> =
        found.iter().map(|fraction| (fraction.cell, fraction.flag, fraction.fraction)).collect();
    let cell = |x: u64| [(x, 0, 0.75), (x, 1, 0.25)];
    assert_eq!(fractions, [cell(0), cell(1), cell(2)].concat());
    assert!((found.volumes[1] - 3.75).abs() < 1e-12 && (found.volumes[0] - 2.25).abs() < 1e-12);
}

#[test]
fn an_inverted_geometry_has_the_other_part() {
    let facets = models::cuboid([0.25; 3], [9.0; 3]);
    let lines = Lines::new([0.0; 3], [1.0; 3], [2, 1, 1]).unwrap();
    let frame = Frame::new(&[Geometry::new("g", 5, facets).unwrap()], &lines).unwrap();
    let job = FractionsJob::default();
    let found = pollster::block_on(fractions(
        (&frame, &lines),
        CellWindow::all(lines.dims()),
        (Rule::Parity, &[Kind::Inverted]),
        (job, 4),
        u64::MAX,
        &Control::default(),
    ))
    .unwrap();
    let parts: Vec<(u64, u8, f32)> =
        found.iter().map(|fraction| (fraction.cell, fraction.flag, fraction.fraction)).collect();
    let [outer, inner] = [1.0 - 0.421_875, 0.421_875];
    assert_eq!(parts, [(0, 0, inner), (0, 5, outer), (1, 0, 0.5625), (1, 5, 0.4375)]);
    let refused = pollster::block_on(fractions(
        (&frame, &lines),
        CellWindow::all(lines.dims()),
        (Rule::Parity, &[Kind::Cast]),
        (job, 4),
        10,
        &Control::default(),
    ))
    .unwrap_err();
    assert_eq!(refused.code(), "memory");
}

//! An oracle that shares nothing with the crate but the input types: another method in arbitrary precision.
//!
//! Geometries, mesh lines, a rule -> flags, cell by cell. Nothing is cast. A closed surface is the sum of the tetrahedra
//! that its facets span with one fixed point O, each counted with the sign of its volume: the winding number about a
//! point is the sum of the signs of the tetrahedra that hold it, its parity their number. All tests are signs of
//! integers of any length.
//!
//! Ties: a centre P stands for P - (e1, e2, e3) with e1 >> e2 >> e3 > 0. A plane's value there is
//! `n . (P - a) - n_x e1 - n_y e2 - n_z e3`, so its sign is the sign of the first of `n . (P - a), -n_x, -n_y, -n_z` that is
//! not zero. Faces of tetrahedra with volume have normals, so no point lies on any.
//!
//! The snap is part of the definition, and so is the rounding to f64 of `(w - origin) / spacing - 1/2`, with the smallest cell for the spacing where cells differ; from there on it
//! is exact: `round(u 2^F)` to nearest, ties to even, F the largest for which everything within one cell of a corner or a
//! centre spans at most 2^26 units an axis.
//!
//! Only for surfaces that are closed for the rule ([`is_closed`]): elsewhere the sum depends on O.
//! Cost: cells times facets, in big integers.

use std::collections::HashMap;
use std::ops::RangeInclusive;

use hexcast::geometry::Geometry;
use hexcast::lines::Lines;
use hexcast_core::stages::map::Rule;
use num_bigint::{BigInt, Sign};

pub(crate) type Vector = [BigInt; 3];

/// Binary places of the least f64: every f64 is an integer over 2^1074.
const F64_PLACES: u64 = 1074;

/// Flags of all cells, x fastest.
pub(crate) fn flags(geometries: &[Geometry], lines: &Lines, rule: Rule) -> Vec<u8> {
    flags_around(geometries, lines, rule, [false; 3])
}

/// Flags at the centres of cells, along some axes at their faces in place of centres, x fastest.
pub(crate) fn flags_around(geometries: &[Geometry], lines: &Lines, rule: Rule, at_faces: [bool; 3]) -> Vec<u8> {
    let insides = insides_around(geometries, lines, rule, at_faces);
    let mut order: Vec<usize> = (0..geometries.len()).collect();
    order.sort_by_key(|&index| geometries[index].priority);
    let n_places = (0..3).map(|axis| lines.dims()[axis] as usize + usize::from(at_faces[axis]));
    let mut flags = vec![0; n_places.product()];
    // painter: geometries that win paint over those that lose
    for index in order {
        for (flag, _) in flags.iter_mut().zip(&insides[index]).filter(|(_, is_inside)| **is_inside) {
            *flag = geometries[index].flag;
        }
    }
    flags
}

/// Which of these places each geometry holds.
pub(crate) fn insides_around(
    geometries: &[Geometry],
    lines: &Lines,
    rule: Rule,
    at_faces: [bool; 3],
) -> Vec<Vec<bool>> {
    let fraction_bits = fraction_bits(geometries, lines);
    let places = [0, 1, 2].map(|axis| {
        let places = if at_faces[axis] { faces } else { centres };
        places(lines, axis, fraction_bits)
    });
    let of_geometry = |geometry: &Geometry| {
        let tetrahedra: Vec<Tetrahedron> =
            snapped(geometry, lines, fraction_bits).iter().filter_map(Tetrahedron::new).collect();
        let rows = places[2].iter().flat_map(|z| places[1].iter().map(move |y| (z, y)));
        let all = rows.flat_map(|(z, y)| places[0].iter().map(move |x| [x, y, z].map(Clone::clone)));
        all.map(|place| is_inside(&tetrahedra, &place, rule)).collect()
    };
    geometries.iter().map(of_geometry).collect()
}

/// Flags at points anywhere, in world coordinates; all geometries are closed.
pub(crate) fn flags_at(geometries: &[Geometry], lines: &Lines, rule: Rule, points: &[[f64; 3]]) -> Vec<u8> {
    let bits = fraction_bits(geometries, lines);
    let unit = |world: f64, axis: usize| rounded(exact(cells_from_world(world, lines, axis)), F64_PLACES - bits);
    let places: Vec<Vector> = points.iter().map(|point| [0, 1, 2].map(|axis| unit(point[axis], axis))).collect();
    let mut order: Vec<&Geometry> = geometries.iter().collect();
    order.sort_by_key(|geometry| geometry.priority);
    let mut flags = vec![0; points.len()];
    for geometry in order {
        let tetrahedra: Vec<Tetrahedron> = snapped(geometry, lines, bits).iter().filter_map(Tetrahedron::new).collect();
        for (flag, _) in flags.iter_mut().zip(&places).filter(|(_, place)| is_inside(&tetrahedra, place, rule)) {
            *flag = geometry.flag;
        }
    }
    flags
}

/// Places along an axis in units of the snap, of a geometry that is alone in a box.
pub(crate) fn unit_of(geometry: &Geometry, lines: &Lines, axis: usize, world: f64) -> BigInt {
    let bits = fraction_bits(std::slice::from_ref(geometry), lines);
    rounded(exact(cells_from_world(world, lines, axis)), F64_PLACES - bits)
}

/// Winding number of every geometry at every cell, x fastest, or its parity; and below the corners and centres that they come from.
pub(crate) fn insides(geometries: &[Geometry], lines: &Lines, rule: Rule) -> Vec<Vec<i32>> {
    let (snapped, centres) = snapped_all(geometries, lines);
    let [nx, ny, nz] = lines.dims();
    let of_geometry = |facets: &Vec<[Vector; 3]>| {
        let tetrahedra: Vec<Tetrahedron> = facets.iter().filter_map(Tetrahedron::new).collect();
        let winding = |cell: u32| {
            let cell = [cell % nx, cell / nx % ny, cell / (nx * ny)];
            let centre = std::array::from_fn(|axis| centres[axis][cell[axis] as usize].clone());
            let holding = tetrahedra.iter().filter(|tetrahedron| tetrahedron.holds(&centre));
            match rule {
                Rule::Parity => holding.count() as i32 % 2,
                Rule::Nonzero => holding.map(|tetrahedron| tetrahedron.winding).sum(),
            }
        };
        (0..nx * ny * nz).map(winding).collect()
    };
    snapped.iter().map(of_geometry).collect()
}

/// Corners of the facets of all geometries, and the centres of each axis, in units of the snap.
pub(crate) fn snapped_all(geometries: &[Geometry], lines: &Lines) -> (Vec<Vec<[Vector; 3]>>, [Vec<BigInt>; 3]) {
    let bits = fraction_bits(geometries, lines);
    let facets = geometries.iter().map(|geometry| snapped(geometry, lines, bits)).collect();
    (facets, [0, 1, 2].map(|axis| centres(lines, axis, bits)))
}

/// Whether the surface has no boundary: every edge is used an even number of times (parity) or as often in one
/// direction as in the other (nonzero).
pub(crate) fn is_closed(geometries: &[Geometry], lines: &Lines, rule: Rule) -> bool {
    let fraction_bits = fraction_bits(geometries, lines);
    geometries.iter().all(|geometry| {
        let mut edges: HashMap<[Vector; 2], i64> = HashMap::new();
        for facet in snapped(geometry, lines, fraction_bits) {
            for corner in 0..3 {
                let (from, to) = (facet[corner].clone(), facet[(corner + 1) % 3].clone());
                if from == to {
                    continue;
                }
                let step = if from < to || rule == Rule::Parity { 1 } else { -1 };
                *edges.entry(if from < to { [from, to] } else { [to, from] }).or_default() += step;
            }
        }
        edges.values().all(|&count| if rule == Rule::Parity { count % 2 == 0 } else { count == 0 })
    })
}

fn is_inside(tetrahedra: &[Tetrahedron], centre: &Vector, rule: Rule) -> bool {
    let holding = tetrahedra.iter().filter(|tetrahedron| tetrahedron.holds(centre));
    match rule {
        Rule::Parity => holding.count() % 2 == 1,
        Rule::Nonzero => holding.map(|tetrahedron| tetrahedron.winding).sum::<i32>() != 0,
    }
}

/// Sum of the winding numbers of a geometry at the centres of a box of cells, which may lie outside the mesh.
pub(crate) fn sum_of_windings(geometry: &Geometry, lines: &Lines, [xs, ys, zs]: [RangeInclusive<i32>; 3]) -> i64 {
    let (snapped, fraction_bits) = snapped_facets(geometry, lines);
    let tetrahedra: Vec<Tetrahedron> = snapped.iter().filter_map(Tetrahedron::new).collect();
    let mut sum = 0;
    for z in zs {
        for y in ys.clone() {
            for x in xs.clone() {
                let centre = [x, y, z].map(|i| BigInt::from(i) << fraction_bits);
                let holding = tetrahedra.iter().filter(|tetrahedron| tetrahedron.holds(&centre));
                sum += holding.map(|tetrahedron| i64::from(tetrahedron.winding)).sum::<i64>();
            }
        }
    }
    sum
}

/// A facet and the point O: four half-spaces and the sign of its volume.
struct Tetrahedron {
    faces: [Plane; 4],
    winding: i32,
}

impl Tetrahedron {
    /// Spans a facet with O, or None if the volume is zero.
    fn new(facet: &[Vector; 3]) -> Option<Tetrahedron> {
        let [a, b, c] = facet;
        // anywhere does; far from round numbers, few facets see it edge on
        let o = &[-7_777_777, 3_333_331, -1_234_567].map(BigInt::from);
        let base = Plane::through(a, b, c);
        let winding = match base.value(o).sign() {
            Sign::NoSign => return None,
            Sign::Minus => 1,
            Sign::Plus => -1,
        };
        let sides = [(Plane::through(o, a, b), c), (Plane::through(o, b, c), a), (Plane::through(o, c, a), b)];
        let [first, second, third] = sides.map(|(plane, inner)| plane.towards(inner));
        Some(Tetrahedron { faces: [base.towards(o), first, second, third], winding })
    }

    fn holds(&self, centre: &Vector) -> bool {
        self.faces.iter().all(|face| face.is_before(centre))
    }
}

/// The plane `n . (P - a) = 0`.
struct Plane {
    normal: Vector,
    offset: BigInt,
}

impl Plane {
    fn through(a: &Vector, b: &Vector, c: &Vector) -> Plane {
        let [u, v]: [Vector; 2] = [b, c].map(|end| std::array::from_fn(|i| &end[i] - &a[i]));
        let normal = std::array::from_fn(|i| {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            &u[j] * &v[k] - &u[k] * &v[j]
        });
        let offset = dot(&normal, a);
        Plane { normal, offset }
    }

    /// Turns the normal to the side of a point that is not on the plane.
    fn towards(self, inner: &Vector) -> Plane {
        if self.value(inner).sign() == Sign::Minus {
            return Plane { normal: self.normal.map(|x| -x), offset: -self.offset };
        }
        self
    }

    fn value(&self, point: &Vector) -> BigInt {
        dot(&self.normal, point) - &self.offset
    }

    /// Whether P - (e1, e2, e3) lies on the side of the normal.
    fn is_before(&self, point: &Vector) -> bool {
        match self.value(point).sign() {
            Sign::Plus => true,
            Sign::Minus => false,
            Sign::NoSign => {
                let decider = self.normal.iter().map(BigInt::sign).find(|&sign| sign != Sign::NoSign);
                decider == Some(Sign::Minus)
            }
        }
    }
}

fn dot(a: &Vector, b: &Vector) -> BigInt {
    &a[0] * &b[0] + &a[1] * &b[1] + &a[2] * &b[2]
}

/// Smallest cells from the centre of cell 0, in the f64 arithmetic of the definition.
fn cells_from_world(world: f64, lines: &Lines, axis: usize) -> f64 {
    let (first, unit) = (lines.line(axis, 0), lines.smallest()[axis]);
    let half = if lines.is_graded() { 0.5 * ((lines.line(axis, 1) - first) / unit) } else { 0.5 };
    (world - first) / unit - half
}

/// The centres of all cells of an axis, in cells.
fn middles(lines: &Lines, axis: usize) -> Vec<f64> {
    let n = lines.dims()[axis];
    let middle = |cell: u32| cells_from_world(0.5 * (lines.line(axis, cell) + lines.line(axis, cell + 1)), lines, axis);
    (0..n).map(|cell| if lines.is_graded() { middle(cell) } else { f64::from(cell) }).collect()
}

/// The same in units of the snap.
pub(crate) fn centres(lines: &Lines, axis: usize, fraction_bits: u64) -> Vec<BigInt> {
    middles(lines, axis).into_iter().map(|u| rounded(exact(u), F64_PLACES - fraction_bits)).collect()
}

/// The faces of all cells of an axis, one more than these, in units of the snap.
pub(crate) fn faces(lines: &Lines, axis: usize, fraction_bits: u64) -> Vec<BigInt> {
    let face = |line: u32| match lines.is_graded() {
        true => rounded(exact(cells_from_world(lines.line(axis, line), lines, axis)), F64_PLACES - fraction_bits),
        false => (BigInt::from(2 * line) - BigInt::from(1)) << (fraction_bits - 1),
    };
    (0..=lines.dims()[axis]).map(face).collect()
}

/// Cells from the centre of cell 0, in the f64 arithmetic of the definition.
fn cells_from_file(geometry: &Geometry, corner: [f32; 3], lines: &Lines) -> [f64; 3] {
    let world = geometry.world_from_file.place(corner.map(f64::from));
    std::array::from_fn(|axis| cells_from_world(world[axis], lines, axis))
}

/// Corners of a geometry that is alone in a box, in units of the snap, and the binary places of a cell.
pub(crate) fn snapped_facets(geometry: &Geometry, lines: &Lines) -> (Vec<[Vector; 3]>, u64) {
    let fraction_bits = fraction_bits(std::slice::from_ref(geometry), lines);
    (snapped(geometry, lines, fraction_bits), fraction_bits)
}

fn snapped(geometry: &Geometry, lines: &Lines, fraction_bits: u64) -> Vec<[Vector; 3]> {
    let snap = |corner: [f32; 3]| {
        cells_from_file(geometry, corner, lines).map(|u| rounded(exact(u), F64_PLACES - fraction_bits))
    };
    geometry.facets.slice().iter().map(|facet| facet.map(snap)).collect()
}

fn fraction_bits(geometries: &[Geometry], lines: &Lines) -> u64 {
    let one = BigInt::from(1) << F64_PLACES;
    let mut widest = BigInt::ZERO;
    for axis in 0..3 {
        let last = *middles(lines, axis).last().unwrap();
        let mut places = vec![BigInt::ZERO, exact(last)];
        for geometry in geometries {
            let corners = geometry.facets.slice().iter().flatten();
            places.extend(corners.map(|&corner| exact(cells_from_file(geometry, corner, lines)[axis])));
        }
        let (low, high) = (places.iter().min().unwrap(), places.iter().max().unwrap());
        widest = widest.max(high - low + &one + &one);
    }
    let limit = one << 26;
    (0..=26).rev().find(|&bits| &widest << bits <= limit).expect("the geometries span less than 2^26 cells")
}

/// A finite f64 times 2^1074.
fn exact(value: f64) -> BigInt {
    let bits = value.to_bits();
    let exponent = bits >> 52 & 0x7ff;
    let fraction = bits & ((1 << 52) - 1);
    let magnitude = match exponent {
        0 => BigInt::from(fraction),
        _ => BigInt::from(fraction | 1 << 52) << (exponent - 1),
    };
    if value < 0.0 { -magnitude } else { magnitude }
}

/// `value / 2^places` to the nearest integer, ties to even.
fn rounded(value: BigInt, places: u64) -> BigInt {
    // shifting right rounds down, so the rest is never negative
    let down: BigInt = &value >> places;
    let twice_rest: BigInt = (value - (&down << places)) << 1;
    let whole = BigInt::from(1) << places;
    let is_up = match twice_rest.cmp(&whole) {
        std::cmp::Ordering::Less => false,
        std::cmp::Ordering::Greater => true,
        std::cmp::Ordering::Equal => down.bit(0),
    };
    if is_up { down + 1 } else { down }
}

#[test]
fn f64_numbers_are_taken_exactly_and_rounded_to_even() {
    for (value, expected) in [(0.5, 0), (1.5, 2), (2.5, 2), (-0.5, 0), (-1.5, -2), (2.499, 2), (-2.501, -3), (7.0, 7)] {
        assert_eq!(rounded(exact(value), F64_PLACES), BigInt::from(expected), "{value}");
    }
    assert_eq!(exact(f64::from_bits(1)), BigInt::from(1));
    assert_eq!(exact(-f64::MIN_POSITIVE), -(BigInt::from(1) << 52u32));
}

#[test]
fn the_oracle_knows_a_cube_and_the_half_open_cells() {
    let lines = Lines::new([0.0; 3], [1.0; 3], [4, 3, 2]).unwrap();
    let facets = super::models::cuboid([0.5, 0.5, -1.0], [2.5, 1.5, 9.0]);
    let found = flags(&[Geometry::new("g", 5, facets).unwrap()], &lines, Rule::Parity);
    // centres 0.5 excluded, 1.5 and 2.5 included along x; 1.5 along y; all along z
    let plane = [0, 0, 0, 0, 0, 5, 5, 0, 0, 0, 0, 0];
    assert_eq!(found, [plane, plane].concat());
}

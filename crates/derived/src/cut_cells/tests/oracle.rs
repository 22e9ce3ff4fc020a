//! Cells cut by convex bodies, in exact fractions: each cell, face and edge is split into simplices by the planes of one body after the other. It shares no code with what it
//! checks.

use std::collections::HashMap;
use std::ops::{Add, Div, Mul, Sub};

use num_bigint::BigInt;

use super::models::*;
use super::{by_cell, place, rows};
use hexcast_core::grid::frame::Frame;
use hexcast_core::grid::lines::Lines;
use hexcast_core::grid::window::CellWindow;

/// A number as a fraction, in lowest terms, its denominator positive.
#[derive(Clone, Debug, PartialEq)]
struct Exact(BigInt, BigInt);

impl Exact {
    fn new(above: BigInt, below: BigInt) -> Exact {
        let (zero, mut a, mut b) = (BigInt::from(0), above.clone(), below.clone());
        while b != zero {
            (a, b) = (b.clone(), a % b);
        }
        let by = if (a < zero) == (below < zero) { a } else { -a };
        Exact(above / &by, below / by)
    }

    fn of(number: i64) -> Exact {
        Exact(number.into(), 1.into())
    }

    fn signum(&self) -> i32 {
        let zero = BigInt::from(0);
        i32::from(self.0 > zero) - i32::from(self.0 < zero)
    }

    /// Of numbers below 2^40.
    fn rounded(&self) -> f64 {
        let scaled: BigInt = (&self.0 << 80u32) / &self.1;
        i128::try_from(scaled).unwrap() as f64 / 2f64.powi(80)
    }
}

macro_rules! operator {
    ($name:ident, $call:ident, |$a:ident, $b:ident| $above:expr, $below:expr) => {
        impl $name for &Exact {
            type Output = Exact;
            fn $call(self, other: &Exact) -> Exact {
                let ($a, $b) = (self, other);
                Exact::new($above, $below)
            }
        }
    };
}
operator!(Add, add, |a, b| &a.0 * &b.1 + &b.0 * &a.1, &a.1 * &b.1);
operator!(Sub, sub, |a, b| &a.0 * &b.1 - &b.0 * &a.1, &a.1 * &b.1);
operator!(Mul, mul, |a, b| &a.0 * &b.0, &a.1 * &b.1);
operator!(Div, div, |a, b| &a.0 * &b.1, &a.1 * &b.0);

type Point = [Exact; 3];
type Simplex = Vec<Point>;

/// A plane: its normal, and the dot product of that with its points.
type Plane = (Point, Exact);

fn dot(a: &Point, b: &Point) -> Exact {
    let [x, y, z] = [0, 1, 2].map(|axis| &a[axis] * &b[axis]);
    &(&x + &y) + &z
}

fn minus(a: &Point, b: &Point) -> Point {
    [0, 1, 2].map(|axis| &a[axis] - &b[axis])
}

fn cross(a: &Point, b: &Point) -> Point {
    [0, 1, 2].map(|axis: usize| {
        let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
        &(&a[i] * &b[j]) - &(&a[j] * &b[i])
    })
}

/// Splits a simplex by a plane: what is behind it goes to one list, what is before it to the other.
fn split(simplex: Simplex, (normal, at): &Plane, behind: &mut Vec<Simplex>, before: &mut Vec<Simplex>) {
    let heights: Vec<Exact> = simplex.iter().map(|point| &dot(normal, point) - at).collect();
    let of_sign = |sign: i32| heights.iter().position(|height| height.signum() == sign);
    let (Some(low), Some(high)) = (of_sign(-1), of_sign(1)) else {
        if of_sign(1).is_some() { before } else { behind }.push(simplex);
        return;
    };
    let share = &heights[low] / &(&heights[low] - &heights[high]);
    let side = minus(&simplex[high], &simplex[low]);
    let met = [0, 1, 2].map(|axis| &simplex[low][axis] + &(&share * &side[axis]));
    for replaced in [low, high] {
        let mut half = simplex.clone();
        half[replaced] = met.clone();
        split(half, &(normal.clone(), at.clone()), behind, before);
    }
}

/// Volume of a tetrahedron, area of a triangle across an axis, length of a segment.
fn size(simplex: &Simplex) -> Exact {
    let sides: Vec<Point> = simplex[1..].iter().map(|point| minus(point, &simplex[0])).collect();
    let (sum, by) = match &sides[..] {
        [a] => (&(&a[0] + &a[1]) + &a[2], 1),
        [a, b] => {
            let [x, y, z] = cross(a, b);
            (&(&x + &y) + &z, 2)
        }
        [a, b, c] => (dot(&cross(a, b), c), 6),
        _ => unreachable!("two to four points"),
    };
    let positive = if sum.signum() < 0 { &Exact::of(0) - &sum } else { sum };
    &positive / &Exact::of(by)
}

/// The simplices of a box of any dimension: one for each order of its axes.
fn simplices(low: [i32; 3], high: [i32; 3]) -> Vec<Simplex> {
    let axes: Vec<usize> = (0..3).filter(|&axis| low[axis] < high[axis]).collect();
    let orders: Vec<Vec<usize>> = match axes[..] {
        [a] => vec![vec![a]],
        [a, b] => vec![vec![a, b], vec![b, a]],
        [a, b, c] => [[a, b, c], [a, c, b], [b, a, c], [b, c, a], [c, a, b], [c, b, a]].map(Vec::from).to_vec(),
        _ => unreachable!("one to three axes"),
    };
    let exact = |point: [i32; 3]| point.map(|of| Exact::of(of.into()));
    let of_order = |order: Vec<usize>| {
        let mut at = low;
        let rest = order.into_iter().map(|axis| {
            at[axis] = high[axis];
            exact(at)
        });
        [exact(low)].into_iter().chain(rest.collect::<Vec<_>>()).collect()
    };
    orders.into_iter().map(of_order).collect()
}

/// What each flag has of a box, as a part of it: the bodies are convex, and the later win.
fn shares(bodies: &[(u8, Vec<Plane>)], low: [i32; 3], high: [i32; 3]) -> HashMap<u8, f64> {
    let mut left = simplices(low, high);
    let total = |of: &[Simplex]| of.iter().map(size).fold(Exact::of(0), |sum, size| &sum + &size);
    let whole = total(&left);
    let mut found = HashMap::new();
    for (flag, planes) in bodies.iter().rev() {
        let mut outside = Vec::new();
        for plane in planes {
            let mut behind = Vec::new();
            left.into_iter().for_each(|simplex| split(simplex, plane, &mut behind, &mut outside));
            left = behind;
        }
        *found.entry(*flag).or_insert(0.0) += (&total(&left) / &whole).rounded();
        left = outside;
    }
    *found.entry(0).or_insert(0.0) += (&total(&left) / &whole).rounded();
    found
}

/// The planes of the bodies of a frame: snapped facets that face outwards.
fn bodies(frame: &Frame) -> Vec<(u8, Vec<Plane>)> {
    let of_position = |position: usize| {
        let plane = |facet: &[[i32; 3]; 3]| {
            let [a, b, c] = facet.map(|corner| corner.map(|of| Exact::of(of.into())));
            let normal = cross(&minus(&b, &a), &minus(&c, &a));
            let at = dot(&normal, &a);
            (normal, at)
        };
        let planes = frame.facets_at(position).iter().map(plane).collect();
        (frame.ranks.flag_of_rank[position], planes)
    };
    (0..frame.ranks.flag_of_rank.len()).map(of_position).collect()
}

/// Compares a model of convex bodies, none of them on lines, with the oracle.
fn compare(model: &Model, lines: &Lines, limit: f64) -> usize {
    let (frame, found) = (model.frame(lines), model.measured(lines));
    assert_eq!(found.n_sampled, 0, "{}", model.name);
    let bodies = bodies(&frame);
    let mut n = 0;
    let all = rows(&found);
    for of_cell in by_cell(&all) {
        let cell = place(of_cell[0].of.cell, lines);
        let low = [0, 1, 2].map(|axis| frame.face(axis, cell[axis]));
        let high = [0, 1, 2].map(|axis| frame.face(axis, cell[axis] + 1));
        let compare = |known: HashMap<u8, f64>, of: &dyn Fn(&super::Row) -> f64, what: &str| {
            for (flag, share) in known {
                let own = of_cell.iter().find(|row| row.of.flag == flag).map_or(0.0, of);
                let off = own - share;
                assert!(off.abs() < limit, "{}, cell {cell:?}, {what}, flag {flag}: {own}, off by {off}", model.name);
            }
        };
        compare(shares(&bodies, low, high), &|row| row.of.fraction, "volume");
        for face in 0..6 {
            let (mut from, mut to) = (low, high);
            if face % 2 == 0 {
                to[face / 2] = low[face / 2]
            } else {
                from[face / 2] = high[face / 2]
            }
            compare(shares(&bodies, from, to), &|row| row.faces[face], &format!("face {face}"));
        }
        for edge in 0..12 {
            let corner = super::ends_of(edge)[0];
            let from = [0, 1, 2].map(|axis| if corner >> axis & 1 == 1 { high[axis] } else { low[axis] });
            let mut to = from;
            to[edge / 4] = high[edge / 4];
            compare(shares(&bodies, from, to), &|row| row.edges[edge], &format!("edge {edge}"));
        }
        n += 1;
    }
    n
}

fn small() -> Lines {
    Lines::from_lists([vec![0.0, 1.0, 2.0, 3.0], vec![0.0, 0.75, 2.0, 3.0], vec![0.0, 1.0, 2.5, 3.0]]).unwrap()
}

#[test]
fn random_soups_of_tetrahedra_have_what_exact_fractions_say() {
    let (mut random, mut n) = (Random(3), 0);
    for soup in 0..3 {
        // few digits, so that fractions stay short; and once those that come
        let digits = if soup == 0 { 1e9 } else { 32.0 };
        let mut place = || ((0.1 + 2.8 * random.next()) * digits).floor() / digits + 1.0 / 128.0;
        let mut corner = || [0; 3].map(|_: i32| place() as f32);
        let surfaces = (0..soup.max(1)).map(|index| (1 + index as u8, tetrahedron([0; 4].map(|_: i32| corner()))));
        let model = Model { name: "soup", surfaces: surfaces.collect() };
        n += compare(&model, &small(), 1e-12);
    }
    assert!(n >= 20, "{n} cells");
}

#[test]
fn thin_and_touching_bodies_have_what_exact_fractions_say() {
    // few digits, so that fractions stay short
    let [a, b, c] = [[0.21875f32, 0.34375, 0.40625], [2.71875, 0.40625, 1.28125], [0.59375, 2.78125, 1.90625]];
    let near = |by: f32| [a[0] + 0.9375, a[1] + 0.8125, a[2] + 0.71875 + by];
    let thin = Model::of_one("thin", tetrahedron([a, b, c, near(1.0 / 1024.0)]));
    let both = vec![(1, tetrahedron([a, b, c, near(1.25)])), (2, tetrahedron([a, b, c, near(-0.875)]))];
    let back_to_back = Model { name: "back to back", surfaces: both };
    let slabs = vec![
        (1, cuboid([0.25, 0.375, 0.25], [1.625, 2.625, 1.25])),
        (2, cuboid([0.25, 0.375, 1.25], [1.625, 2.625, 2.75])),
    ];
    let slabs = Model { name: "slabs", surfaces: slabs };
    let within = vec![
        (1, cuboid([0.25, 0.375, 0.25], [1.625, 2.625, 2.25])),
        (2, cuboid([0.25, 0.625, 0.5], [1.625, 2.625, 1.75])),
    ];
    let within = Model { name: "within", surfaces: within };
    for model in [thin, back_to_back, slabs, within] {
        assert!(compare(&model, &small(), 1e-12) > 4, "{}", model.name);
    }
}

#[test]
fn volumes_alone_have_what_exact_fractions_say() {
    // few digits, so that fractions stay short; the second has a side that is nearly flat, the third one that is nearly so along one axis
    let lines = Lines::new([0.0; 3], [0.5; 3], [6; 3]).unwrap();
    let (a, d) = ([0.21875f32, 0.34375, 0.40625], [1.15625, 1.15625, 2.875]);
    for [b, c] in [
        [[2.71875f32, 0.40625, 1.28125], [0.59375, 2.78125, 0.90625]],
        [[2.71875, 0.40625, 0.40625 + 1.0 / 65536.0], [0.59375, 2.78125, 0.40625 + 1.0 / 131072.0]],
        [[2.71875, 0.40625, 1.28125], [0.59375, 2.78125, 0.53125 + 1.0 / 65536.0]],
    ] {
        let model = Model::of_one("tetrahedron", tetrahedron([a, b, c, d]));
        let frame = model.frame(&lines);
        let found = measured_alone(&frame, &lines, CellWindow::all(lines.dims()));
        let bodies = bodies(&frame);
        let own: HashMap<(u64, u8), f64> = found.flags().map(|of| ((of.cell, of.flag), of.fraction)).collect();
        let mut cells: Vec<u64> = own.keys().map(|(cell, _)| *cell).collect();
        cells.sort_unstable();
        cells.dedup();
        assert!(cells.len() > 50, "{} cells", cells.len());
        for cell in cells {
            let at = place(cell, &lines);
            let [low, high] = [0, 1].map(|end| [0, 1, 2].map(|axis| frame.face(axis, at[axis] + end)));
            for (flag, share) in shares(&bodies, low, high) {
                let off = own.get(&(cell, flag)).copied().unwrap_or(0.0) - share;
                assert!(off.abs() < 1e-14, "cell {at:?}, flag {flag}: {share}, off by {off}");
            }
        }
    }
}

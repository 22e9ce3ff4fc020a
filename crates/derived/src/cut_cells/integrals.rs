//! Integrals over what lies below polygons and segments, in cells: sums of fixed point, which are the same in any order.
//!
//! # Theory
//! A function on a cell that is a whole number on each side of its polygons, as the winding number of a surface is, is a sum of columns: each has one sign, a convex
//! polygon as its upper end, and reaches down to the floor of the cell. They stand below the polygons of the surface and below the cell's ceiling. On a face it is a sum of what lies below segments, on an edge of what
//! lies before places. The product of two such sums is one, too: that of two columns is below the lower of both polygons, where
//! their projections meet. So several geometries in a cell need no other arithmetic than one, and no decision: where two surfaces coincide
//! the numbers cancel.
//!
//! Each term is rounded to 2^-56 of a cell, face or edge; sums of 64 bits wrap, and are right where the result is below 128.
//! Source: Gauss's and Green's theorems; the products are ours.

use crate::fractions::EXACT_PARTS;

/// Bits of a part of a cell, of a face, of an edge.
pub(super) const BITS: u32 = EXACT_PARTS.ilog2();
/// A whole cell, face or edge.
pub(super) const WHOLE: i64 = 1 << BITS;

/// A number as a sum holds it.
#[inline(always)]
pub(super) fn fixed(number: f64) -> i64 {
    (number * WHOLE as f64) as i64
}

/// What a sum holds.
#[inline(always)]
pub(super) fn number(fixed: i64) -> f64 {
    fixed as f64 / WHOLE as f64
}

pub(super) type Point = [f64; 3];

/// A part of a face below a segment: places along the first axis of the face and the second, the first ascending, and how often it counts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Strip {
    pub(super) from: [f64; 2],
    pub(super) to: [f64; 2],
    pub(super) times: i32,
}

/// A part of a cell below a polygon, which is seen from above in the order of its corners: counter-clockwise.
#[derive(Clone, Debug)]
pub(super) struct Column {
    pub(super) corners: Vec<Point>,
    pub(super) times: i32,
}

/// Integrals of a sum of strips: of 1 and of both coordinates.
pub(super) type OfFace = [i64; 3];
/// Integrals of a sum of columns: of 1 and of x, y, z.
pub(super) type OfCell = [i64; 4];

/// Adds so many times.
#[inline(always)]
pub(super) fn add<const N: usize>(sum: &mut [i64; N], more: [f64; N], times: i32) {
    for (sum, more) in sum.iter_mut().zip(more) {
        *sum = sum.wrapping_add(fixed(more).wrapping_mul(times.into()));
    }
}

/// The integrals below a segment, of places in the order of the first coordinate.
#[inline(always)]
pub(super) fn below_segment([t, l]: [f64; 2], [u, m]: [f64; 2]) -> [f64; 3] {
    let width = u - t;
    let area = width * (0.5 * (l + m));
    let first = width * (t * (2.0 * l + m) + u * (l + 2.0 * m)) / 6.0;
    [area, first, width * (l * l + l * m + m * m) / 6.0]
}

/// The integrals below a polygon, negative where its corners are clockwise seen from above; and twice its area vector.
#[inline(always)]
pub(super) fn below_polygon(corners: &[Point]) -> ([f64; 4], Point) {
    let (mut sums, mut vector) = ([0.0; 4], [0.0; 3]);
    let a = corners[0];
    for two in corners[1..].windows(2) {
        let (b, c) = (two[0], two[1]);
        let (u, v) = ([0, 1, 2].map(|i| b[i] - a[i]), [0, 1, 2].map(|i| c[i] - a[i]));
        let cross = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
        let total = [0, 1, 2].map(|i| a[i] + b[i] + c[i]);
        let with_z = [0, 1, 2].map(|i| total[i] * total[2] + a[i] * a[2] + b[i] * b[2] + c[i] * c[2]);
        sums[0] += cross[2] * total[2];
        sums[1] += cross[2] * with_z[0];
        sums[2] += cross[2] * with_z[1];
        sums[3] += cross[2] * with_z[2];
        for i in 0..3 {
            vector[i] += cross[i];
        }
    }
    ([sums[0] / 6.0, sums[1] / 24.0, sums[2] / 24.0, sums[3] / 48.0], vector)
}

/// Integrals of a sum of strips.
pub(super) fn of_strips(strips: &[Strip]) -> OfFace {
    let mut sum = [0; 3];
    strips.iter().for_each(|strip| add(&mut sum, below_segment(strip.from, strip.to), strip.times));
    sum
}

/// Integrals of a sum of columns.
pub(super) fn of_columns(columns: &[Column]) -> OfCell {
    let mut sum = [0; 4];
    columns.iter().for_each(|column| add(&mut sum, below_polygon(&column.corners).0, column.times));
    sum
}

/// All of a face.
pub(super) fn whole_face(times: i32) -> Strip {
    Strip { from: [0.0, 1.0], to: [1.0, 1.0], times }
}

/// All of a cell.
pub(super) fn whole_cell(times: i32) -> Column {
    Column { corners: vec![[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [1.0, 1.0, 1.0], [0.0, 1.0, 1.0]], times }
}

impl Strip {
    /// Below a segment, in any order of its ends.
    #[inline(always)]
    pub(super) fn new(one: [f64; 2], other: [f64; 2], times: i32) -> Strip {
        if one[0] <= other[0] { Strip { from: one, to: other, times } } else { Strip { from: other, to: one, times } }
    }

    #[inline(always)]
    pub(super) fn height(&self, at: f64) -> f64 {
        if at == self.from[0] {
            return self.from[1];
        }
        if at == self.to[0] {
            return self.to[1];
        }
        self.from[1] + (self.to[1] - self.from[1]) * ((at - self.from[0]) / (self.to[0] - self.from[0]))
    }

    /// What lies below both.
    fn times(&self, other: &Strip, product: &mut Vec<Strip>) {
        let (start, end) = (self.from[0].max(other.from[0]), self.to[0].min(other.to[0]));
        if start >= end {
            return;
        }
        let times = self.times * other.times;
        let [own, of_other] = [self, other].map(|of| [of.height(start), of.height(end)]);
        let by = [0, 1].map(|at| own[at] - of_other[at]);
        let (from, to) = ([start, own[0].min(of_other[0])], [end, own[1].min(of_other[1])]);
        if by[0] * by[1] < 0.0 {
            let share = by[0] / (by[0] - by[1]);
            let at = (start + (end - start) * share).clamp(start, end);
            let middle = [at, own[0] + (own[1] - own[0]) * share];
            product.extend([Strip { from, to: middle, times }, Strip { from: middle, to, times }]);
        } else {
            product.push(Strip { from, to, times });
        }
    }
}

/// The product of two sums of strips.
pub(super) fn product_of_strips(one: &[Strip], other: &[Strip]) -> Vec<Strip> {
    let mut product = Vec::new();
    one.iter().for_each(|strip| other.iter().for_each(|by| strip.times(by, &mut product)));
    product
}

/// The product of two sums of columns.
pub(super) fn product_of_columns(one: &[Column], other: &[Column]) -> Vec<Column> {
    let mut product = Vec::new();
    one.iter().for_each(|column| other.iter().for_each(|by| column.times(by, &mut product)));
    product
}

/// Columns with less than this of a cell are left out of products.
const NOTHING: f64 = 1e-18;
/// Values below this, as a part of the greatest, are 0.
const ROUNDING: f64 = 1e-14;

impl Column {
    /// Below a polygon, whose corners may be in either order.
    pub(super) fn new(corners: &[Point], times: i32) -> Option<Column> {
        let area = below_polygon(corners).1[2];
        let mut corners = corners.to_vec();
        if area < 0.0 {
            corners.reverse();
        }
        (area != 0.0).then_some(Column { corners, times })
    }

    /// What lies below both.
    fn times(&self, other: &Column, product: &mut Vec<Column>) {
        let mut within = self.corners.clone();
        for (at, from) in other.corners.iter().enumerate() {
            let to = other.corners[if at + 1 == other.corners.len() { 0 } else { at + 1 }];
            let left = |p: &Point| (to[0] - from[0]) * (p[1] - from[1]) - (to[1] - from[1]) * (p[0] - from[0]);
            within = match divided(&within, left) {
                [Some(left), _] => left,
                _ => return,
            };
        }
        let vector = below_polygon(&other.corners).1;
        if vector[2] < NOTHING {
            return;
        }
        let ends =
            other.corners.iter().fold([1.0f64, 0.0], |[low, high], corner| [low.min(corner[2]), high.max(corner[2])]);
        let base = other.corners[0];
        let of_other = |p: &Point| {
            let rise = (vector[0] * (p[0] - base[0]) + vector[1] * (p[1] - base[1])) / vector[2];
            (base[2] - rise).clamp(ends[0], ends[1])
        };
        let times = self.times * other.times;
        let [lower, mut upper] = divided(&within, |p| of_other(p) - p[2]);
        upper.iter_mut().flatten().for_each(|corner| corner[2] = corner[2].min(of_other(corner)));
        product.extend([lower, upper].into_iter().flatten().map(|corners| Column { corners, times }));
    }
}

/// What of a convex polygon lies where a linear function is not negative, and the rest: together all of it, and nothing twice. None where that has no area. A function that
/// changes its sign more often than twice around the polygon is 0 but for rounding, and so is a value that is small beside the others.
fn divided(corners: &[Point], of: impl Fn(&Point) -> f64) -> [Option<Vec<Point>>; 2] {
    let mut values: Vec<f64> = corners.iter().map(of).collect();
    let least = ROUNDING * values.iter().fold(0.0f64, |most, value| most.max(value.abs()));
    values.iter_mut().filter(|value| value.abs() <= least).for_each(|value| *value = 0.0);
    let next = |at: usize| if at + 1 == values.len() { 0 } else { at + 1 };
    let changes = |at: &usize| (values[*at] < 0.0) != (values[next(*at)] < 0.0);
    let n_changes = (0..values.len()).filter(changes).count();
    if n_changes != 2 {
        let is_negative = if n_changes == 0 { values[0] < 0.0 } else { values.iter().sum::<f64>() < 0.0 };
        return if is_negative { [None, Some(corners.to_vec())] } else { [Some(corners.to_vec()), None] };
    }
    let mut both = [Vec::with_capacity(corners.len() + 2), Vec::with_capacity(corners.len() + 2)];
    for (at, from) in corners.iter().enumerate() {
        both[usize::from(values[at] < 0.0)].push(*from);
        if changes(&at) {
            let (to, share) = (&corners[next(at)], values[at] / (values[at] - values[next(at)]));
            let met = [0, 1, 2].map(|axis| from[axis] + share * (to[axis] - from[axis]));
            both.iter_mut().for_each(|side| side.push(met));
        }
    }
    both.map(|side| (side.len() >= 3).then_some(side))
}

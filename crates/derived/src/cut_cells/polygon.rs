//! Facets split by the planes of lines: which side a corner is on is decided on integers, and where it is becomes a whole number of units and a part of one.
//!
//! # Theory
//! A grid point P stands for P - (e1, e2, e3), e1 >> e2 >> e3 > 0 infinitesimal: the rule for ties of all rays. So no corner lies in a plane: one at its place is above it. A corner of
//! a polygon is one of three things: a corner of the facet; a point where an edge of the facet meets a plane; a point where the facet meets the line of two planes. A
//! coordinate of the second is u + n / d with d of 28 bits and n of 55, of the third with d of 53 bits and n of 81. Of n / d the whole part and the remainder are exact:
//! the whole part is guessed in f64, and products of 64 bits that wrap hold what is left. So n / d rounds to the same f64 for all facets at an
//! edge and all cells at a plane. Where the remainder is 0, the signs of the derivatives by e1, e2, e3 say which side a corner is on; one below
//! has a whole part less by 1, and a part of 1.

use hexcast_core::grid::frame::SnappedFacet;

/// Sides of a polygon that lie on edges of the facet: 0, 1, 2. Those in planes follow: below and above along x, then y, then z.
pub(super) const FIRST_FACE: u8 = 3;

/// Corners that a triangle has between six planes, at most.
pub(super) const MOST: usize = 9;

/// A facet, its least corner first, and twice its area vector.
pub(super) struct Whole {
    pub(super) corners: [[i64; 3]; 3],
    /// Where that is in the facet.
    pub(super) first: usize,
    pub(super) normal: [i64; 3],
    /// 1 by the size of each component of that.
    per_normal: [f64; 3],
}

impl Whole {
    /// None of a facet without area.
    pub(super) fn new(facet: &SnappedFacet) -> Option<Whole> {
        let least = (0..3).min_by_key(|&corner| facet[corner]).unwrap_or(0);
        let corners = [0, 1, 2].map(|corner| facet[(least + corner) % 3].map(i64::from));
        let [a, b, c] = corners;
        let (u, v) = ([0, 1, 2].map(|axis| b[axis] - a[axis]), [0, 1, 2].map(|axis| c[axis] - a[axis]));
        let normal = [0, 1, 2].map(|axis: usize| {
            let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
            u[i] * v[j] - u[j] * v[i]
        });
        let per_normal = normal.map(|component| 1.0 / component.abs() as f64);
        (normal != [0; 3]).then_some(Whole { corners, first: least, normal, per_normal })
    }

    /// Signs of its normal.
    pub(super) fn signs(&self) -> [i8; 3] {
        self.normal.map(|component| component.signum() as i8)
    }

    /// The polygon that is all of it.
    pub(super) fn polygon(&self) -> Polygon {
        let mut polygon = Polygon { n: 3, ..Polygon::EMPTY };
        for corner in 0..3 {
            polygon.whole[corner] = self.corners[corner].map(|place| place as i32);
            polygon.side[corner] = corner as u8;
        }
        polygon
    }

    /// Coordinate of the point where an edge meets the plane at a place along an axis.
    #[inline(always)]
    fn on_edge(&self, edge: usize, (axis, place): (usize, i64), of: usize) -> (i32, f64) {
        let (from, to) = (&self.corners[edge], &self.corners[(edge + 1) % 3]);
        let (rise, run) = (to[of] - from[of], to[axis] - from[axis]);
        let sign = run.signum();
        let (by, number) = (run * sign, rise * (place - from[axis]) * sign);
        let (whole, rest) = divided(number, by, number as f64 / by as f64);
        // it moves by rise / run where the plane does
        let is_below = axis < of && rise * sign > 0;
        at(from[of] + whole, rest, by, is_below)
    }

    /// Coordinate of the point where the facet meets the line of two planes.
    #[inline(always)]
    pub(super) fn on_line(&self, planes: [(usize, i64); 2], of: usize) -> (i32, f64) {
        let sign = self.normal[of].signum();
        let by = self.normal[of] * sign;
        let slopes = planes.map(|(axis, _)| -self.normal[axis] * sign);
        let runs = planes.map(|(axis, place)| place - self.corners[0][axis]);
        let about = slopes[0] as f64 * runs[0] as f64 + slopes[1] as f64 * runs[1] as f64;
        // off by 2^30 / by at most: what is left has fewer than 60 bits, so that those beyond may wrap
        let guess = floor(about * self.per_normal[of]);
        let sum = slopes[0].wrapping_mul(runs[0]).wrapping_add(slopes[1].wrapping_mul(runs[1]));
        let left = sum.wrapping_sub(guess.wrapping_mul(by));
        let (whole, rest) = divided(left, by, left as f64 * self.per_normal[of]);
        let first = (0..3).find(|&axis| axis == of || self.normal[axis] != 0).unwrap_or(of);
        let is_below = first != of && self.normal[first] * sign < 0;
        at(self.corners[0][of] + guess + whole, rest, by, is_below)
    }
}

/// The greatest whole number that is not above; of numbers below 2^62.
#[inline(always)]
fn floor(number: f64) -> i64 {
    let whole = number as i64;
    whole - i64::from(whole as f64 > number)
}

/// Quotient and remainder of a number of fewer than 60 bits by a positive one of at most 53, given about what the quotient is.
#[inline(always)]
fn divided(number: i64, by: i64, about: f64) -> (i64, i64) {
    let mut whole = floor(about);
    let mut rest = number - whole * by;
    while rest < 0 {
        (whole, rest) = (whole - 1, rest + by);
    }
    while rest >= by {
        (whole, rest) = (whole + 1, rest - by);
    }
    (whole, rest)
}

#[inline(always)]
fn at(whole: i64, rest: i64, by: i64, is_below: bool) -> (i32, f64) {
    if rest == 0 && is_below { (whole as i32 - 1, 1.0) } else { (whole as i32, rest as f64 / by as f64) }
}

/// What of a facet lies between planes: convex, in the order of the facet's corners.
#[derive(Clone)]
pub(super) struct Polygon {
    pub(super) n: usize,
    /// Whole units and parts of one, 0 to 1, of each corner.
    pub(super) whole: [[i32; 3]; MOST],
    pub(super) part: [[f64; 3]; MOST],
    /// What the side from each corner to the next lies on.
    pub(super) side: [u8; MOST],
}

impl Polygon {
    pub(super) const EMPTY: Polygon = Polygon { n: 0, whole: [[0; 3]; MOST], part: [[0.0; 3]; MOST], side: [0; MOST] };

    #[inline(always)]
    fn push(&mut self, (whole, part): ([i32; 3], [f64; 3]), side: u8) {
        (self.whole[self.n], self.part[self.n], self.side[self.n]) = (whole, part, side);
        self.n += 1;
    }

    /// Least and greatest whole place along an axis.
    pub(super) fn reach(&self, axis: usize) -> [i32; 2] {
        let first = self.whole[0][axis];
        self.whole[1..self.n].iter().fold([first; 2], |[low, high], at| [low.min(at[axis]), high.max(at[axis])])
    }

    /// Splits it by the plane at a place along an axis, which some corners are below and some above.
    pub(super) fn split(&self, of: &Whole, (axis, place): (usize, i32), below: &mut Polygon, above: &mut Polygon) {
        (below.n, above.n) = (0, 0);
        let faces = [0, 1].map(|end| FIRST_FACE + 2 * axis as u8 + end);
        for at in 0..self.n {
            let next = if at + 1 == self.n { 0 } else { at + 1 };
            let is_above = self.whole[at][axis] >= place;
            let corner = (self.whole[at], self.part[at]);
            if is_above { &mut *above } else { &mut *below }.push(corner, self.side[at]);
            if is_above != (self.whole[next][axis] >= place) {
                let corner = self.met(of, at, (axis, place));
                below.push(corner, if is_above { self.side[at] } else { faces[1] });
                above.push(corner, if is_above { faces[0] } else { self.side[at] });
            }
        }
    }

    /// Where a side meets a plane.
    #[inline(always)]
    fn met(&self, of: &Whole, at: usize, (axis, place): (usize, i32)) -> ([i32; 3], [f64; 3]) {
        let (side, mut whole, mut part) = (self.side[at], [place; 3], [0.0; 3]);
        let plane = (axis, i64::from(place));
        if side < FIRST_FACE {
            for other in [(axis + 1) % 3, (axis + 2) % 3] {
                (whole[other], part[other]) = of.on_edge(side.into(), plane, other);
            }
        } else {
            let other = usize::from((side - FIRST_FACE) / 2);
            whole[other] = self.whole[at][other];
            let last = 3 - axis - other;
            (whole[last], part[last]) = of.on_line([plane, (other, whole[other].into())], last);
        }
        (whole, part)
    }
}

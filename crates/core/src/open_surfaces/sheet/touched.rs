//! Touched cells: those whose closed box has a point in common with a facet.
//!
//! # Theory
//! The box of a cell and a facet touch unless a direction n separates them: unless all n . point of the one lie below all of the other. The
//! directions to look at are 13: the three axes, the normal of the facet, and the products of each axis and each edge (the separating axis
//! theorem; Schwarz and Seidel 2010 use the same planes). Along each direction the facet reaches from its least to its greatest n . corner, a
//! [`Slab`], and the box from its least to its greatest n . point, which its faces give. Along a ray both ends of the box grow from cell to
//! cell. So the touched cells of a ray are one interval, the intersection of those of all slabs. Its ends are places between which the faces
//! of the cells must lie, whether all cells are equal or not.
//!
//! Numbers, in bits with the sign: corners span less than 2^26 units, so an edge has 27, n of a product 27, n of the normal 53, and
//! n . corner 80, as has its difference from n . face (a test below computes them). Every quotient is of whole numbers, rounded inwards: nothing is approximate.
//!
//! Degenerate cases: of a facet that is a segment or a point some n are 0; what is left of the slabs is the sum all the same.
//! Cost: up to ten quotients for each ray that passes the box of a facet, widened by half a cell.

use std::ops::RangeInclusive;

use crate::grid::frame::{Frame, SnappedFacet, normal};
use crate::grid::rays::Rays;

/// Points between two planes: `low <= n . point <= high`, across the rays twice, then along them; n along them is not negative.
struct Slab {
    n: [i128; 3],
    low: i128,
    high: i128,
}

/// The cells that a facet touches.
pub(super) struct Touched<'a> {
    frame: &'a Frame,
    rays: &'a Rays,
    /// Cells on both axes across the rays, and along them, that the facet's box touches, within the domain.
    pub(super) cells: [RangeInclusive<i64>; 3],
    slabs: Vec<Slab>,
}

impl<'a> Touched<'a> {
    /// None where it touches no cell of the domain.
    pub(super) fn new(facet: &SnappedFacet, frame: &'a Frame, rays: &'a Rays) -> Option<Touched<'a>> {
        let corners = facet.map(|corner| rays.project(corner).map(i128::from));
        let cells = [rays.across[0], rays.across[1], rays.axis].map(|axis| {
            let [a, b, c] = facet.map(|corner| i64::from(corner[axis]));
            let [first, last] = frame.touched(axis, [a.min(b).min(c), a.max(b).max(c)]);
            first.max(0)..=last.min(i64::from(frame.dims[axis]) - 1)
        });
        if cells.iter().any(RangeInclusive::is_empty) {
            return None;
        }
        let edge = |corner: usize| {
            let [from, to] = [corners[corner], corners[(corner + 1) % 3]];
            [0, 1, 2].map(|axis| to[axis] - from[axis])
        };
        let [first, second, third] = [0, 1, 2].map(edge);
        let normal = normal(facet);
        let normal = [normal[rays.across[0]], normal[rays.across[1]], normal[rays.axis]];
        let products = [first, second, third].map(|[x, y, z]| [[0, -z, y], [z, 0, -x], [-y, x, 0]]);
        let directions = products.iter().flatten().chain([&normal]).filter(|n| **n != [0; 3]);
        Some(Touched { frame, rays, slabs: directions.map(|n| Slab::new(*n, &corners)).collect(), cells })
    }

    /// The cells of a ray, first and last; none where the first is above the last.
    pub(super) fn of_ray(&self, i: i64, j: i64) -> [i64; 2] {
        // the lower and the upper face of the cells of the ray, on both axes across
        let [of_i, of_j] = [(0, i), (1, j)].map(|(side, cell)| {
            [cell, cell + 1].map(|face| i128::from(self.frame.face(self.rays.across[side], face as u32)))
        });
        let (mut first, mut last) = (clamped(i128::MIN), clamped(i128::MAX));
        for Slab { n, low, high } in &self.slabs {
            let ends = |n: i128, [lower, upper]: [i128; 2]| {
                if n < 0 { [n * upper, n * lower] } else { [n * lower, n * upper] }
            };
            let ([least_i, most_i], [least_j, most_j]) = (ends(n[0], of_i), ends(n[1], of_j));
            // upper faces of touched cells lie at `above` / n or above, lower ones at `below` / n or below
            let [above, below] = [low - most_i - most_j, high - least_i - least_j];
            if n[2] == 0 {
                if above > 0 || below < 0 {
                    return [0, -1];
                }
            } else {
                // a quotient may be far outside of the domain, and of i64
                first = first.max(clamped(-divided(-above, n[2])));
                last = last.min(clamped(divided(below, n[2])));
            }
        }
        let [from, to] = self.frame.touched(self.rays.axis, [first, last]);
        [from.max(*self.cells[2].start()), to.min(*self.cells[2].end())]
    }
}

impl Slab {
    fn new(n: [i128; 3], corners: &[[i128; 3]; 3]) -> Slab {
        let n = if n[2] < 0 { n.map(|part| -part) } else { n };
        let along = corners.map(|corner| n[0] * corner[0] + n[1] * corner[1] + n[2] * corner[2]);
        Slab { n, low: along[0].min(along[1]).min(along[2]), high: along[0].max(along[1]).max(along[2]) }
    }
}

/// Quotient rounded down, by a positive number.
fn divided(value: i128, by: i128) -> i128 {
    match (i64::try_from(value), i64::try_from(by)) {
        (Ok(value), Ok(by)) => i128::from(value.div_euclid(by)),
        _ => value.div_euclid(by),
    }
}

fn clamped(place: i128) -> i64 {
    place.clamp(-1 << 32, 1 << 32) as i64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::frame::{MIN_FRACTION_BITS, SPAN_BITS};

    /// n . corner is affine in each of the nine coordinates, as is its difference from n . face in those of the faces: the extremes are where
    /// every coordinate is at an end of its range. What does not fit on the way ends the test: it is compiled with checks for overflow.
    #[test]
    fn numbers_have_the_widths_that_the_head_says() {
        let span = (1 << SPAN_BITS) - (2 << MIN_FRACTION_BITS) + 1;
        let width = |number: i128| 129 - if number < 0 { !number } else { number }.leading_zeros();
        let (mut of_n, mut of_ends, mut of_quotients) = (0, 0, 0);
        for ends in [[0, span], [-span, 0]] {
            for choice in 0..1 << 9 {
                let at = |of: usize| ends[choice >> of & 1];
                let facet = [0, 1, 2].map(|corner| [0, 1, 2].map(|axis| at(3 * corner + axis)));
                let [u, v] =
                    [1, 2].map(|corner| [0, 1, 2].map(|axis: usize| i128::from(facet[corner][axis] - facet[0][axis])));
                let products = [[0, -u[2], u[1]], [v[2], 0, -v[0]], [-u[1], u[0], 0]];
                for n in [normal(&facet)].into_iter().chain(products) {
                    let Slab { n, low, high } = Slab::new(n, &facet.map(|corner| corner.map(i128::from)));
                    of_n = n.iter().map(|part| width(*part)).fold(of_n, u32::max);
                    of_ends = [low, high].map(width).into_iter().fold(of_ends, u32::max);
                    for faces in 0..4 {
                        let of_faces = |side: usize| n[side] * i128::from(ends[faces >> side & 1]);
                        let quotients = [low, high].map(|end| width(end - of_faces(0) - of_faces(1)));
                        of_quotients = quotients.into_iter().fold(of_quotients, u32::max);
                    }
                }
            }
        }
        assert_eq!([of_n, of_ends, of_quotients], [53, 80, 80]);
    }
}

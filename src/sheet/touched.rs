//! Touched cells: those whose closed box has a point in common with a facet.
//!
//! # Theory
//! The box of a cell touches a facet iff the centre of the cell lies in the Minkowski sum of the facet and the box around 0. This
//! sum is convex, and its faces lie across 13 directions: the three axes, the normal of the facet, and the products of each axis
//! and each edge (the separating axis theorem; Schwarz and Seidel 2010 use the same planes). Along each direction n the centre
//! must lie between the least and the greatest n . corner, widened by half a cell: a [`Slab`]. So the touched cells of a ray are
//! one interval, the intersection of those of all slabs.
//!
//! Numbers, in bits with the sign: corners span less than 2^26 units, so an edge has 27, n of a product 27, n of the normal 53, and
//! n . corner, widened, 80 (a test below computes them). Every quotient is of whole numbers, rounded inwards: nothing is approximate.
//!
//! Degenerate cases: of a facet that is a segment or a point some n are 0; what is left of the slabs is the sum all the same.
//! Cost: up to ten quotients for each ray that passes the box of a facet, widened by half a cell.

use std::ops::RangeInclusive;

use crate::frame::{SnappedFacet, normal};
use crate::rays::Rays;

/// Cells between two planes: `low <= n . cell <= high`, across the rays twice, then along them; n along them is not negative.
struct Slab {
    n: [i128; 3],
    low: i128,
    high: i128,
}

/// The cells that a facet touches.
pub(super) struct Touched {
    /// Cells on both axes across the rays, and along them: of the facet's box, widened by half a cell, within the domain.
    pub(super) cells: [RangeInclusive<i64>; 3],
    slabs: Vec<Slab>,
}

impl Touched {
    /// None where it touches no cell of the domain.
    pub(super) fn new(facet: &SnappedFacet, fraction_bits: u32, rays: &Rays) -> Option<Touched> {
        let corners = facet.map(|corner| rays.project(corner).map(i128::from));
        let n_cells = [rays.counts[0], rays.counts[1], rays.depth];
        let slab = |n: [i128; 3]| Slab::new(n, &corners, fraction_bits);
        let cells: [RangeInclusive<i64>; 3] = std::array::from_fn(|axis| {
            let mut n = [0; 3];
            n[axis] = 1;
            let Slab { low, high, .. } = slab(n);
            low.max(0) as i64..=high.min(i128::from(n_cells[axis]) - 1) as i64
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
        Some(Touched { slabs: directions.map(|n| slab(*n)).collect(), cells })
    }

    /// The cells of a ray, first and last; none where the first is above the last.
    pub(super) fn of_ray(&self, i: i64, j: i64) -> [i64; 2] {
        let [mut first, mut last] = [*self.cells[2].start(), *self.cells[2].end()];
        for Slab { n, low, high } in &self.slabs {
            let across = n[0] * i128::from(i) + n[1] * i128::from(j);
            if n[2] == 0 {
                if across < *low || across > *high {
                    return [0, -1];
                }
            } else {
                // a quotient may be far outside of the domain, and of i64
                first = first.max(clamped(-divided(across - low, n[2])));
                last = last.min(clamped(divided(high - across, n[2])));
            }
        }
        [first, last]
    }
}

impl Slab {
    fn new(n: [i128; 3], corners: &[[i128; 3]; 3], fraction_bits: u32) -> Slab {
        let n = if n[2] < 0 { n.map(|part| -part) } else { n };
        let along = corners.map(|corner| n[0] * corner[0] + n[1] * corner[1] + n[2] * corner[2]);
        let half = (n[0].abs() + n[1].abs() + n[2].abs()) << fraction_bits >> 1;
        let [low, high] = [along[0].min(along[1]).min(along[2]) - half, along[0].max(along[1]).max(along[2]) + half];
        // a centre is a multiple of 2^F: rounded inwards
        Slab { n, low: -(-low >> fraction_bits), high: high >> fraction_bits }
    }
}

/// Quotient rounded down, by a positive number.
fn divided(value: i128, by: i128) -> i128 {
    match (i64::try_from(value), i64::try_from(by)) {
        (Ok(value), Ok(by)) => i128::from(value.div_euclid(by)),
        _ => value.div_euclid(by),
    }
}

fn clamped(cell: i128) -> i64 {
    cell.clamp(-1 << 32, 1 << 32) as i64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::{MIN_FRACTION_BITS, SPAN_BITS};

    /// n . corner is affine in each of the nine coordinates, and half a cell more is convex: the extremes are where every coordinate is at
    /// an end of its range. What does not fit on the way ends the test: it is compiled with checks for overflow.
    #[test]
    fn numbers_have_the_widths_that_the_head_says() {
        let span = (1 << SPAN_BITS) - (2 << MIN_FRACTION_BITS) + 1;
        let rays = Rays::new(2, [1 << 19; 3]);
        let width = |number: i128| 129 - number.unsigned_abs().leading_zeros();
        let (mut of_n, mut of_ends) = (0, 0);
        for ends in [[0, span], [-span, 0]] {
            for choice in 0..1 << 9 {
                let at = |of: usize| ends[choice >> of & 1];
                let facet = [0, 1, 2].map(|corner| [0, 1, 2].map(|axis| at(3 * corner + axis)));
                let Some(touched) = Touched::new(&facet, MIN_FRACTION_BITS, &rays) else { continue };
                for Slab { n, low, high } in &touched.slabs {
                    of_n = n.iter().map(|part| width(*part)).fold(of_n, u32::max);
                    of_ends =
                        [low, high].map(|end| width(end << MIN_FRACTION_BITS)).into_iter().fold(of_ends, u32::max);
                }
            }
        }
        assert_eq!([of_n, of_ends], [53, 80]);
    }
}

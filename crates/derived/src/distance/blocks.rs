//! Distances of blocks of points: what no point of a block can be nearest to is left out for all of them at once.
//!
//! # Theory
//! Let D be the distance of the middle of a block, and r that of its corners from the middle. No point of the block is farther from the surface than D + r, so no facet counts
//! that is farther from the middle than D + 2 r. Where D - r is more than the width of the band, all points of the block are beyond it.
//!
//! So a block is halved until it has a few points along each axis, and beyond the band no longer. Facets near it are put in the order of their distance from its middle: for a
//! point they end where that less its own distance from the middle is more than the least so far. The first that is looked at is the nearest of the point before; of most others
//! the box around them is far enough.
//!
//! The number of a point does not depend on the block: any facets but those that cannot be nearest change nothing.
//!
//! Source: ours. Cost: some tens of facets a point near the surface.

use super::facet::Facet;
use super::scan::Places;
use super::tree::{Bounds, ROUNDING, Stack, Tree};

/// Most points of a block along each axis.
const MAX_OF_BLOCK: usize = 4;
/// From as many times the radius of a block on its points are looked at one by one: too many facets may be the nearest of some point.
const FAR: f64 = 2.0;
/// Where more facets may be, points are looked at one by one, too.
const MOST_NEAR: usize = 256;

/// Memory that is used again.
#[derive(Default)]
pub(super) struct Memory<'a> {
    stack: Stack,
    near: Vec<Near<'a>>,
}

/// A facet near a block.
struct Near<'a> {
    of_middle: f64,
    bounds: &'a Bounds,
    facet: &'a Facet,
}

/// Fills distances of points, x fastest, with at most a width.
pub(super) struct Blocks<'a> {
    pub(super) tree: &'a Tree,
    pub(super) width: f64,
    pub(super) places: Places<'a>,
}

impl<'a> Blocks<'a> {
    /// The distances of all points.
    pub(super) fn distances(&self, memory: &mut Memory<'a>) -> Vec<f64> {
        let n = self.places.map(<[f64]>::len);
        // what is not looked at lies beyond the band
        let mut distances = vec![self.width; n.iter().product()];
        if !distances.is_empty() {
            self.fill([[0; 3], n], f64::INFINITY, &mut distances, memory);
        }
        distances
    }

    /// Fills the block from a point to another, exclusive; `most` is no less than the distance of its middle.
    fn fill(&self, [first, end]: [[usize; 3]; 2], most: f64, distances: &mut [f64], memory: &mut Memory<'a>) {
        let middle = self.middle([first, end]);
        let radius = between(&middle, &[0, 1, 2].map(|axis| self.places[axis][first[axis]]));
        let far = (self.width + radius) * (1.0 + ROUNDING);
        let limit = (most * (1.0 + ROUNDING)).min(far);
        let nearest = self.tree.nearest(&middle, limit * limit, &mut memory.stack);
        let distance = nearest.map_or(limit, |(square, _)| square.sqrt());
        if distance >= far {
            return;
        }
        let n = [0, 1, 2].map(|axis| end[axis] - first[axis]);
        if n.iter().all(|n| *n <= MAX_OF_BLOCK) {
            let reach = (distance + 2.0 * radius).min(far) * (1.0 + ROUNDING);
            let is_near = distance <= FAR * radius && self.find_near(&middle, reach, memory);
            let all = f64::INFINITY;
            let nearest = nearest.or_else(|| self.tree.nearest(&middle, all, &mut memory.stack));
            match nearest {
                Some((_, nearest)) if !is_near => self.fill_one_by_one([first, end], nearest, distances, memory),
                Some((_, nearest)) => self.fill_by_near([first, end], (middle, nearest), distances, memory),
                None => {}
            }
            return;
        }
        let longest = (0..3).fold(0, |longest, axis| if n[axis] > n[longest] { axis } else { longest });
        // whole blocks in front
        let half = (n[longest] / 2).next_multiple_of(MAX_OF_BLOCK).min(n[longest] - 1);
        let (mut end_of_one, mut first_of_other) = (end, first);
        end_of_one[longest] = first[longest] + half;
        first_of_other[longest] = first[longest] + half;
        for half in [[first, end_of_one], [first_of_other, end]] {
            let most = distance + between(&middle, &self.middle(half));
            self.fill(half, most, distances, memory);
        }
    }

    fn fill_one_by_one(
        &self,
        block: [[usize; 3]; 2],
        mut nearest: &'a Facet,
        distances: &mut [f64],
        memory: &mut Memory<'a>,
    ) {
        self.each(block, distances, |point| {
            let least = nearest.square(point);
            let nearer = self.tree.nearest(point, least, &mut memory.stack);
            let (least, facet) = nearer.unwrap_or((least, nearest));
            nearest = facet;
            least
        });
    }

    /// Fills the points of a block with the roots of what is found for them.
    fn each(&self, [first, end]: [[usize; 3]; 2], distances: &mut [f64], mut square: impl FnMut(&[f64; 3]) -> f64) {
        let [nx, ny] = [0, 1].map(|axis| self.places[axis].len());
        for z in first[2]..end[2] {
            for y in first[1]..end[1] {
                for x in first[0]..end[0] {
                    let least = square(&[self.places[0][x], self.places[1][y], self.places[2][z]]);
                    distances[x + nx * (y + ny * z)] = least.sqrt().min(self.width);
                }
            }
        }
    }

    /// The middle of the block from a point to another, exclusive.
    fn middle(&self, [first, end]: [[usize; 3]; 2]) -> [f64; 3] {
        [0, 1, 2].map(|axis| 0.5 * (self.places[axis][first[axis]] + self.places[axis][end[axis] - 1]))
    }

    /// Finds the facets that may be the nearest of some point of a block, the nearest of its middle first; false where they are too many.
    fn find_near(&self, middle: &[f64; 3], reach: f64, Memory { stack, near }: &mut Memory<'a>) -> bool {
        near.clear();
        let square = reach * reach;
        let is_all = self.tree.within(middle, square, stack, |facet, bounds| {
            let of_middle = facet.square(middle);
            if of_middle <= square {
                near.push(Near { of_middle: of_middle.sqrt() * (1.0 - ROUNDING), bounds, facet });
            }
            near.len() <= MOST_NEAR
        });
        near.sort_unstable_by(|one, other| one.of_middle.total_cmp(&other.of_middle));
        is_all
    }

    fn fill_by_near(
        &self,
        block: [[usize; 3]; 2],
        (middle, mut nearest): ([f64; 3], &'a Facet),
        distances: &mut [f64],
        Memory { near, .. }: &mut Memory<'a>,
    ) {
        self.each(block, distances, |point| {
            let moved = between(&middle, point);
            let mut least = nearest.square(point);
            let mut enough = (least.sqrt() + moved) * (1.0 + ROUNDING);
            for Near { of_middle, bounds, facet } in near.iter() {
                if *of_middle > enough {
                    break;
                }
                if bounds.square(point) * (1.0 - ROUNDING) >= least {
                    continue;
                }
                let of_facet = facet.square(point);
                if of_facet < least {
                    (least, nearest) = (of_facet, facet);
                    enough = (least.sqrt() + moved) * (1.0 + ROUNDING);
                }
            }
            least
        });
    }
}

fn between(one: &[f64; 3], other: &[f64; 3]) -> f64 {
    let [x, y, z] = [0, 1, 2].map(|axis| one[axis] - other[axis]);
    (x * x + y * y + z * z).sqrt()
}

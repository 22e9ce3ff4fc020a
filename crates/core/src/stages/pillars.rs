//! Pillars: the ray through any point, and the facets that it crosses, exactly.
//!
//! Snapped facets, an axis -> [`Pillars`]; a point in units of the snap -> its crossings.
//!
//! # Theory
//! The plane across the axis is cut into squares, the feet of pillars along it. Each has the facets whose boxes reach into it. The ray through a
//! point lies in one pillar, and its facets are tested by the integers of [`crate::stages::facet`], with the same rule for ties: the point stands for
//! `P - (e1, e2, e3)`, `e1 >> e2 >> e3 > 0` along x, y and z. So a point at the centre of a cell has the crossings of that cell's ray, and a closed
//! surface is crossed an even number of times by the ray through any point.
//!
//! # Practice
//! Squares have sides of 2^n units, and there are about as many as facets, unless large facets lie in many: then they are larger, so that the lists
//! stay short. A point beyond the box of all facets has no crossing.
//! Degenerate case: a facet that is parallel to the axis is never crossed, and is left out.
//! Cost: 36 bytes a facet and some 4 to 40 for its pillars; a point some 10 ns for each facet of its pillar.

use crate::grid::frame::SnappedFacet;
use crate::grid::rays::Rays;
use crate::stages::facet::{slope, twice_area};

/// Most entries of lists for each facet, on average, unless there are few.
const ENTRIES_OF_FACET: u64 = 8;
const FEW_ENTRIES: u64 = 1 << 16;

/// A crossing of a ray with a facet, seen from a point on it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Crossed {
    /// Index of the facet among those given.
    pub facet: u32,
    /// Whether the crossing lies below the point: nearer to the start of the axis.
    pub is_below: bool,
    /// Whether the ray leaves the body here: the facet's normal points along it.
    pub exits: bool,
}

/// Facets by the pillars that they reach into.
#[derive(Debug, Clone, PartialEq)]
pub struct Pillars {
    axis: usize,
    /// Each: first and second axis across, axis; and its index.
    facets: Vec<([[i32; 3]; 3], u32)>,
    squares: Squares,
    /// End in `entries` of the list of each pillar.
    ends: Vec<u32>,
    entries: Vec<u32>,
}

/// The feet of the pillars.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Squares {
    low: [i32; 2],
    high: [i32; 2],
    /// Their sides are 2^bits units.
    bits: u32,
}

impl Squares {
    fn counts(&self) -> [u64; 2] {
        [0, 1].map(|side| 1 + ((i64::from(self.high[side]) - i64::from(self.low[side])) >> self.bits) as u64)
    }

    /// The first and the last square along both sides of what lies within the box.
    fn under(&self, [low, high]: [[i32; 2]; 2]) -> [[usize; 2]; 2] {
        let square = |side: usize, place: i32| ((i64::from(place) - i64::from(self.low[side])) >> self.bits) as usize;
        [0, 1].map(|side| [square(side, low[side]), square(side, high[side])])
    }
}

impl Pillars {
    /// Puts facets in pillars along an axis.
    pub fn new(axis: usize, facets: &[SnappedFacet]) -> Pillars {
        let rays = Rays::new(axis, [1; 3]);
        let projected = (0u32..).zip(facets).map(|(index, facet)| (facet.map(|corner| rays.project(corner)), index));
        let facets: Vec<_> = projected.filter(|(corners, _)| twice_area(&wide(corners)) != 0).collect();
        let mut squares = Squares { low: [i32::MAX; 2], high: [i32::MIN; 2], bits: 0 };
        for [low, high] in facets.iter().map(|(corners, _)| ends(corners)) {
            squares.low = [0, 1].map(|side| squares.low[side].min(low[side]));
            squares.high = [0, 1].map(|side| squares.high[side].max(high[side]));
        }
        let mut pillars = Pillars { axis, facets, squares, ends: Vec::new(), entries: Vec::new() };
        if !pillars.facets.is_empty() {
            pillars.choose_squares();
            pillars.fill();
        }
        pillars
    }

    /// Bytes that it holds.
    pub fn n_bytes(&self) -> u64 {
        40 * self.facets.capacity() as u64 + 4 * (self.ends.capacity() + self.entries.capacity()) as u64
    }

    /// The least size of squares of which there are no more than facets, and whose lists are not too long.
    fn choose_squares(&mut self) {
        // entries are counted in 32 bits; facets are fewer than 2^31
        let most = (ENTRIES_OF_FACET * self.facets.len() as u64 + FEW_ENTRIES).min(u32::MAX.into());
        let n_squares = |squares: &Squares| squares.counts().iter().product::<u64>();
        while n_squares(&self.squares) > self.facets.len() as u64 {
            self.squares.bits += 1;
        }
        let n_entries = |squares: &Squares| -> u64 {
            let of = |(corners, _): &([[i32; 3]; 3], u32)| {
                squares.under(ends(corners)).iter().map(|[first, last]| (last - first + 1) as u64).product::<u64>()
            };
            self.facets.iter().map(of).sum()
        };
        // one square has an entry a facet
        while n_entries(&self.squares) > most {
            self.squares.bits += 1;
        }
    }

    fn fill(&mut self) {
        let [n, m] = self.squares.counts().map(|count| count as usize);
        let mut next = vec![0u32; n * m + 1];
        let squares = self.squares;
        let under = |corners: &[[i32; 3]; 3]| {
            let [across, down] = squares.under(ends(corners));
            (down[0]..=down[1]).flat_map(move |row| (across[0]..=across[1]).map(move |column| n * row + column))
        };
        self.facets.iter().flat_map(|(corners, _)| under(corners)).for_each(|square| next[square + 1] += 1);
        for square in 0..n * m {
            next[square + 1] += next[square];
        }
        self.entries = vec![0; next[n * m] as usize];
        for (place, (corners, _)) in (0u32..).zip(&self.facets) {
            for square in under(corners) {
                self.entries[next[square] as usize] = place;
                next[square] += 1;
            }
        }
        // each is now where the next list begins
        next.pop();
        self.ends = next;
    }

    /// The pillar of a point; None beyond all facets.
    pub fn pillar(&self, point: [i32; 3]) -> Option<usize> {
        let [x, y, _] = Rays::new(self.axis, [1; 3]).project(point);
        let Squares { low, high, .. } = self.squares;
        if x < low[0] || x > high[0] || y < low[1] || y > high[1] {
            return None;
        }
        let [[column, _], [row, _]] = self.squares.under([[x, y], [x, y]]);
        Some(self.squares.counts()[0] as usize * row + column)
    }

    /// Hands out all crossings of the ray through a point, in the order of the facets.
    #[inline]
    pub fn crossings(&self, point: [i32; 3], mut found: impl FnMut(Crossed)) {
        let Some(pillar) = self.pillar(point) else { return };
        let start = if pillar == 0 { 0 } else { self.ends[pillar - 1] };
        let point = Rays::new(self.axis, [1; 3]).project(point);
        for &place in &self.entries[start as usize..self.ends[pillar] as usize] {
            let (corners, facet) = &self.facets[place as usize];
            if let Some((is_below, exits)) = crossed(corners, point, self.axis) {
                found(Crossed { facet: *facet, is_below, exits });
            }
        }
    }
}

/// Whether the ray through a point crosses a facet: whether below it, and whether it leaves there. Coordinates of corners span 2^27 units at most; the
/// point lies within their box across the rays, or is refused, and within 2^29 along them.
#[inline]
fn crossed(corners: &[[i32; 3]; 3], point: [i32; 3], axis: usize) -> Option<(bool, bool)> {
    let [low, high] = ends(corners);
    if (0..2).any(|side| point[side] < low[side] || point[side] > high[side]) {
        return None;
    }
    let mut corners = wide(corners);
    let [x, y, z] = point.map(i64::from);
    let area = twice_area(&corners);
    if area < 0 {
        corners.swap(1, 2);
    }
    for edge in 0..3 {
        let ([from_x, from_y, _], [to_x, to_y, _]) = (corners[edge], corners[(edge + 1) % 3]);
        let (a, b) = (from_y - to_y, to_x - from_x);
        let value = a * (x - from_x) + b * (y - from_y);
        if value < 0 || value == 0 && !(a < 0 || a == 0 && b < 0) {
            return None;
        }
    }
    // (x, z, y) is an odd permutation of the axes
    let exits = (area > 0) != (axis == 1);
    let heights = corners.map(|corner| corner[2]);
    if heights.iter().all(|&height| height < z) {
        return Some((true, exits));
    }
    if heights.iter().all(|&height| height > z) {
        return Some((false, exits));
    }
    let [across, down] = slope(&corners);
    let [from_x, from_y, from_z] = corners[0].map(i128::from);
    // how far the point is above the plane, times the area
    let above = (i128::from(z) - from_z) * i128::from(area.abs())
        - i128::from(across) * (i128::from(x) - from_x)
        - i128::from(down) * (i128::from(y) - from_y);
    let tie_is_above = match axis {
        0 => false,
        1 => across > 0,
        _ => across > 0 || across == 0 && down > 0,
    };
    Some((above > 0 || above == 0 && tie_is_above, exits))
}

fn wide(corners: &[[i32; 3]; 3]) -> [[i64; 3]; 3] {
    corners.map(|corner| corner.map(i64::from))
}

/// The box of a facet across the rays.
#[inline]
fn ends([a, b, c]: &[[i32; 3]; 3]) -> [[i32; 2]; 2] {
    [[0, 1].map(|side| a[side].min(b[side]).min(c[side])), [0, 1].map(|side| a[side].max(b[side]).max(c[side]))]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A box from 0 to 8 along each axis, facing out.
    fn cube() -> Vec<SnappedFacet> {
        let corner = |of: usize| [0, 1, 2].map(|axis| if of >> axis & 1 == 1 { 8 } else { 0 });
        let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]].map(|of| of.map(corner))).collect()
    }

    #[test]
    fn every_point_of_a_box_and_none_beside_it_is_inside_along_every_axis() {
        for axis in 0..3 {
            let pillars = Pillars::new(axis, &cube());
            for place in 0..11 * 11 * 11 {
                let point = [place % 11 - 1, place / 11 % 11 - 1, place / 121 - 1];
                let (mut below, mut all, mut winding) = (0, 0, 0);
                pillars.crossings(point, |of| {
                    all += 1;
                    below += i32::from(of.is_below);
                    winding += i32::from(of.is_below) * if of.exits { -1 } else { 1 };
                });
                // a tie belongs to (low, high]
                let is_inside = point.iter().all(|&at| at > 0 && at <= 8);
                assert_eq!((below % 2 == 1, winding), (is_inside, i32::from(is_inside)), "{point:?} along {axis}");
                assert_eq!(all % 2, 0, "{point:?} along {axis}");
            }
        }
    }

    #[test]
    fn large_facets_do_not_fill_all_pillars() {
        // many facets over one another, each as large as the whole
        let facets: Vec<SnappedFacet> =
            (0..40_000).map(|of| [[0, 0, of], [1 << 26, 0, of], [0, 1 << 26, of]]).collect();
        let pillars = Pillars::new(2, &facets);
        assert!(pillars.entries.len() as u64 <= ENTRIES_OF_FACET * 40_000 + FEW_ENTRIES, "{}", pillars.entries.len());
        let mut below = 0;
        pillars.crossings([5, 5, 20_000], |of| below += u32::from(of.is_below));
        // of the facet at the point the point is before, as it stands a little nearer to the start
        assert_eq!(below, 20_000);
    }

    /// What does not fit on the way ends the test: it is compiled with checks for overflow. All numbers are affine in each coordinate.
    #[test]
    fn numbers_fit_where_corners_and_points_are_as_far_from_each_other_as_they_may_be() {
        let (span, far) = (1 << 27, 1 << 29);
        let mut n_crossed = 0;
        for choice in 0..1 << 12 {
            let end = |of: usize| if choice >> of & 1 == 1 { span } else { 0 };
            let corners: [[i32; 3]; 3] =
                std::array::from_fn(|corner| std::array::from_fn(|axis| end(3 * corner + axis)));
            for z in [-far, 0, span / 2, span, far] {
                let point = [end(9), end(10), z];
                n_crossed += (0..3).filter(|&axis| crossed(&corners, point, axis).is_some()).count();
            }
        }
        assert!(n_crossed > 1000, "{n_crossed}");
    }

    #[test]
    fn nothing_has_no_crossing() {
        for facets in [vec![], vec![[[0, 0, 0], [0, 5, 0], [0, 5, 5]]]] {
            let mut n = 0;
            Pillars::new(2, &facets).crossings([0; 3], |_| n += 1);
            assert_eq!(n, 0);
        }
    }
}

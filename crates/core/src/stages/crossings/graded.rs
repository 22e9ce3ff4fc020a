//! Rays at the centres of cells that differ in size: they are not equally far from each other, and neither are the centres along them.
//!
//! The numbers of a facet are those of any other, counted in units of the snap: a ray hits iff all three `q >= 0`, and its height is
//! `Z = height / D` units. The first cell above is the first whose centre is greater than Z, or equal to it if the tie rule puts the
//! centre above; both the rays of a row that hit and that cell are searched among the centres.
//!
//! Twins: `shaders/intersect_graded.wgsl`, `shaders/shared/graded.wgsl`.
//! Cost: a division and a binary search a crossing.

use std::ops::Range;

use super::rows::{Height, Rows};
use crate::grid::frame::Frame;
use crate::grid::rays::Rays;
use crate::stages::facet::Projected;

/// Passes on the hits of a facet with the rays of a window.
#[inline(always)]
pub(super) fn hits(facet: &Projected, (frame, rays): (&Frame, &Rays), window: &[Range<u32>; 2], rows: &mut impl Rows) {
    let [across, down] = facet.rays;
    let from = |side: usize, ray: u32| {
        let centre = |ray: u32| i64::from(frame.centre(rays.across[side], ray));
        centre(ray) - centre(facet.rays[side][0])
    };
    for j in window[1].start.max(down[0])..window[1].end.min(down[1] + 1) {
        let dj = from(1, j);
        let limits = window[0].start.max(across[0])..window[0].end.min(across[1] + 1);
        // inside an edge are the first rays of a row, or the last, or all, or none
        let range = (0..3).fold(limits, |range, edge| {
            let is_inside = |i: u32| facet.q[edge] + facet.a[edge] * from(0, i) + facet.b[edge] * dj >= 0;
            let rising = facet.a[edge] > 0;
            let n = first_where(&range, |i| is_inside(i) == rising);
            if rising { n..range.end } else { range.start..n }
        });
        let hits = range.clone().map(|i| {
            let (below, rest) = height(facet, [from(0, i), dj]);
            // a centre at the crossing is above it only by the tie rule
            let is_at_centre = rest == 0 && facet.tie_is_above;
            let above = frame.n_below(rays.axis, below, !is_at_centre);
            (above, Height { below: below.into(), rest, area: facet.area, unit: 1.0, is_at_centre })
        });
        rows.row(j, range, hits);
    }
}

/// The first number of a range for which something is true that stays true from there on; else the end.
fn first_where(range: &Range<u32>, is_true: impl Fn(u32) -> bool) -> u32 {
    let (mut low, mut high) = (range.start, range.end.max(range.start));
    while low < high {
        let middle = low + (high - low) / 2;
        if is_true(middle) { high = middle } else { low = middle + 1 }
    }
    low
}

/// The height of a facet in units, rounded down, at a ray so many units from its first; and the rest, over D.
fn height(facet: &Projected, [di, dj]: [i64; 2]) -> (i32, i64) {
    let area = i128::from(facet.area);
    let height =
        facet.height + i128::from(facet.slope[0]) * i128::from(di) + i128::from(facet.slope[1]) * i128::from(dj);
    // within the corners of the facet, and so of 27 bits: off by one at most
    let mut below = (height as f64 / facet.area as f64).floor() as i128;
    let mut rest = height - below * area;
    while rest < 0 {
        (below, rest) = (below - 1, rest + area);
    }
    while rest >= area {
        (below, rest) = (below + 1, rest - area);
    }
    (below as i32, rest as i64)
}

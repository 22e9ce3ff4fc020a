//! Facets, sorted by the cells that they reach and clipped to them.
//!
//! A polygon is cut by the planes of the lines across z, then y, then x. What lies in such a plane belongs to the cell below it. All is exact but for
//! the rounding of f64. Each cell is cut out by itself, so that the other cells do not change its last bits.

use std::ops::Range;

use hexcast_core::base::sort::by_number;
use hexcast_core::grid::frame::{Frame, SnappedFacet};
use hexcast_core::grid::lines::Lines;
use hexcast_core::grid::window::CellWindow;

pub(super) type Point = [f64; 3];

/// The facets that reach into each row of cells of a window: into some planes across z.
pub(super) struct FacetRows<'a> {
    pub(super) frame: &'a Frame,
    pub(super) window: CellWindow,
    /// Lines of each axis of the box in units.
    pub(super) lines: [Vec<f64>; 3],
    /// First facet of each row, then the end.
    offsets: Vec<u32>,
    facets: Vec<u32>,
}

impl<'a> FacetRows<'a> {
    /// Sorts facets by rows of planes of cells across z.
    pub(super) fn new(frame: &'a Frame, lines: &Lines, window: CellWindow, planes_of_row: u32) -> FacetRows<'a> {
        // as exact as the corners: what lies in a plane between cells must be found there
        let lines =
            [0, 1, 2].map(|axis| (0..=lines.dims()[axis]).map(|line| f64::from(frame.face(axis, line))).collect());
        let lines: [Vec<f64>; 3] = lines;
        let [first, end] = [window.first[2], window.end[2]];
        let n_rows = (end - first).div_ceil(planes_of_row) as usize;
        let mut pairs = Vec::new();
        for (index, facet) in (0u32..).zip(&frame.facets) {
            let ends = facet.map(|corner| f64::from(corner[2]));
            let [low, high] = [f64::min, f64::max].map(|of| ends.into_iter().reduce(of).unwrap_or(0.0));
            let plane = |at: f64| lines[2].partition_point(|&line| line < at).saturating_sub(1) as u32;
            let planes = plane(low).max(first)..(plane(high) + 1).min(end);
            if !planes.is_empty() {
                let row = |plane: u32| (plane - first) / planes_of_row;
                pairs.extend((row(planes.start)..=row(planes.end - 1)).map(|row| (row, index)));
            }
        }
        let (mut offsets, mut facets) = (Vec::new(), Vec::new());
        by_number(pairs.iter().copied(), n_rows, &mut offsets, &mut facets);
        FacetRows { frame, window, lines, offsets, facets }
    }

    /// The indices of those of a row.
    pub(super) fn of_row(&self, row: u32) -> &[u32] {
        &self.facets[self.offsets[row as usize] as usize..self.offsets[row as usize + 1] as usize]
    }
}

/// A convex polygon: what of a triangle lies between six planes.
pub(super) struct Polygon {
    corners: [Point; 9],
    n: usize,
}

/// Of a plane.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Side {
    Below,
    Above,
}

impl Polygon {
    const EMPTY: Polygon = Polygon { corners: [[0.0; 3]; 9], n: 0 };

    /// All of a facet.
    pub(super) fn new(facet: &SnappedFacet) -> Polygon {
        let mut whole = Polygon::EMPTY;
        facet.iter().for_each(|corner| whole.push(corner.map(f64::from)));
        whole
    }

    /// Its least and its greatest place along an axis.
    pub(super) fn reach(&self, axis: usize) -> [f64; 2] {
        let places = || self.corners().iter().map(|corner| corner[axis]);
        [places().fold(f64::INFINITY, f64::min), places().fold(f64::NEG_INFINITY, f64::max)]
    }

    fn push(&mut self, corner: Point) {
        self.corners[self.n] = corner;
        self.n += 1;
    }

    pub(super) fn corners(&self) -> &[Point] {
        &self.corners[..self.n]
    }

    /// What lies on one side of a plane across an axis, or in it, put together in `space` where that is not all; what lies in the plane alone is below it.
    #[inline(always)]
    fn clipped<'p>(&'p self, (axis, at): (usize, f64), side: Side, space: &'p mut Polygon) -> &'p Polygon {
        let height = |corner: &Point| corner[axis] - at;
        let is_below = self.corners().iter().all(|corner| height(corner) <= 0.0);
        if is_below || self.corners().iter().all(|corner| height(corner) >= 0.0) {
            if is_below == (side == Side::Below) {
                return self;
            }
            space.n = 0;
            return space;
        }
        space.n = 0;
        for index in 0..self.n {
            let (from, to) = (self.corners[index], self.corners[if index + 1 == self.n { 0 } else { index + 1 }]);
            let [start, end] = [height(&from), height(&to)];
            if if side == Side::Below { start <= 0.0 } else { start >= 0.0 } {
                space.push(from);
            }
            if start * end < 0.0 {
                let share = start / (start - end);
                let mut cut = [0, 1, 2].map(|of| from[of] + share * (to[of] - from[of]));
                cut[axis] = at;
                space.push(cut);
            }
        }
        space
    }

    /// Calls `each` with the cells of an axis that the polygon reaches, of some, and with what lies in each: the same whichever these are.
    #[inline(always)]
    pub(super) fn slices(&self, axis: usize, lines: &[f64], cells: Range<u32>, mut each: impl FnMut(u32, &Polygon)) {
        let [low, high] = self.reach(axis);
        let of_cells = &lines[cells.start as usize..=cells.end as usize];
        let first = cells.start as usize + of_cells.partition_point(|&line| line < low);
        let (mut one, mut other) = (Polygon::EMPTY, Polygon::EMPTY);
        for cell in (first.saturating_sub(1) as u32).max(cells.start)..cells.end {
            let [begin, end] = [0, 1].map(|by| lines[cell as usize + by]);
            if begin >= high && begin > low {
                return;
            }
            // what lies in the first line has no cell below, and belongs to the first
            let above = if low > begin || cell == 0 && low == begin {
                self
            } else {
                self.clipped((axis, begin), Side::Above, &mut one)
            };
            let within = above.clipped((axis, end), Side::Below, &mut other);
            if within.n >= 3 {
                each(cell, within);
            }
        }
    }
}

//! Numbers of edges and faces, and what lies outside metal of those that are cut.

use std::ops::Range;

use hexcast_core::base::error::Result;
use hexcast_core::base::sort::sort_by;
use hexcast_core::cells::columns::Columns;
use hexcast_core::cells::flags::{CellBox, flags_of_box};

use crate::staggered::under;

/// The components: edges along x, y and z, then faces across x, y and z; and along which axes they lie on lines, as those of E and H do.
pub const PARTS: [(&str, [bool; 3]); 6] = [
    ("Lx", [false, true, true]),
    ("Ly", [true, false, true]),
    ("Lz", [true, true, false]),
    ("Ax", [true, false, false]),
    ("Ay", [false, true, false]),
    ("Az", [false, false, true]),
];

/// Edges or faces of a box, numbered x fastest.
#[derive(Clone, Copy)]
pub(super) struct Grid {
    pub(super) dims: [u32; 3],
}

impl Grid {
    pub(super) fn new(dims: [u32; 3]) -> Grid {
        Grid { dims }
    }

    /// Those of a component of so many cells.
    pub(super) fn of_part(cells: [u32; 3], part: usize) -> Grid {
        Grid { dims: [0, 1, 2].map(|axis| cells[axis] + u32::from(PARTS[part].1[axis])) }
    }

    pub(super) fn index(&self, [x, y, z]: [u32; 3]) -> u64 {
        let [nx, ny, _] = self.dims.map(u64::from);
        u64::from(x) + nx * (u64::from(y) + ny * u64::from(z))
    }

    pub(super) fn place(&self, index: u64) -> [u32; 3] {
        let [nx, ny, _] = self.dims.map(u64::from);
        [index % nx, index / nx % ny, index / (nx * ny)].map(|at| at as u32)
    }

    /// Where one is, counted from the first of so many; None where it is none of these.
    pub(super) fn within(&self, index: u64, start: [u32; 3], n: [u32; 3]) -> Option<[u32; 3]> {
        let place = self.place(index);
        let at = [0, 1, 2].map(|axis| place[axis].wrapping_sub(start[axis]));
        (0..3).all(|axis| at[axis] < n[axis]).then_some(at)
    }
}

/// The cells by their rank + 1, and which of these are metal.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Cells {
    codes: Columns,
    is_metal: Vec<bool>,
}

impl Cells {
    pub(super) fn new(codes: Columns, flag_of_rank: &[u8], is_metal: &[bool; 256]) -> Cells {
        let flags = [0].iter().chain(flag_of_rank);
        Cells { codes, is_metal: flags.map(|flag| is_metal[usize::from(*flag)]).collect() }
    }

    /// Whether the cells are metal that some edges or faces are at the lower sides of, or, at the end of the box, at the upper.
    ///
    /// # Errors
    /// `io` where the cells are in a store that fails.
    pub(super) fn are_metal(&self, places: impl Iterator<Item = [u32; 3]>) -> Result<Vec<bool>> {
        let dims = self.codes.dims();
        let cells: Vec<_> = places.map(|at| ([0, 1, 2].map(|axis| at[axis].min(dims[axis] - 1)), 0)).collect();
        let codes = under(&self.codes, &cells)?;
        Ok(codes.into_iter().map(|code| self.is_metal[usize::from(code)]).collect())
    }

    /// The fraction outside metal that each of a box of edges or faces has by such a cell, 0 or 1; the first is at that cell.
    ///
    /// # Errors
    /// `io` where the cells are in a store that fails.
    pub(super) fn fractions(&self, first: [u32; 3], some: &CellBox) -> Result<Vec<f64>> {
        let last = self.codes.dims().map(|n| n - 1);
        let cell = |axis: usize, at: u32| (first[axis] + at).min(last[axis]);
        let cells = [0, 1, 2].map(|axis: usize| {
            let Some(end) = some[axis].end.checked_sub(1).filter(|end| *end >= some[axis].start) else { return 0..0 };
            cell(axis, some[axis].start)..cell(axis, end) + 1
        });
        let of_cells = flags_of_box(&self.codes, &cells)?;
        let n = [0, 1, 2].map(|axis| cells[axis].len());
        let mut fractions = Vec::with_capacity(some.iter().map(|range| range.len()).product());
        for z in some[2].clone() {
            let plane = (cell(2, z) - cells[2].start) as usize;
            for y in some[1].clone() {
                let row = n[0] * (plane * n[1] + (cell(1, y) - cells[1].start) as usize);
                fractions.extend(some[0].clone().map(|x| {
                    let code = of_cells[row + (cell(0, x) - cells[0].start) as usize];
                    if self.is_metal[usize::from(code)] { 0.0 } else { 1.0 }
                }));
            }
        }
        Ok(fractions)
    }
}

/// The four edges of a face across an axis: the axis along each, and its place.
pub(super) fn edges_of_face(axis: usize, face: [u32; 3]) -> [(usize, [u32; 3]); 4] {
    let [one, other] = [(axis + 1) % 3, (axis + 2) % 3];
    let behind = |across: usize| [0, 1, 2].map(|of| face[of] + u32::from(of == across));
    [(one, face), (one, behind(other)), (other, face), (other, behind(one))]
}

/// The fractions outside metal of some edges or faces of a component, by their numbers, ascending.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Outside(Vec<(u64, f64)>);

impl Outside {
    pub(super) fn all(&self) -> &[(u64, f64)] {
        &self.0
    }

    /// Adds some; of those with one number the least counts.
    pub(super) fn lower(&mut self, more: Vec<(u64, f64)>) {
        if more.is_empty() {
            return;
        }
        self.0.extend(more);
        sort_by(&mut self.0, |one, other| (one.0, one.1) < (other.0, other.1));
        self.0.dedup_by_key(|(index, _)| *index);
    }

    /// The fraction of one; None where it is not listed, and so that of the cells beside it.
    pub(super) fn get(&self, index: u64) -> Option<f64> {
        self.0.binary_search_by_key(&index, |(index, _)| *index).ok().map(|at| self.0[at].1)
    }

    /// Gives some, in the order of their numbers, other fractions.
    pub(super) fn set(&mut self, some: Vec<(u64, f64)>) {
        let mut old = std::mem::take(&mut self.0).into_iter().peekable();
        for (index, fraction) in some {
            while let Some(before) = old.next_if(|(at, _)| *at < index) {
                self.0.push(before);
            }
            old.next_if(|(at, _)| *at == index);
            self.0.push((index, fraction));
        }
        self.0.extend(old);
    }

    /// Those of some planes across z.
    pub(super) fn of_planes(&self, grid: &Grid, planes: Range<u32>) -> &[(u64, f64)] {
        let [start, end] = [planes.start, planes.end].map(|plane| grid.index([0, 0, plane]));
        let [start, end] = [start, end].map(|index| self.0.partition_point(|(at, _)| *at < index));
        &self.0[start..end]
    }

    /// Those of some of a box, from a place on, with their numbers there.
    pub(super) fn cut(self, (grid, start): (Grid, [u32; 3]), to: Grid) -> Outside {
        if grid.dims == to.dims {
            return self;
        }
        let inside = |(index, fraction)| Some((to.index(grid.within(index, start, to.dims)?), fraction));
        Outside(self.0.into_iter().filter_map(inside).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_least_of_several_counts_and_others_replace_it() {
        let mut outside = Outside::default();
        outside.lower(vec![(5, 0.5), (2, 1.0), (5, 0.25), (9, 0.0)]);
        assert_eq!(outside.all(), [(2, 1.0), (5, 0.25), (9, 0.0)]);
        outside.set(vec![(1, 0.75), (5, 0.5), (12, 1.0)]);
        assert_eq!(outside.all(), [(1, 0.75), (2, 1.0), (5, 0.5), (9, 0.0), (12, 1.0)]);
        assert_eq!([outside.get(5), outside.get(6)], [Some(0.5), None]);
    }
}

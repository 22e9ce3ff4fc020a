//! The cells that a surface cuts, whether rays meet it there or not.
//!
//! Facets, planes of cells -> [`Cells`], a bit for each. A cell is cut where a facet passes through its inside: one that only touches it, or lies in the
//! plane of a face, cuts none. A facet that passes through cells of a row passes through all from its first to its last, so that it is clipped
//! to rows alone.
//!
//! A facet within another geometry cuts cells, too, although flags do not change there.
//!
//! Cost: two clips for each row of cells that a facet reaches; none for facets within one row.

use std::ops::Range;

use super::polygon::{FacetRows, Polygon};
use crate::window::CellWindow;

/// Some cells of some planes of a window.
pub(super) struct Cells {
    words_of_row: usize,
    rows_of_plane: usize,
    words: Vec<u64>,
}

impl Cells {
    /// None, of so many planes.
    pub(super) fn new(window: &CellWindow, n_planes: u32) -> Cells {
        let [nx, ny] = [0, 1].map(|axis| (window.end[axis] - window.first[axis]) as usize);
        let words_of_row = nx.div_ceil(64);
        Cells { words_of_row, rows_of_plane: ny, words: vec![0; words_of_row * ny * n_planes as usize] }
    }

    /// A row of them, by its place along y and z, counted from the first.
    fn row(&self, [y, z]: [u32; 2]) -> usize {
        (z as usize * self.rows_of_plane + y as usize) * self.words_of_row
    }

    /// Takes cells of a row.
    pub(super) fn add(&mut self, row: [u32; 2], cells: Range<u32>) {
        let first = self.row(row);
        cells.for_each(|x| self.words[first + x as usize / 64] |= 1 << (x % 64));
    }

    /// Those of some cells of a row.
    pub(super) fn of_row(&self, row: [u32; 2], cells: Range<u32>) -> impl Iterator<Item = u32> + use<'_> {
        let words = &self.words[self.row(row)..][..self.words_of_row];
        let mut at = cells.start;
        std::iter::from_fn(move || {
            while at < cells.end {
                let left = words[at as usize / 64] >> (at % 64);
                if left & 1 == 1 {
                    at += 1;
                    return Some(at - 1);
                }
                // to the next bit of this word, or to the next word
                at += if left == 0 { 64 - at % 64 } else { left.trailing_zeros() };
            }
            None
        })
    }
}

/// The cells of some planes of the window across z, which are those of a row, that a surface cuts.
pub(super) fn cut(rows: &FacetRows, row: u32, planes: Range<u32>) -> Cells {
    let FacetRows { frame, window, lines, .. } = rows;
    let CellWindow { first, end, .. } = *window;
    let mut cells = Cells::new(window, planes.end - planes.start);
    let of_box = first[2] + planes.start..first[2] + planes.end;
    for &facet in rows.of_row(row) {
        let whole = Polygon::new(&frame.facets[facet as usize]);
        whole.slices(2, &lines[2], of_box.clone(), |z, polygon| {
            if is_within(&polygon, 2, &lines[2], z) {
                polygon.slices(1, &lines[1], first[1]..end[1], |y, polygon| {
                    if is_within(&polygon, 1, &lines[1], y) {
                        let [low, high] = polygon.reach(0);
                        let from = lines[0].partition_point(|line| *line <= low).saturating_sub(1) as u32;
                        let to = lines[0].partition_point(|line| *line < high) as u32;
                        let some = from.max(first[0])..to.min(end[0]);
                        cells.add(
                            [y - first[1], z - of_box.start],
                            some.start - first[0]..some.end.max(first[0]) - first[0],
                        );
                    }
                });
            }
        });
    }
    cells
}

/// Whether a polygon that lies in a cell along an axis does not lie in a plane between cells.
fn is_within(polygon: &Polygon, axis: usize, lines: &[f64], cell: u32) -> bool {
    let [low, high] = polygon.reach(axis);
    let [begin, end] = [0, 1].map(|by| lines[cell as usize + by]);
    low < end && high > begin
}

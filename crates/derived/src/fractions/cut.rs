//! The cells that a surface cuts, whether rays meet it there or not.
//!
//! Facets, planes of cells -> [`Cells`], a bit for each. A cell is cut where a facet passes through its inside: one that only touches it, or lies in the
//! plane of a face, cuts none. What of a facet lies in a row of cells along x is convex: it passes through all cells from its first to its last. So its edges
//! are followed from row to row, and say where these are.
//!
//! A facet within another geometry cuts cells, too, although flags do not change there.
//!
//! Cost: two clips for each plane of cells that a facet reaches, and some ten nanoseconds for each row.

use std::ops::Range;

use super::polygon::{FacetRows, Polygon};
use hexcast_core::grid::window::CellWindow;

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
        if cells.is_empty() {
            return;
        }
        let words = self.row(row);
        let [first, last] = [cells.start, cells.end - 1].map(|x| x as usize / 64);
        for at in first..=last {
            self.words[words + at] |= within(at, &cells);
        }
    }

    /// How many of some cells of a row.
    pub(super) fn n_of_row(&self, row: [u32; 2], cells: Range<u32>) -> u32 {
        if cells.is_empty() {
            return 0;
        }
        let words = &self.words[self.row(row)..][..self.words_of_row];
        let [first, last] = [cells.start, cells.end - 1].map(|x| x as usize / 64);
        (first..=last).map(|at| (words[at] & within(at, &cells)).count_ones()).sum()
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

/// The bits of some cells in the word of this index, which has some of them.
#[inline(always)]
fn within(at: usize, cells: &Range<u32>) -> u64 {
    let (first, last) = (cells.start, cells.end - 1);
    let from = if at == first as usize / 64 { !0 << (first % 64) } else { !0 };
    if at == last as usize / 64 { from & !0 >> (63 - last % 64) } else { from }
}

/// The lines of an axis, and where among them a place is.
struct Ruler<'a> {
    lines: &'a [f64],
    /// Cells a unit, where all are equal.
    per_unit: Option<f64>,
}

impl Ruler<'_> {
    /// Number of the first lines for which this is so: all that lie below a place, and that at it, if there is one, for which it may be so.
    #[inline(always)]
    fn n(&self, place: f64, is_before: impl Fn(f64) -> bool) -> usize {
        let Some(per_unit) = self.per_unit else { return self.lines.partition_point(|line| is_before(*line)) };
        // lines are where the product is whole, so that rounding leads to the next line at most: the last one below or at the place, or the next
        let near = ((place - self.lines[0]) * per_unit).clamp(0.0, self.lines.len() as f64) as i32 as usize;
        near + usize::from(near < self.lines.len() && is_before(self.lines[near]))
    }

    /// The first and the end of the cells, of some, whose insides have places between two.
    #[inline(always)]
    fn cells(&self, [low, high]: [f64; 2], of: &Range<usize>) -> Range<usize> {
        self.n(low, |line| line <= low).saturating_sub(1).max(of.start)..self.n(high, |line| line < high).min(of.end)
    }
}

/// The least and the greatest place along x of what of a polygon lies in each row of cells, of some: those of its edges there. An edge that lies in a plane
/// between rows, or ends there, is in none of the rows that it does not enter.
fn reaches(polygon: &Polygon, ruler: &Ruler, rows: &Range<usize>, found: &mut Vec<[f64; 2]>) {
    found.clear();
    found.resize(rows.len(), [f64::INFINITY, f64::NEG_INFINITY]);
    let lines = ruler.lines;
    let corners = polygon.corners();
    for (from, to) in corners.iter().zip(corners.iter().cycle().skip(1)) {
        let (low, high) = if from[1] <= to[1] { (from, to) } else { (to, from) };
        let slope = (high[0] - low[0]) / (high[1] - low[1]);
        let at = |row: usize| low[0] + (lines[row] - low[1]) * slope;
        let of_edge = ruler.cells([low[1], high[1]], rows);
        let mut x =
            if of_edge.start < of_edge.end && lines[of_edge.start] > low[1] { at(of_edge.start) } else { low[0] };
        for row in of_edge {
            let next = if lines[row + 1] < high[1] { at(row + 1) } else { high[0] };
            let [least, greatest] = &mut found[row - rows.start];
            (*least, *greatest) = (least.min(x).min(next), greatest.max(x).max(next));
            x = next;
        }
    }
}

/// The cells of some planes of the window across z, which are those of a row, that a surface cuts.
pub(super) fn cut(rows: &FacetRows, row: u32, planes: Range<u32>) -> Cells {
    let FacetRows { frame, window, lines, .. } = rows;
    let CellWindow { first, end, .. } = *window;
    let mut cells = Cells::new(window, planes.end - planes.start);
    let of_box = first[2] + planes.start..first[2] + planes.end;
    let per_unit = (!frame.is_graded()).then(|| 1.0 / f64::from(1u32 << frame.fraction_bits));
    let [across, down] = [0, 1].map(|axis: usize| Ruler { lines: &lines[axis], per_unit });
    let [of_x, of_y] = [0, 1].map(|axis: usize| first[axis] as usize..end[axis] as usize);
    let mut found = Vec::new();
    for &facet in rows.of_row(row) {
        let whole = Polygon::new(&frame.facets[facet as usize]);
        whole.slices(2, &lines[2], of_box.clone(), |z, polygon| {
            let [low, high] = polygon.reach(2);
            let [begin, end] = [0, 1].map(|by| lines[2][z as usize + by]);
            if low >= end || high <= begin {
                // it lies in a plane between cells
                return;
            }
            let of_polygon = down.cells(polygon.reach(1), &of_y);
            reaches(polygon, &down, &of_polygon, &mut found);
            for (y, reach) in of_polygon.zip(&found) {
                let some = across.cells(*reach, &of_x);
                if !some.is_empty() {
                    let some = (some.start - of_x.start) as u32..(some.end - of_x.start) as u32;
                    cells.add([(y - of_y.start) as u32, z - of_box.start], some);
                }
            }
        });
    }
    cells
}

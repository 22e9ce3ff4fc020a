//! Adds up the lengths of the rays of a column of cells, or of faces.

use std::ops::Range;

use super::refined::{PLACE_BITS, Refined, WHOLE};
use crate::input::job::Rule;
use crate::stages::crossings::places::{EVENT_BITS, places};
use crate::stages::inside::{Inside, Kind};
use crate::stages::lattice::{Lattice, lattice};

/// All columns of cells, or of faces.
pub(super) struct Columns<'a> {
    refined: Refined,
    lattice: Lattice,
    rule: Rule,
    kinds: &'a [Kind],
}

/// Lengths of a flag: in all cells behind the last change, and what the cell at hand has besides.
pub(super) struct Sum {
    pub(super) flag: u8,
    behind: i64,
    here: i64,
}

/// In how many parts a cell is divided by so many rays along each axis.
#[doc(hidden)]
pub fn parts_of_cell(rays: u32) -> u64 {
    WHOLE as u64 * u64::from(rays * rays)
}

impl Sum {
    /// In the cell at hand.
    pub(super) fn length(&self) -> i64 {
        self.behind + self.here
    }
}

/// Where the rays of a column change from flag to flag, in lists for each cell.
struct Changes {
    /// `place in the cell << 16 | from << 8 | to`, with the number of the change before it in the same cell.
    words: Vec<(u64, u32)>,
    /// Of each cell that has changes the number of the last one.
    last: Vec<u32>,
    /// A bit for each cell: whether it has changes.
    cells: Vec<u64>,
}

/// Before the first change of a cell.
const NONE: u32 = u32::MAX;

impl<'a> Columns<'a> {
    /// Sorts the facets by rows of columns, so many together.
    pub(super) fn new(refined: Refined, rows: u32, (rule, kinds): (Rule, &'a [Kind])) -> Columns<'a> {
        let bin = [refined.rays.counts[0], rows * refined.per_column[1]];
        let all = 0..Lattice::n_rows(&refined.rays, bin);
        let lattice = lattice(&refined.frame, &refined.rays, bin, all);
        Columns { refined, lattice, rule, kinds }
    }

    /// Columns along each axis across.
    pub(super) fn counts(&self) -> [u32; 2] {
        [0, 1].map(|side| self.refined.rays.counts[side] / self.refined.per_column[side])
    }

    /// The length of a cell, over all rays of a column: a power of two.
    pub(super) fn whole(&self) -> i64 {
        WHOLE * i64::from(self.refined.per_column[0] * self.refined.per_column[1])
    }

    /// Calls `each` with the place of a column of some rows, with consecutive cells that are alike, and with the lengths of the flags in each of them,
    /// ascending, of which some may be 0. The rows are of one bin row of the lattice.
    pub(super) fn rows(&self, rows: Range<u32>, mut each: impl FnMut([u32; 2], Range<u32>, &[Sum])) {
        let Refined { frame, rays, per_column, .. } = &self.refined;
        let [across, down] = per_column.map(|n| n as usize);
        let n_across = rays.counts[0] as usize;
        let of_rays = rows.start * per_column[1]..rows.end * per_column[1];
        let facets = self.lattice.bin_facets(0, of_rays.start / self.lattice.bin[1]);
        let (offsets, mut crossings) = places((frame, rays), facets, of_rays, |at| self.refined.place(at));
        let mut inside = Inside::new(self.kinds, self.rule);
        let outside = inside.flag(&frame.ranks.flag_of_rank);
        let (mut changes, mut sums) = (Changes::new(self.refined.n), Vec::new());
        for row in rows.clone() {
            for column in 0..self.counts()[0] {
                let first = (row - rows.start) as usize * down * n_across + column as usize * across;
                for ray in (0..across * down).map(|of| first + of / across * n_across + of % across) {
                    let of_ray = offsets[ray] as usize..offsets[ray + 1] as usize;
                    self.changes(&mut crossings[of_ray], &mut inside, &mut changes);
                }
                self.sum(outside, &changes, &mut sums, |cells, sums| each([column, row], cells, sums));
                changes.clear();
            }
        }
    }

    /// Adds the changes of a ray.
    fn changes(&self, crossings: &mut [u64], inside: &mut Inside, changes: &mut Changes) {
        if crossings.is_empty() {
            return;
        }
        crossings.sort_unstable();
        inside.begin(self.kinds);
        let flag_of_rank = &self.refined.frame.ranks.flag_of_rank;
        let beyond = u64::from(self.refined.n) << PLACE_BITS;
        let mut flag = inside.flag(flag_of_rank);
        for crossing in crossings {
            let place = *crossing >> EVENT_BITS;
            if place >= beyond {
                break;
            }
            inside.pass((*crossing & ((1 << EVENT_BITS) - 1)) as u32, false);
            let next = inside.flag(flag_of_rank);
            if next != flag {
                changes.push(place, flag, next);
                flag = next;
            }
        }
    }

    /// Walks along a column.
    fn sum(&self, outside: u8, changes: &Changes, sums: &mut Vec<Sum>, mut each: impl FnMut(Range<u32>, &[Sum])) {
        let n_cells = self.refined.n;
        sums.clear();
        sums.push(Sum { flag: outside, behind: self.whole(), here: 0 });
        let mut start = 0;
        while start < n_cells {
            // without changes all cells up to the next are alike
            let cell = changes.cell_from(start).unwrap_or(n_cells);
            if start < cell {
                each(start..cell, sums);
            }
            if cell < n_cells {
                for (from, to, place) in changes.of_cell(cell) {
                    for (flag, sign) in [(from, -1), (to, 1)] {
                        let sum = sum_of(sums, flag);
                        (sum.here, sum.behind) = (sum.here - sign * place, sum.behind + sign * WHOLE);
                    }
                }
                each(cell..cell + 1, sums);
                sums.retain(|sum| sum.behind > 0);
                sums.iter_mut().for_each(|sum| sum.here = 0);
            }
            start = cell + 1;
        }
    }
}

impl Changes {
    fn new(n_cells: u32) -> Changes {
        let n = n_cells as usize;
        Changes { words: Vec::new(), last: vec![0; n], cells: vec![0; n.div_ceil(64)] }
    }

    /// Adds a change at `cell << PLACE_BITS | place in the cell`.
    fn push(&mut self, at: u64, from: u8, to: u8) {
        let cell = (at >> PLACE_BITS) as usize;
        let (of_cells, bit) = (&mut self.cells[cell / 64], 1 << (cell % 64));
        let before = if *of_cells & bit == 0 { NONE } else { self.last[cell] };
        *of_cells |= bit;
        self.last[cell] = self.words.len() as u32;
        let place = at & ((1 << PLACE_BITS) - 1);
        self.words.push((place << 16 | u64::from(from) << 8 | u64::from(to), before));
    }

    /// The first cell from one on that has changes.
    fn cell_from(&self, cell: u32) -> Option<u32> {
        let first = cell as usize / 64;
        let bits = |at: usize| if at == first { self.cells[at] & (!0 << (cell % 64)) } else { self.cells[at] };
        let at = (first..self.cells.len()).find(|&at| bits(at) != 0)?;
        Some(at as u32 * 64 + bits(at).trailing_zeros())
    }

    /// From, to and place in the cell of the changes in a cell that has any.
    fn of_cell(&self, cell: u32) -> impl Iterator<Item = (u8, u8, i64)> {
        let mut next = self.last[cell as usize];
        std::iter::from_fn(move || {
            let (word, before) = *self.words.get(next as usize)?;
            next = before;
            Some(((word >> 8) as u8, word as u8, (word >> 16) as i64))
        })
    }

    fn clear(&mut self) {
        self.words.clear();
        self.cells.fill(0);
    }
}

/// The sum of a flag, in the order of flags.
fn sum_of(sums: &mut Vec<Sum>, flag: u8) -> &mut Sum {
    let at = sums.partition_point(|sum| sum.flag < flag);
    if sums.get(at).is_none_or(|sum| sum.flag != flag) {
        sums.insert(at, Sum { flag, behind: 0, here: 0 });
    }
    &mut sums[at]
}

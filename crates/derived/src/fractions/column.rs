//! Adds up the lengths of the rays of a column of cells, or of faces.
//!
//! Facets, some rows of columns -> for each cell, or each run of cells that are alike, the length of each flag.
//!
//! # Theory
//! The crossings of a ray stand in slots (`stages/crossings/places.rs`), in order. A change from flag to flag takes a length from the one, and adds it to the
//! other, in its cell and in all cells behind it: two numbers for each flag of a cell that has changes, whose order does not matter. What starts with all rays
//! is the flag outside: it has what the others leave.
//!
//! Cost: some nanoseconds a crossing, and for each flag of a cell that has changes.

use std::ops::Range;

use super::refined::{Along, PLACE_BITS, Refined, WHOLE, place_among};
use hexcast_core::input::job::Rule;
use hexcast_core::stages::crossings::places::{Places, event_of, place_of};
use hexcast_core::stages::inside::{Inside, Kind};
use hexcast_core::stages::lattice::{Lattice, lattice};

/// Rays whose crossings are held together, about: those of some columns of some rows.
const RAYS_AT_ONCE: u32 = 2048;

/// Gains that all cells of a column may have; of more flags or cells only those that change have some.
const GAINS_OF_ALL: usize = 1 << 16;

/// All columns of cells, or of faces.
pub(super) struct Columns<'a> {
    refined: Refined,
    lattice: Lattice,
    rule: Rule,
    kinds: &'a [Kind],
    /// All flags that cells may have, ascending.
    flags: Vec<u8>,
    /// The flag outside, as an index of these.
    outside: usize,
    /// Of a single geometry under `parity` both flags, in any order: every crossing changes from the one to the other.
    of_one: Option<[usize; 2]>,
}

/// Lengths of a flag: in all cells behind the last change, and what the cell at hand has besides.
#[derive(Clone, Copy)]
pub(super) struct Sum {
    pub(super) flag: u8,
    behind: i64,
    here: i64,
}

/// In how many parts a cell is divided where it is measured exactly.
pub(crate) const EXACT_PARTS: u64 = 1 << 56;

/// In how many parts a cell is divided by so many rays along each axis; by none where it is measured exactly.
#[doc(hidden)]
pub fn parts_of_cell(rays: u32) -> u64 {
    if rays == 0 {
        return EXACT_PARTS;
    }
    WHOLE as u64 * u64::from(rays * rays)
}

impl Sum {
    /// In the cell at hand.
    pub(super) fn length(&self) -> i64 {
        self.behind + self.here
    }
}

/// Memory that a core uses for row after row.
#[derive(Default)]
pub(super) struct Memory {
    places: Places,
    changes: Changes,
    sums: Vec<Sum>,
}

/// What a flag gains in a cell, and in all cells behind it.
#[derive(Clone, Copy, Default)]
struct Gain {
    here: i64,
    behind: i64,
}

/// Where the rays of a column change from flag to flag.
#[derive(Default)]
struct Changes {
    /// A gain for each flag: of each cell, where these are not too many; else of each cell that has changes, in the order of first changes.
    gains: Vec<Gain>,
    /// Where the gains of each cell begin; else of each that has changes.
    first: Vec<u32>,
    is_of_all: bool,
    /// A bit for each cell: whether it has changes.
    cells: Vec<u64>,
    n_flags: usize,
}

impl<'a> Columns<'a> {
    /// Sorts the facets by some columns of each row.
    pub(super) fn new(refined: Refined, (rule, kinds): (Rule, &'a [Kind])) -> Columns<'a> {
        let [across, down] = refined.per_column;
        let columns = (RAYS_AT_ONCE / (across * down)).max(1);
        let bin = [refined.rays.counts[0].min(across * columns), down];
        let all = 0..Lattice::n_rows(&refined.rays, bin);
        let lattice = lattice(&refined.frame, &refined.rays, bin, all);
        let flag_of_rank = &refined.frame.ranks.flag_of_rank;
        let mut flags: Vec<u8> = flag_of_rank.iter().copied().chain([0]).collect();
        flags.sort_unstable();
        flags.dedup();
        let outside = index_of(&flags, Inside::new(kinds, rule).flag(flag_of_rank));
        let of_one = match flag_of_rank[..] {
            [flag] if rule == Rule::Parity && flag != 0 => Some([0, index_of(&flags, flag)]),
            _ => None,
        };
        Columns { refined, lattice, rule, kinds, flags, outside, of_one }
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
    /// ascending, of which some may be 0.
    pub(super) fn rows(
        &self,
        rows: Range<u32>,
        memory: &mut Memory,
        mut each: impl FnMut([u32; 2], Range<u32>, &[Sum]),
    ) {
        let Refined { frame, rays, per_column, .. } = &self.refined;
        let [across, down] = *per_column;
        let Memory { places, changes, sums } = memory;
        changes.begin(self.refined.n, self.flags.len());
        let mut inside = Inside::new(self.kinds, self.rule);
        let along = self.refined.along();
        for row in rows {
            let of_rays = row * down..(row + 1) * down;
            for bin in 0..self.lattice.n_across {
                let start = bin * self.lattice.bin[0];
                let window = [start..(start + self.lattice.bin[0]).min(rays.counts[0]), of_rays.clone()];
                let facets = self.lattice.bin_facets(bin, row);
                match &along {
                    Along::Equal(cells) => places.cast((frame, rays), facets, &window, |at| cells.place(at)),
                    Along::Lines(lines) => places.cast((frame, rays), facets, &window, |at| place_among(lines, at)),
                }
                let columns = window[0].start / across..window[0].end / across;
                for column in columns.clone() {
                    let first = (column - columns.start) * across;
                    for of in 0..across * down {
                        let ray = first + of / across * window[0].len() as u32 + of % across;
                        self.add_changes(places, ray, &mut inside, changes);
                    }
                    self.sum(changes, sums, |cells, sums| each([column, row], cells, sums));
                    changes.clear();
                }
            }
        }
    }

    /// Adds the changes of a ray.
    #[inline(always)]
    fn add_changes(&self, places: &mut Places, ray: u32, inside: &mut Inside, changes: &mut Changes) {
        let flag_of_rank = &self.refined.frame.ranks.flag_of_rank;
        let beyond = u64::from(self.refined.n) << PLACE_BITS;
        let crossings = places.of_ray(ray).take_while(|&crossing| place_of(crossing) < beyond);
        if let Some(both) = self.of_one {
            // of these two flags one is that outside, which the other is taken from
            let other = both[0] + both[1] - self.outside;
            let mut loses = 0;
            for crossing in crossings {
                changes.gain(place_of(crossing), other, loses);
                loses = !loses;
            }
            return;
        }
        let mut at = self.outside;
        inside.begin(self.kinds);
        for crossing in crossings {
            inside.pass(event_of(crossing), false);
            let flag = inside.flag(flag_of_rank);
            if flag != self.flags[at] {
                let next = index_of(&self.flags, flag);
                changes.add(place_of(crossing), [at, next], self.outside);
                at = next;
            }
        }
    }

    /// Walks along a column.
    #[inline(always)]
    fn sum(&self, changes: &mut Changes, sums: &mut Vec<Sum>, mut each: impl FnMut(Range<u32>, &[Sum])) {
        let n_cells = self.refined.n;
        sums.clear();
        sums.extend(self.flags.iter().map(|&flag| Sum { flag, behind: 0, here: 0 }));
        sums[self.outside].behind = self.whole();
        let mut start = 0;
        for word in 0..changes.cells.len() as u32 {
            let mut left = changes.cells[word as usize];
            while left != 0 {
                let cell = 64 * word + left.trailing_zeros();
                left &= left - 1;
                // without changes all cells up to the next are alike
                if start < cell {
                    each(start..cell, sums);
                }
                let (mut here, mut behind) = (0, 0);
                for (sum, gain) in sums.iter_mut().zip(changes.of_cell(cell)) {
                    sum.behind += gain.behind;
                    sum.here = gain.here;
                    (here, behind) = (here + gain.here, behind + gain.behind);
                }
                changes.clear_cell(cell);
                let of_outside = &mut sums[self.outside];
                (of_outside.here, of_outside.behind) = (-here, of_outside.behind - behind);
                each(cell..cell + 1, sums);
                sums.iter_mut().for_each(|sum| sum.here = 0);
                start = cell + 1;
            }
        }
        if start < n_cells {
            each(start..n_cells, sums);
        }
    }
}

impl Changes {
    fn begin(&mut self, n_cells: u32, n_flags: usize) {
        let n = n_cells as usize;
        self.is_of_all = n * n_flags <= GAINS_OF_ALL;
        self.n_flags = n_flags;
        self.gains.clear();
        self.gains.resize(if self.is_of_all { n * n_flags } else { 0 }, Gain::default());
        self.first.clear();
        self.first.extend((0..n_cells).map(|cell| if self.is_of_all { cell * n_flags as u32 } else { 0 }));
        self.cells.clear();
        self.cells.resize(n.div_ceil(64), 0);
    }

    /// Adds a change at `cell << PLACE_BITS | place in the cell` from a flag to another; that outside has what the others leave.
    fn add(&mut self, at: u64, [from, to]: [usize; 2], outside: usize) {
        for (flag, loses) in [(from, !0), (to, 0)] {
            if flag != outside {
                self.gain(at, flag, loses);
            }
        }
    }

    /// Adds what a flag gains by a change, or loses by it where that has all bits, not none.
    #[inline(always)]
    fn gain(&mut self, at: u64, flag: usize, loses: i64) {
        let (cell, place) = ((at >> PLACE_BITS) as usize, (at & ((1 << PLACE_BITS) - 1)) as i64);
        let (of_cells, bit) = (&mut self.cells[cell / 64], 1 << (cell % 64));
        if !self.is_of_all && *of_cells & bit == 0 {
            self.first[cell] = self.gains.len() as u32;
            self.gains.resize(self.gains.len() + self.n_flags, Gain::default());
        }
        *of_cells |= bit;
        let gain = &mut self.gains[self.first[cell] as usize + flag];
        let signed = |length: i64| (length ^ loses) - loses;
        gain.here -= signed(place);
        gain.behind += signed(WHOLE);
    }

    /// The gains of all flags in a cell that has changes.
    fn of_cell(&self, cell: u32) -> &[Gain] {
        &self.gains[self.first[cell as usize] as usize..][..self.n_flags]
    }

    /// Forgets the gains of a cell.
    fn clear_cell(&mut self, cell: u32) {
        self.gains[self.first[cell as usize] as usize..][..self.n_flags].fill(Gain::default());
    }

    /// Forgets which cells have gains, once these are forgotten.
    fn clear(&mut self) {
        if !self.is_of_all {
            self.gains.clear();
        }
        self.cells.fill(0);
    }
}

/// Which of some flags one of them is.
fn index_of(flags: &[u8], flag: u8) -> usize {
    flags.partition_point(|&of| of < flag)
}

//! Adds up the lengths of the rays of a column of cells.

use super::fraction::Fraction;
use super::refined::{PLACE_BITS, Refined, WHOLE};
use crate::crossings::places::{EVENT_BITS, places};
use crate::inside::{Inside, Kind};
use crate::job::Rule;
use crate::lattice::Lattice;
use crate::lines::Lines;

pub(super) struct Columns<'a> {
    pub(super) refined: &'a Refined,
    pub(super) lines: &'a Lines,
    pub(super) rule: Rule,
    pub(super) kinds: &'a [Kind],
}

/// Lengths of a flag: in all cells behind the last change, and what the cell at hand has besides.
struct Sum {
    flag: u8,
    behind: i64,
    here: i64,
}

/// Where the rays of a column change from flag to flag, ray after ray: `cell << 41 | place in the cell << 16 | from << 8 | to`.
#[derive(Default)]
struct Changes {
    words: Vec<u64>,
    /// Of each ray the next change in `words`. The last of a ray is [`LAST`].
    next: Vec<u32>,
}

/// Beyond all changes of a ray.
const LAST: u64 = u64::MAX;
/// Lowest bit of the cell of a change.
const CELL: u32 = PLACE_BITS + 16;

impl Columns<'_> {
    /// The fractions of the cells of some rows, and the volume of each flag there.
    pub(super) fn of_rows(&self, lattice: &Lattice, row: u32) -> (Vec<Fraction>, Vec<f64>) {
        let (rays, frame) = (self.refined.rays(), &self.refined.frame);
        let (m, n_across) = (self.refined.m as usize, rays.counts[0] as usize);
        let (offsets, mut crossings) = places((frame, &rays), lattice, row, |at| self.refined.place(at));
        let [_, ny, _] = self.lines.dims();
        let first_row = row * lattice.bin[1] / self.refined.m;
        let n_rows = (offsets.len() - 1) / n_across / m;
        let (mut found, mut volumes) = (Vec::new(), vec![0.0; 256]);
        let mut inside = Inside::new(self.kinds, self.rule);
        let outside = inside.flag(&frame.ranks.flag_of_rank);
        let (mut changes, mut sums) = (Changes::default(), Vec::new());
        for k in 0..n_rows {
            for j in 0..ny {
                changes.words.clear();
                changes.next.clear();
                for ray in (0..m * m).map(|of| (k * m + of / m) * n_across + j as usize * m + of % m) {
                    let of_ray = offsets[ray] as usize..offsets[ray + 1] as usize;
                    self.changes(&mut crossings[of_ray], &mut inside, &mut changes);
                }
                let z = first_row + k as u32;
                let area = self.lines.cell_size(1, j) * self.lines.cell_size(2, z);
                let column = Column { first: u64::from(j) + u64::from(ny) * u64::from(z), area, outside };
                self.sum(&column, &mut changes, &mut sums, (&mut found, &mut volumes));
            }
        }
        found.shrink_to_fit();
        (found, volumes)
    }

    /// The changes of a ray.
    fn changes(&self, crossings: &mut [u64], inside: &mut Inside, changes: &mut Changes) {
        if crossings.is_empty() {
            return;
        }
        crossings.sort_unstable();
        changes.next.push(changes.words.len() as u32);
        inside.begin(self.kinds);
        let flag_of_rank = &self.refined.frame.ranks.flag_of_rank;
        let beyond = u64::from(self.lines.dims()[0]) << PLACE_BITS;
        let mut flag = inside.flag(flag_of_rank);
        for crossing in crossings {
            let place = *crossing >> EVENT_BITS;
            if place >= beyond {
                break;
            }
            inside.pass((*crossing & ((1 << EVENT_BITS) - 1)) as u32, false);
            let next = inside.flag(flag_of_rank);
            if next != flag {
                changes.words.push(place << 16 | u64::from(flag) << 8 | u64::from(next));
                flag = next;
            }
        }
        changes.words.push(LAST);
    }

    /// The fractions of the cells of a column, in order, and the volumes of its flags.
    fn sum(
        &self,
        column: &Column,
        changes: &mut Changes,
        sums: &mut Vec<Sum>,
        (found, volumes): (&mut Vec<Fraction>, &mut [f64]),
    ) {
        let nx = self.lines.dims()[0];
        let whole = WHOLE * i64::from(self.refined.m * self.refined.m);
        // a power of two
        let of_whole = 1.0 / whole as f64;
        sums.clear();
        sums.push(Sum { flag: column.outside, behind: whole, here: 0 });
        let mut x = 0;
        while x < nx {
            let n = changes.take(x, |from, to, place| {
                for (flag, sign) in [(from, -1), (to, 1)] {
                    let sum = sum_of(sums, flag);
                    (sum.here, sum.behind) = (sum.here - sign * place, sum.behind + sign * WHOLE);
                }
            });
            // without changes all cells up to the next are alike
            let end = if n > 0 { x + 1 } else { changes.first().min(nx) };
            let extent = self.lines.line(0, end) - self.lines.line(0, x);
            let fraction = |sum: &Sum| (sum.behind + sum.here) as f64 * of_whole;
            for sum in sums.iter() {
                volumes[usize::from(sum.flag)] += fraction(sum) * extent * column.area;
            }
            if sums.iter().all(|sum| sum.behind + sum.here < whole) {
                for x in x..end {
                    let cell = u64::from(x) + u64::from(nx) * column.first;
                    let some = sums.iter().filter(|sum| sum.behind + sum.here > 0);
                    found.extend(some.map(|sum| Fraction { cell, fraction: fraction(sum) as f32, flag: sum.flag }));
                }
            }
            if n > 0 {
                sums.retain(|sum| sum.behind > 0);
                sums.iter_mut().for_each(|sum| sum.here = 0);
            }
            x = end;
        }
    }
}

impl Changes {
    /// Hands over the changes in a cell, which is the first that has any or before it; returns their number.
    fn take(&mut self, cell: u32, mut each: impl FnMut(u8, u8, i64)) -> usize {
        let mut n = 0;
        for next in &mut self.next {
            loop {
                let word = self.words[*next as usize];
                if word >> CELL != u64::from(cell) {
                    break;
                }
                each((word >> 8) as u8, word as u8, (word >> 16 & ((1 << PLACE_BITS) - 1)) as i64);
                *next += 1;
                n += 1;
            }
        }
        n
    }

    /// The first cell with changes; beyond all cells where there are no more.
    fn first(&self) -> u32 {
        let first = self.next.iter().map(|&next| self.words[next as usize]).min();
        (first.unwrap_or(LAST) >> CELL) as u32
    }
}

/// A column of cells along x: its row, the area across it, and the flag before the first crossing.
struct Column {
    first: u64,
    area: f64,
    outside: u8,
}

/// The sum of a flag, in the order of flags.
fn sum_of(sums: &mut Vec<Sum>, flag: u8) -> &mut Sum {
    let at = sums.partition_point(|sum| sum.flag < flag);
    if sums.get(at).is_none_or(|sum| sum.flag != flag) {
        sums.insert(at, Sum { flag, behind: 0, here: 0 });
    }
    &mut sums[at]
}

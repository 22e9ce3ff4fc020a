//! Adds up the lengths of the rays of a column of cells.

use super::fraction::Fraction;
use super::refined::Refined;
use crate::crossings::places::{Place, places};
use crate::inside::{Inside, Kind};
use crate::job::Rule;
use crate::lattice::Lattice;
use crate::lines::Lines;

/// Bits of a length within a cell.
const BITS: u32 = 24;
const WHOLE: i64 = 1 << BITS;

pub(super) struct Columns<'a> {
    pub(super) refined: &'a Refined,
    pub(super) lines: &'a Lines,
    pub(super) rule: Rule,
    pub(super) kinds: &'a [Kind],
}

/// A ray changes from flag to flag in a cell, so many lengths before its end.
#[derive(Clone, Copy)]
struct Change {
    cell: u32,
    left: u32,
    from: u8,
    to: u8,
}

/// Lengths of a flag: in all cells behind the last change, and what the cell at hand has besides.
struct Sum {
    flag: u8,
    behind: i64,
    here: i64,
}

impl Columns<'_> {
    /// The fractions of the cells of some rows, and the volume of each flag there.
    pub(super) fn of_rows(&self, lattice: &Lattice, row: u32) -> (Vec<Fraction>, Vec<f64>) {
        let rays = self.refined.rays();
        let (m, n_across) = (self.refined.m as usize, rays.counts[0] as usize);
        let (offsets, mut crossings) = places(&self.refined.frame, &rays, lattice, row);
        let [_, ny, _] = self.lines.dims();
        let first_row = row * lattice.bin[1] / self.refined.m;
        let n_rows = (offsets.len() - 1) / n_across / m;
        let (mut found, mut volumes) = (Vec::new(), vec![0.0; 256]);
        let mut inside = Inside::new(self.kinds, self.rule);
        let outside = inside.flag(&self.refined.frame.ranks.flag_of_rank);
        let mut changes: Vec<Change> = Vec::new();
        for k in 0..n_rows {
            for j in 0..ny {
                changes.clear();
                for ray in (0..m * m).map(|of| (k * m + of / m) * n_across + j as usize * m + of % m) {
                    let of_ray = offsets[ray] as usize..offsets[ray + 1] as usize;
                    self.changes(&mut crossings[of_ray], &mut inside, &mut changes);
                }
                let z = first_row + k as u32;
                let area = self.lines.cell_size(1, j) * self.lines.cell_size(2, z);
                let column = Column { first: u64::from(j) + u64::from(ny) * u64::from(z), area, outside };
                self.sum(&column, &mut changes, &mut found, &mut volumes);
            }
        }
        (found, volumes)
    }

    /// The changes of a ray.
    fn changes(&self, crossings: &mut [Place], inside: &mut Inside, changes: &mut Vec<Change>) {
        if crossings.is_empty() {
            return;
        }
        crossings.sort_unstable_by(|one, other| one.at.total_cmp(&other.at));
        inside.begin(self.kinds);
        let flag_of_rank = &self.refined.frame.ranks.flag_of_rank;
        let mut flag = inside.flag(flag_of_rank);
        for crossing in crossings {
            inside.pass(crossing.event, false);
            let next = inside.flag(flag_of_rank);
            if next != flag {
                let Some((cell, fraction)) = self.refined.cell(crossing.at) else { return };
                let left = ((1.0 - fraction) * WHOLE as f64).round() as u32;
                changes.push(Change { cell, left, from: flag, to: next });
                flag = next;
            }
        }
    }

    /// The fractions of the cells of a column, in order, and the volumes of its flags.
    fn sum(&self, column: &Column, changes: &mut [Change], found: &mut Vec<Fraction>, volumes: &mut [f64]) {
        let nx = self.lines.dims()[0];
        let whole = WHOLE * i64::from(self.refined.m * self.refined.m);
        let mut sums = vec![Sum { flag: column.outside, behind: whole, here: 0 }];
        changes.sort_unstable_by_key(|change| change.cell);
        let mut rest = &changes[..];
        let mut x = 0;
        while x < nx {
            let n = rest.iter().take_while(|change| change.cell == x).count();
            let (here, after) = rest.split_at(n);
            rest = after;
            for change in here {
                let left = i64::from(change.left);
                for (flag, sign) in [(change.from, -1), (change.to, 1)] {
                    let sum = sum_of(&mut sums, flag);
                    (sum.here, sum.behind) = (sum.here + sign * (left - WHOLE), sum.behind + sign * WHOLE);
                }
            }
            // without changes all cells up to the next are alike
            let end = if n > 0 { x + 1 } else { rest.first().map_or(nx, |change| change.cell) };
            let extent = self.lines.line(0, end) - self.lines.line(0, x);
            let fraction = |sum: &Sum| (sum.behind + sum.here) as f64 / whole as f64;
            for sum in &sums {
                volumes[usize::from(sum.flag)] += fraction(sum) * extent * column.area;
            }
            if sums.iter().all(|sum| sum.behind + sum.here < whole) {
                for x in x..end {
                    let cell = u64::from(x) + u64::from(nx) * column.first;
                    let some = sums.iter().filter(|sum| sum.behind + sum.here > 0);
                    found.extend(some.map(|sum| Fraction { cell, fraction: fraction(sum) as f32, flag: sum.flag }));
                }
            }
            sums.retain(|sum| sum.behind > 0);
            sums.iter_mut().for_each(|sum| sum.here = 0);
            x = end;
        }
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

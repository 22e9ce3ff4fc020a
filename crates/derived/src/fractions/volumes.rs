//! Volumes of flags, added up as whole numbers of parts of cells.

use hexcast_core::grid::totals::{Ruler, Total};

/// Volumes of flags: where a cell is a unit, short sums.
pub(crate) enum Volumes {
    Cells(Vec<u128>),
    Units(Vec<Total>),
}

impl Volumes {
    pub(crate) fn new(ruler: &Ruler) -> Volumes {
        match ruler.counts_cells() {
            true => Volumes::Cells(vec![0; 256]),
            false => Volumes::Units(vec![Total::default(); 256]),
        }
    }

    /// Adds the parts that flags have of each of `n` cells of a row, from a cell on: fewer than 2^57 of each.
    #[inline]
    pub(crate) fn add(&mut self, ruler: &Ruler, cell: [u32; 3], n: u32, of_flags: impl Iterator<Item = (u8, u64)>) {
        match self {
            Volumes::Cells(volumes) => {
                of_flags.for_each(|(flag, parts)| volumes[usize::from(flag)] += u128::from(parts) * u128::from(n));
            }
            Volumes::Units(volumes) => {
                let volume = ruler.cells([cell, [cell[0] + n, cell[1] + 1, cell[2] + 1]]);
                of_flags.for_each(|(flag, parts)| volumes[usize::from(flag)].add(volume.times(parts)));
            }
        }
    }

    pub(crate) fn totals(self) -> Vec<Total> {
        match self {
            Volumes::Cells(volumes) => volumes.into_iter().map(Total::from).collect(),
            Volumes::Units(volumes) => volumes,
        }
    }
}

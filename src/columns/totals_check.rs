//! The totals of a column file from outside against its pieces.
//!
//! Opening a file reads its totals and no piece. Each piece is counted when it is read for the first time; once all were read,
//! the sums must be the totals. So a file whose end is wrong, with a right checksum, is refused by whoever reads it whole.
//! Cost: a pass over the runs of each piece; a bit of memory a piece.

use std::sync::{Mutex, PoisonError};

use super::file::corrupt;
use super::file::end::Totals;
use super::packed_band::PackedBand;
use crate::error::Result;

/// Totals, and the pieces that were counted so far.
pub(crate) struct TotalsCheck {
    expected: Totals,
    counted: Mutex<Counted>,
}

struct Counted {
    /// A bit a piece.
    pieces: Vec<u64>,
    n_missing: usize,
    sums: Totals,
}

impl TotalsCheck {
    /// Expects totals of so many pieces.
    pub(crate) fn new(expected: Totals, n_pieces: usize) -> TotalsCheck {
        let counted = Counted { pieces: vec![0; n_pieces.div_ceil(64)], n_missing: n_pieces, sums: Totals::of(&[], 0) };
        TotalsCheck { expected, counted: Mutex::new(counted) }
    }

    /// Counts a piece, of rays of `depth` cells, unless it was counted before.
    ///
    /// # Errors
    /// `columns-corrupt` where all pieces are counted and the totals are other ones.
    pub(crate) fn add(&self, piece: usize, band: &PackedBand, depth: u32) -> Result<()> {
        let (word, bit) = (piece / 64, 1 << (piece % 64));
        let is_counted = |counted: &Counted| counted.pieces[word] & bit != 0;
        if !is_counted(&self.locked()) {
            let cells = band.cells_per_flag(depth);
            let mut counted = self.locked();
            // another thread may have been faster
            if !is_counted(&counted) {
                counted.pieces[word] |= bit;
                counted.n_missing -= 1;
                counted.sums.add_counts(band);
                counted.sums.cells.iter_mut().zip(cells).for_each(|(sum, cells)| *sum += cells);
            }
        }
        let counted = self.locked();
        if counted.n_missing > 0 { Ok(()) } else { self.compare(&counted.sums) }
    }

    fn locked(&self) -> std::sync::MutexGuard<'_, Counted> {
        self.counted.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn compare(&self, found: &Totals) -> Result<()> {
        let counts = |totals: &Totals| [totals.n_runs, totals.odd_rays, totals.n_crossings];
        let names = ["runs", "odd rays", "crossings"].map(String::from);
        let totals = names.into_iter().zip(counts(&self.expected).into_iter().zip(counts(found)));
        // cells of flag 0 are not part of the totals
        let cells =
            (1..256).map(|flag| (format!("cells of flag {flag}"), (self.expected.cells[flag], found.cells[flag])));
        match totals.chain(cells).find(|(_, (expected, found))| expected != found) {
            None => Ok(()),
            Some((name, (expected, found))) => {
                Err(corrupt(format!("the end says {expected} {name}, and the pieces have {found}")))
            }
        }
    }
}

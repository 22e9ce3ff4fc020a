//! The totals of a column file from outside against its pieces.
//!
//! Opening a file reads its totals and no piece. Each piece is counted when it is read for the first time; once all were read,
//! the sums must be the totals. So a file whose end is wrong, with a right checksum, is refused by whoever reads it whole.
//! Cost: a pass over the runs of each piece; a bit of memory a piece.

use std::sync::{Mutex, PoisonError};

use super::file::corrupt;
use super::file::end::Totals;
use super::packed_band::PackedBand;
use crate::base::error::Result;

/// Totals, and the pieces that were counted so far.
#[doc(hidden)]
pub struct TotalsCheck {
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
    #[doc(hidden)]
    pub fn new(expected: Totals, n_pieces: usize) -> TotalsCheck {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cells::columns::{Band, run};

    const DEPTH: u32 = 10;

    /// A piece of one ray: cells 2 to 4 have flag 1, with two crossings.
    fn piece(ray: u64) -> PackedBand {
        let runs = vec![run(2, 1), run(5, 0)];
        PackedBand::new(Band { first_ray: ray, ends: vec![2], runs, odd_rays: 1, n_crossings: 2 })
    }

    #[test]
    fn totals_are_compared_once_every_piece_was_counted_and_each_is_counted_once() {
        // more pieces than a word of bits has
        const N: usize = 130;
        let right = || {
            let mut cells = Box::new([0; 256]);
            cells[1] = 3 * N as u64;
            Totals { n_runs: 2 * N as u64, odd_rays: N as u64, n_crossings: 2 * N as u64, cells }
        };
        type Change = fn(&mut Totals);
        let wrong: [(&str, Change); 6] = [
            ("", |_| ()),
            ("261 runs, and the pieces have 260", |totals| totals.n_runs += 1),
            ("129 odd rays, and the pieces have 130", |totals| totals.odd_rays -= 1),
            ("0 crossings, and the pieces have 260", |totals| totals.n_crossings = 0),
            ("391 cells of flag 1, and the pieces have 390", |totals| totals.cells[1] += 1),
            ("5 cells of flag 255, and the pieces have 0", |totals| totals.cells[255] = 5),
        ];
        for (sentence, change) in wrong {
            let mut totals = right();
            change(&mut totals);
            let check = TotalsCheck::new(totals, N);
            // out of order, and all but the last twice
            for number in (1..N).rev().chain(1..N) {
                check.add(number, &piece(number as u64), DEPTH).unwrap();
            }
            for _ in 0..2 {
                let last = check.add(0, &piece(0), DEPTH);
                assert_eq!(last.is_ok(), sentence.is_empty());
                if let Err(error) = last {
                    assert!(error.code() == "columns-corrupt" && error.to_string().contains(sentence), "{error}");
                }
            }
        }
    }
}

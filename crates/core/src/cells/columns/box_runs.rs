//! The runs of the rays through a box of cells by themselves: what the kernel `expand` makes flags of on another device.
//!
//! Columns, a box -> runs cut to the box and counted from its first cell.
//! Cost: O(rays and runs of the box) time; 4 bytes a ray and 4 a run.

use std::ops::Range;

use super::{Columns, run, run_cell, run_flag, spans};
use crate::base::error::{Error, Result};

/// Runs of the rays through a box of cells.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BoxRuns {
    /// First run of ray `i + n_i * j` over the axes across, counted from the first ray of the box; then the number of runs.
    pub offsets: Vec<u32>,
    /// Packed runs, ray after ray; cells are counted from the first of the box. Cells before the first run of a ray are background.
    pub runs: Vec<u32>,
}

impl Columns {
    /// Cuts the runs to a box of cells.
    ///
    /// # Errors
    /// `io` where the columns are in a store that fails; `memory` where the box has 2^32 runs.
    ///
    /// # Panics
    /// If the box reaches past the columns: a bug of the caller.
    #[doc(hidden)]
    pub fn runs_of_box(&self, cells: &[Range<u32>; 3]) -> Result<BoxRuns> {
        let along = &cells[self.rays.axis];
        let [across_i, across_j] = self.rays.across.map(|axis| cells[axis].clone());
        let mut found = BoxRuns { offsets: vec![0], runs: Vec::new() };
        if along.is_empty() {
            found.offsets.resize(across_i.len() * across_j.len() + 1, 0);
            return Ok(found);
        }
        for j in across_j {
            let first = u64::from(across_i.start) + u64::from(self.rays.counts[0]) * u64::from(j);
            self.for_rays(first..first + across_i.len() as u64, |runs| {
                spans(runs, along, |start, _, flag| {
                    if flag != 0 || start > along.start {
                        found.runs.push(run(start - along.start, flag));
                    }
                });
                found.offsets.push(found.runs.len() as u32);
            })?;
            if found.runs.len() > u32::MAX as usize {
                return Err(Error::new("memory", "a box has more than 4294967295 runs", "take a smaller one"));
            }
        }
        Ok(found)
    }
}

impl Columns {
    /// Whether a box has a cell with a flag.
    ///
    /// # Errors
    /// `io` where the columns are in a store that fails.
    #[doc(hidden)]
    pub fn has_flags(&self, cells: &[Range<u32>; 3]) -> Result<bool> {
        let along = &cells[self.rays.axis];
        let [across_i, across_j] = self.rays.across.map(|axis| cells[axis].clone());
        let mut has_flags = false;
        for j in across_j.take_while(|_| !along.is_empty()) {
            let first = u64::from(across_i.start) + u64::from(self.rays.counts[0]) * u64::from(j);
            self.for_rays(first..first + across_i.len() as u64, |runs| {
                has_flags = has_flags || {
                    let begun = runs.partition_point(|&run| run_cell(run) <= along.start);
                    let within = runs[begun.saturating_sub(1)..].iter().take_while(|&&run| run_cell(run) < along.end);
                    within.into_iter().any(|&run| run_flag(run) != 0)
                };
            })?;
            if has_flags {
                break;
            }
        }
        Ok(has_flags)
    }
}

#[cfg(test)]
mod tests {
    use super::super::flag_at;
    use crate::testing::{pattern_columns, pattern_flag};

    #[test]
    fn runs_of_a_box_have_its_flags_counted_from_its_first_cell() {
        for axis in 0..3 {
            let columns = pattern_columns(axis, [9, 5, 7], 3);
            for cells in [[0..9, 0..5, 0..7], [2..8, 1..4, 3..4], [4..5, 0..5, 2..7], [3..3, 1..2, 0..7]] {
                let found = columns.runs_of_box(&cells).unwrap();
                assert_eq!(columns.has_flags(&cells).unwrap(), found.runs.iter().any(|run| run & 0xff != 0));
                let [across_i, across_j] = columns.rays.across.map(|axis| cells[axis].clone());
                assert_eq!(found.offsets.len(), across_i.len() * across_j.len() + 1);
                assert_eq!(found.offsets[found.offsets.len() - 1] as usize, found.runs.len());
                let rays = across_j.flat_map(|j| across_i.clone().map(move |i| [i, j]));
                for (index, [i, j]) in rays.enumerate() {
                    let runs = &found.runs[found.offsets[index] as usize..found.offsets[index + 1] as usize];
                    assert!(runs.windows(2).all(|two| two[0] >> 8 < two[1] >> 8), "{runs:?}");
                    assert!(runs.first().is_none_or(|first| first & 0xff != 0), "{runs:?}");
                    for along in cells[axis].clone() {
                        let mut cell = [along; 3];
                        (cell[columns.rays.across[0]], cell[columns.rays.across[1]]) = (i, j);
                        let expected = pattern_flag(cell, 3);
                        assert_eq!(
                            flag_at(runs, along - cells[axis].start),
                            expected,
                            "{cells:?} along {axis}: {cell:?}"
                        );
                    }
                }
            }
        }
    }
}

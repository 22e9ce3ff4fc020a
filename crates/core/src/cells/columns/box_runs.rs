//! The runs of the rays through a box of cells by themselves: what the kernel `expand` makes flags of on another device.
//!
//! Columns, a box -> runs cut to the box and counted from its first cell.
//! Cost: O(rays and runs of the box) time; 4 bytes a ray and 4 a run.

use std::ops::Range;

use super::{Columns, run, spans};
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

/// What is known of the flags of a part while its rays come one by one.
#[derive(Clone, Copy, PartialEq)]
enum Only {
    Unknown,
    One(u8),
    Several,
}

impl Only {
    fn and(&mut self, flag: u8) {
        match *self {
            Only::Unknown => *self = Only::One(flag),
            Only::One(one) if one != flag => *self = Only::Several,
            _ => {}
        }
    }
}

impl Columns {
    /// Divides a box along x, every `step` cells from its first, and finds the parts of which all cells have one flag; None where they have several.
    ///
    /// Cost: O(rays and runs of the box), and a comparison for each ray and part.
    ///
    /// # Errors
    /// `io` where the columns are in a store that fails.
    ///
    /// # Panics
    /// If the box reaches past the columns or is empty: a bug of the caller.
    #[doc(hidden)]
    pub fn only_flags(&self, cells: &[Range<u32>; 3], step: u32) -> Result<Vec<Option<u8>>> {
        let (first, along) = (cells[0].start, &cells[self.rays.axis]);
        let mut parts = vec![Only::Unknown; cells[0].len().div_ceil(step as usize)];
        let [across_i, across_j] = self.rays.across.map(|axis| cells[axis].clone());
        for j in across_j {
            if parts.iter().all(|part| *part == Only::Several) {
                break;
            }
            let start = u64::from(across_i.start) + u64::from(self.rays.counts[0]) * u64::from(j);
            let mut i = 0;
            self.for_rays(start..start + across_i.len() as u64, |runs| {
                if self.rays.axis == 0 {
                    spans(runs, along, |start, end, flag| {
                        let touched = (start - first) / step..(end - first).div_ceil(step);
                        parts[touched.start as usize..touched.end as usize].iter_mut().for_each(|part| part.and(flag));
                    });
                } else {
                    let part = &mut parts[(i / step) as usize];
                    spans(runs, along, |_, _, flag| part.and(flag));
                    i += 1;
                }
            })?;
        }
        let one = |part| if let Only::One(flag) = part { Some(flag) } else { None };
        Ok(parts.into_iter().map(one).collect())
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::super::flag_at;
    use super::*;
    use crate::grid::rays::Rays;
    use crate::testing::{band_of, pattern_columns, pattern_flag};

    #[test]
    fn runs_of_a_box_have_its_flags_counted_from_its_first_cell() {
        for axis in 0..3 {
            let columns = pattern_columns(axis, [9, 5, 7], 3);
            for cells in [[0..9, 0..5, 0..7], [2..8, 1..4, 3..4], [4..5, 0..5, 2..7], [3..3, 1..2, 0..7]] {
                let found = columns.runs_of_box(&cells).unwrap();
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
    #[test]
    fn parts_have_one_flag_where_all_their_cells_have_it() {
        let dims = [23, 12, 10];
        // blocks of one flag, larger than parts and not along their ends
        let flag =
            |[x, y, z]: [u32; 3]| if y == 7 && z == 3 && x == 20 { 9 } else { (x / 9 + y / 7 + z / 6) as u8 % 3 };
        for axis in 0..3 {
            let rays = Rays::new(axis, dims);
            let columns = Columns::new(rays, vec![band_of(&rays, flag)]).unwrap();
            let mut n_of_one = 0;
            for cells in [[0..23, 0..12, 0..10], [2..20, 8..12, 7..10], [9..18, 0..7, 0..6], [0..23, 7..8, 0..6]] {
                for step in [1, 3, 4, 30] {
                    let found = columns.only_flags(&cells, step).unwrap();
                    let [x, y, z] = cells.clone();
                    let starts = x.clone().step_by(step as usize);
                    let expected = starts.map(|start| {
                        let x = start..(start + step).min(x.end);
                        let rows = z.clone().flat_map(|z| y.clone().map(move |y| [y, z]));
                        let all: BTreeSet<u8> =
                            rows.flat_map(|[y, z]| x.clone().map(move |x| [x, y, z])).map(flag).collect();
                        all.first().copied().filter(|_| all.len() == 1)
                    });
                    let expected: Vec<Option<u8>> = expected.collect();
                    assert_eq!(found, expected, "axis {axis}, {cells:?}, every {step}");
                    n_of_one += found.iter().flatten().count();
                }
            }
            assert!(n_of_one > 10);
        }
    }
}

//! A ray as its flagged stretches.

use std::ops::Range;

use crate::columns::{flag_at, run_cell, run_flag};

/// Walks the flagged stretches of a ray between `along`: `found(start, end, flag)`.
pub(super) fn stretches(runs: &[u32], along: &Range<u32>, mut found: impl FnMut(u32, u32, u8)) {
    let mut flag = flag_at(runs, along.start);
    let mut start = along.start;
    for &run in &runs[runs.partition_point(|&run| run_cell(run) <= along.start)..] {
        let cell = run_cell(run);
        if cell >= along.end {
            break;
        }
        if flag != 0 {
            found(start, cell, flag);
        }
        (start, flag) = (cell, run_flag(run));
    }
    if flag != 0 {
        found(start, along.end, flag);
    }
}

//! Runs, and bands of them as the backends return them.

use crate::base::sort::par_sort;
use std::ops::Range;

/// Packs a run.
pub fn run(cell: u32, flag: u8) -> u32 {
    cell << 8 | u32::from(flag)
}

/// First cell of a packed run.
pub fn run_cell(run: u32) -> u32 {
    run >> 8
}

/// Flag of a packed run.
pub fn run_flag(run: u32) -> u8 {
    (run & 0xff) as u8
}

/// Runs of consecutive rays.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Band {
    /// Index of the first ray.
    pub first_ray: u64,
    /// End in `runs` of the runs of each ray; one entry a ray.
    pub ends: Vec<u32>,
    /// Runs, ray after ray.
    pub runs: Vec<u32>,
    /// Rays that do not leave every geometry they enter: the mesh is not closed there.
    pub odd_rays: u64,
    /// Number of crossings of the rays.
    pub n_crossings: u64,
}

impl Band {
    /// Runs of a ray of this band, counted from its first.
    pub fn ray(&self, index: usize) -> &[u32] {
        let start = if index == 0 { 0 } else { self.ends[index - 1] };
        &self.runs[start as usize..self.ends[index] as usize]
    }
}

/// Consecutive cells of a ray.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct CellRun {
    /// Index of the ray.
    pub ray: u64,
    /// First cell.
    pub start: u32,
    /// The cell after the last.
    pub end: u32,
}

impl CellRun {
    /// Runs in any order, ascending; those that touch or have cells in common are one.
    #[doc(hidden)]
    pub fn united(mut runs: Vec<CellRun>) -> Vec<CellRun> {
        par_sort(&mut runs);
        runs.dedup_by(|next, last| {
            let touches = next.ray == last.ray && next.start <= last.end;
            if touches {
                last.end = last.end.max(next.end);
            }
            touches
        });
        runs
    }
}

/// Flag of a cell of a ray with the given runs.
pub fn flag_at(runs: &[u32], cell: u32) -> u8 {
    match runs.partition_point(|&run| run_cell(run) <= cell) {
        0 => 0,
        after => run_flag(runs[after - 1]),
    }
}

/// Calls `found(start, end, flag)` for every span of cells of one flag that a ray has in `along`, flag 0 included.
#[inline(always)]
#[doc(hidden)]
pub fn spans(runs: &[u32], along: &Range<u32>, mut found: impl FnMut(u32, u32, u8)) {
    let (mut start, mut flag) = (along.start, flag_at(runs, along.start));
    for &run in &runs[runs.partition_point(|&run| run_cell(run) <= along.start)..] {
        if run_cell(run) >= along.end {
            break;
        }
        found(start, run_cell(run), flag);
        (start, flag) = (run_cell(run), run_flag(run));
    }
    found(start, along.end, flag);
}

/// Calls `found` with every span of cells of a ray in which two lists of runs have different flags.
#[doc(hidden)]
pub fn for_differing(one: &[u32], other: &[u32], depth: u32, mut found: impl FnMut(Range<u32>, [u8; 2])) {
    let (mut lists, mut flags, mut at) = ([one, other], [0; 2], 0);
    while at < depth {
        let mut end = depth;
        for (runs, flag) in lists.iter_mut().zip(&mut flags) {
            while let [first, rest @ ..] = *runs
                && run_cell(*first) <= at
            {
                (*flag, *runs) = (run_flag(*first), rest);
            }
            end = end.min(runs.first().map_or(depth, |&next| run_cell(next)));
        }
        if flags[0] != flags[1] {
            found(at..end, flags);
        }
        at = end;
    }
}

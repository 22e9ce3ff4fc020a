//! The passage: the open cells of a box, as open runs.
//!
//! Columns, the flags that are open -> [`Passage`]. An open run is a maximal interval of open cells along a ray, whatever
//! their flags.
//!
//! Passage, k -> the passage of a cube that is k cells wider. A cube of w cells fits where all its cells are open,
//! and its place is a cell of a box of its own: place p stands for the cells p - w + 1 ..= p on every axis, so that the box
//! has w - 1 more cells an axis and the cube may hang over the mesh. Cells beyond the mesh are background: open if flag 0 is.
//! For k <= w a segment of w + k cells is the union of two segments of w, k apart. So the wider cube fits at p where
//! the narrower one is at p and k cells lower, on every axis: four rays are intersected, and the open runs lose k cells.
//!
//! Cost: 8 bytes an open run and 4 a ray; a pass over the runs on all cores.

use std::ops::Range;

use hexcast_core::base::control::Control;
use hexcast_core::base::error::{Error, Result};
use hexcast_core::base::parallel::*;
use hexcast_core::cells::columns::{Columns, spans};

/// Rays that one core takes at a time; whole rows, at least one.
const BLOCK_RAYS: u32 = 1 << 14;

/// A cell by its index on the first and the second axis across the rays and along them.
pub(crate) type Place = [u32; 3];

/// Consecutive open cells of a ray.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct OpenRun {
    pub(crate) start: u32,
    /// The cell after the last.
    pub(crate) end: u32,
}

/// Open runs of all rays of a box.
#[derive(Debug)]
pub(crate) struct Passage {
    /// Number of rays along the two axes across.
    pub(crate) counts: [u32; 2],
    /// Number of cells on a ray.
    pub(crate) depth: u32,
    /// Edge in cells of the cube that moves through it.
    pub(crate) width: u32,
    /// Whether the cells beyond the box are open.
    is_open_beyond: bool,
    /// Index in `runs` of the first open run of every ray, and the number of runs at the end.
    firsts: Vec<u32>,
    pub(crate) runs: Vec<OpenRun>,
}

/// Open runs of consecutive rays.
#[derive(Default)]
struct Block {
    /// End in `runs` of the runs of each ray.
    ends: Vec<u32>,
    runs: Vec<OpenRun>,
}

impl Passage {
    /// Takes the cells whose flags are open.
    ///
    /// # Errors
    /// `io` where the columns are in a store that fails; `memory` where there are more open runs than fit a 32-bit index;
    /// `cancelled`.
    pub(crate) fn new(columns: &Columns, is_open: &[bool; 256], control: &Control) -> Result<Passage> {
        let rays = columns.rays();
        let depth = rays.depth;
        let fill = |row: u32, block: &mut Block| {
            let first = u64::from(row) * u64::from(rays.counts[0]);
            columns.for_rays(first..first + u64::from(rays.counts[0]), |runs| {
                let start_of_ray = block.runs.len();
                spans(runs, &(0..depth), |start, end, flag| {
                    if !is_open[usize::from(flag)] {
                        return;
                    }
                    match block.runs[start_of_ray..].last_mut() {
                        Some(before) if before.end == start => before.end = end,
                        _ => block.runs.push(OpenRun { start, end }),
                    }
                });
                block.ends.push(block.runs.len() as u32);
            })
        };
        let empty =
            Passage { counts: rays.counts, depth, width: 1, is_open_beyond: is_open[0], firsts: vec![], runs: vec![] };
        empty.filled(fill, control)
    }

    /// Makes the passage of a cube that is `by` cells wider, at most twice as wide.
    ///
    /// # Errors
    /// `memory` and `cancelled` as for [`Passage::new`].
    pub(crate) fn narrowed(&self, by: u32, control: &Control) -> Result<Passage> {
        debug_assert!(by <= self.width);
        let counts = self.counts.map(|n| n + by);
        let whole = [OpenRun { start: 0, end: self.depth }];
        // none where the index is beyond the box
        let inside = |index: u32, axis: usize| {
            [Some(index), index.checked_sub(by)].map(|index| index.filter(|&index| index < self.counts[axis]))
        };
        let fill = |row: u32, block: &mut Block| {
            let rows = inside(row, 1);
            let (mut now, mut next) = (Vec::new(), Vec::new());
            for column in 0..counts[0] {
                now.clear();
                now.extend(whole);
                for (i, j) in inside(column, 0).into_iter().flat_map(|i| rows.map(|j| (i, j))) {
                    let other = match (i, j) {
                        (Some(i), Some(j)) => &self.runs[self.runs_of(self.ray([i, j]))],
                        _ if self.is_open_beyond => continue,
                        _ => &[],
                    };
                    intersect(&now, other, &mut next);
                    std::mem::swap(&mut now, &mut next);
                }
                block.runs.extend(now.iter().filter_map(|run| self.shortened(run, by)));
                block.ends.push(block.runs.len() as u32);
            }
            Ok(())
        };
        let empty =
            Passage { counts, depth: self.depth + by, width: self.width + by, firsts: vec![], runs: vec![], ..*self };
        empty.filled(fill, control)
    }

    /// The open run without the places where a cube that is `by` cells wider ends before it.
    fn shortened(&self, run: &OpenRun, by: u32) -> Option<OpenRun> {
        let start = if run.start == 0 && self.is_open_beyond { 0 } else { run.start + by };
        let end = if run.end == self.depth && self.is_open_beyond { run.end + by } else { run.end };
        (start < end).then_some(OpenRun { start, end })
    }

    /// Fills an empty passage, row after row of rays, on all cores.
    fn filled(self, fill: impl Fn(u32, &mut Block) -> Result<()> + Sync, control: &Control) -> Result<Passage> {
        let block = |rows: Range<u32>| {
            control.check()?;
            let mut block = Block::default();
            rows.into_iter().try_for_each(|row| fill(row, &mut block)).map(|()| block)
        };
        let blocks = self.blocks().into_par_iter().map(block).collect::<Result<Vec<Block>>>()?;
        let n_runs: usize = blocks.iter().map(|block| block.runs.len()).sum();
        if u32::try_from(n_runs).is_err() {
            let message = format!("{n_runs} runs of open cells do not fit a 32-bit index");
            return Err(Error::new("memory", message, "use larger cells"));
        }
        let mut firsts = vec![0];
        let mut runs = Vec::with_capacity(n_runs);
        for block in blocks {
            let before = runs.len() as u32;
            firsts.extend(block.ends.iter().map(|end| before + end));
            runs.extend(block.runs);
        }
        Ok(Passage { firsts, runs, ..self })
    }

    /// The same rays with other open runs, ascending by ray and cell.
    pub(crate) fn with_runs(&self, runs_of_rays: impl Iterator<Item = (u32, OpenRun)>) -> Passage {
        let mut firsts = vec![0; self.firsts.len()];
        let mut runs = Vec::new();
        for (ray, run) in runs_of_rays {
            firsts[ray as usize + 1] += 1;
            runs.push(run);
        }
        for ray in 1..firsts.len() {
            firsts[ray] += firsts[ray - 1];
        }
        Passage { firsts, runs, ..*self }
    }

    /// Consecutive rows of rays for one core each.
    pub(crate) fn blocks(&self) -> Vec<Range<u32>> {
        let rows = (BLOCK_RAYS / self.counts[0]).max(1);
        let n_rows = self.counts[1];
        (0..n_rows).step_by(rows as usize).map(|row| row..row.saturating_add(rows).min(n_rows)).collect()
    }

    /// Index of a ray by its place across.
    #[inline]
    pub(crate) fn ray(&self, [i, j]: [u32; 2]) -> u32 {
        i + self.counts[0] * j
    }

    /// Indices of the open runs of a ray.
    #[inline]
    pub(crate) fn runs_of(&self, ray: u32) -> Range<usize> {
        self.firsts[ray as usize] as usize..self.firsts[ray as usize + 1] as usize
    }

    /// Indices of the open runs of a ray that have cells in `along`.
    #[inline]
    pub(crate) fn runs_in(&self, ray: u32, along: Range<u32>) -> Range<usize> {
        let of_ray = self.runs_of(ray);
        let runs = &self.runs[of_ray.clone()];
        let first = runs.partition_point(|run| run.end <= along.start);
        let n = runs[first..].iter().take_while(|run| run.start < along.end).count();
        of_ray.start + first..of_ray.start + first + n
    }

    /// Index of the open run of a cell; none where the cell is not open or beyond the box.
    pub(crate) fn run_at(&self, [i, j, along]: Place) -> Option<usize> {
        let is_inside = i < self.counts[0] && j < self.counts[1] && along < self.depth;
        let run = is_inside.then(|| self.runs_in(self.ray([i, j]), along..along + 1))?;
        (!run.is_empty()).then_some(run.start)
    }

    /// The rays beside a ray, at most four.
    #[inline]
    pub(crate) fn beside(&self, ray: u32) -> impl Iterator<Item = u32> {
        let [n, m] = self.counts;
        let (i, j) = (ray % n, ray / n);
        let beside = [
            (i > 0, ray.wrapping_sub(1)),
            (i + 1 < n, ray + 1),
            (j > 0, ray.wrapping_sub(n)),
            (j + 1 < m, ray.wrapping_add(n)),
        ];
        beside.into_iter().filter(|(is_inside, _)| *is_inside).map(|(_, ray)| ray)
    }
}

/// The cells that two rays have in common.
fn intersect(one: &[OpenRun], other: &[OpenRun], out: &mut Vec<OpenRun>) {
    out.clear();
    let (mut a, mut b) = (0, 0);
    while let (Some(first), Some(second)) = (one.get(a), other.get(b)) {
        let (start, end) = (first.start.max(second.start), first.end.min(second.end));
        if start < end {
            out.push(OpenRun { start, end });
        }
        if first.end <= second.end { a += 1 } else { b += 1 }
    }
}

//! Gaps of one cell between flags: background cells with one flag before them and another behind, along x, y or z.
//!
//! Columns -> [`FlagGap`]s: where two substances should touch, and a cell between them is neither. Along the rays such a cell is a run
//! of length 1; across them the runs of three rays in a row are walked together. So the result does not depend on the ray axis.
//! A cell at the border of a window has a neighbour beyond it: whoever knows the cells there adds those of the three.
//! Cost: a pass over the runs of five rays for each.

use std::collections::BTreeMap;

use hexcast_core::base::error::Result;
use hexcast_core::base::parallel::*;
use hexcast_core::cells::columns::{Columns, run_cell, run_flag};
use hexcast_core::grid::rays::Rays;

/// Rays that one core takes at a time, about; whole rows.
const CHUNK: u32 = 1 << 14;

/// Background cells between two flags along an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FlagGap {
    /// The two flags, ascending.
    pub flags: [u8; 2],
    /// 0, 1 or 2.
    pub axis: usize,
    /// Number of cells.
    pub cells: u64,
    /// The first of them: that of the least z, of these of the least y, of these of the least x.
    pub first: [u32; 3],
    /// The box around all: its first cell and its end, exclusive.
    pub bounds: [[u32; 3]; 2],
}

/// By flags and axis.
type Found = BTreeMap<([u8; 2], usize), FlagGap>;

/// The gaps of a box, collected from columns of some of its cells after those of others.
#[derive(Debug, Default)]
pub struct FlagGaps(Found);

impl FlagGaps {
    /// Adds the gaps along some axes of columns that begin at a cell of the box.
    ///
    /// # Errors
    /// `io` where the columns are in a store that fails.
    pub fn add(&mut self, columns: &Columns, first: [u32; 3], axes: &[usize]) -> Result<()> {
        let [n_across, n_rows] = columns.rays().counts;
        let step = (CHUNK / n_across).max(1);
        let of_chunk = |chunk: u32| {
            let first = chunk * step;
            of_rows(columns, first, n_rows.min(first + step))
        };
        let chunks: Vec<Result<Found>> = (0..n_rows.div_ceil(step)).into_par_iter().map(of_chunk).collect();
        let in_box = |cell: [u32; 3]| [0, 1, 2].map(|axis| cell[axis] + first[axis]);
        for chunk in chunks {
            for gap in chunk?.into_values().filter(|gap| axes.contains(&gap.axis)) {
                note(&mut self.0, FlagGap { first: in_box(gap.first), bounds: gap.bounds.map(in_box), ..gap });
            }
        }
        Ok(())
    }

    /// All of them, in the order of flags and axes.
    pub fn into_list(self) -> Vec<FlagGap> {
        self.0.into_values().collect()
    }
}

/// Finds those of some rows of rays.
fn of_rows(columns: &Columns, first: u32, end: u32) -> Result<Found> {
    let rays = columns.rays();
    let [n_across, n_rows] = rays.counts;
    // with a row before and one behind
    let (from, to) = (first.saturating_sub(1), n_rows.min(end + 1));
    let (mut runs, mut ends) = (Vec::new(), vec![0]);
    let ray_of = |row: u32| u64::from(row) * u64::from(n_across);
    columns.for_rays(ray_of(from)..ray_of(to), |of_ray| {
        runs.extend_from_slice(of_ray);
        ends.push(runs.len());
    })?;
    let ray = |column: u32, row: u32| {
        let index = (ray_of(row - from) + u64::from(column)) as usize;
        &runs[ends[index]..ends[index + 1]]
    };
    let mut found = Found::new();
    for row in first..end {
        for column in 0..n_across {
            let own = ray(column, row);
            let mut note = |axis: usize, [start, end]: [u32; 2], flags: [u8; 2]| {
                note(&mut found, of_run(rays, axis, [column, row], [start, end], flags));
            };
            along(own, |cell, flags| note(rays.axis, [cell, cell + 1], flags));
            if column > 0 && column + 1 < n_across {
                let sides = [ray(column - 1, row), ray(column + 1, row)];
                between(own, sides, rays.depth, |run, flags| note(rays.across[0], run, flags));
            }
            if row > 0 && row + 1 < n_rows {
                let sides = [ray(column, row - 1), ray(column, row + 1)];
                between(own, sides, rays.depth, |run, flags| note(rays.across[1], run, flags));
            }
        }
    }
    Ok(found)
}

/// Cells of a ray that are gaps along it.
fn along(runs: &[u32], mut found: impl FnMut(u32, [u8; 2])) {
    for three in runs.windows(3) {
        let [before, own, behind] = [three[0], three[1], three[2]];
        let flags = [run_flag(before), run_flag(behind)];
        if run_flag(own) == 0 && run_cell(own) + 1 == run_cell(behind) && flags[0] != flags[1] {
            // no neighbour of background is background
            found(run_cell(own), flags);
        }
    }
}

/// Cells of a ray that are background between two neighbouring rays with different flags.
fn between(own: &[u32], sides: [&[u32]; 2], depth: u32, mut found: impl FnMut([u32; 2], [u8; 2])) {
    if sides.iter().any(|side| side.is_empty()) {
        return;
    }
    let lists = [own, sides[0], sides[1]];
    let (mut next, mut flags) = ([0; 3], [0; 3]);
    let mut start = 0;
    while start < depth {
        for (list, runs) in lists.iter().enumerate() {
            while let Some(&run) = runs.get(next[list]).filter(|&&run| run_cell(run) <= start) {
                flags[list] = run_flag(run);
                next[list] += 1;
            }
        }
        let ends = lists.iter().zip(next).map(|(runs, next)| runs.get(next).map_or(depth, |&run| run_cell(run)));
        let end = ends.fold(depth, u32::min);
        let [own, one, other] = flags;
        if own == 0 && one != 0 && other != 0 && one != other {
            found([start, end], [one, other]);
        }
        start = end;
    }
}

fn of_run(rays: &Rays, axis: usize, [column, row]: [u32; 2], [start, end]: [u32; 2], [one, other]: [u8; 2]) -> FlagGap {
    let first = rays.cell([column, row, start]);
    let bounds = [first, rays.cell([column + 1, row + 1, end])];
    FlagGap { flags: [one.min(other), one.max(other)], axis, cells: u64::from(end - start), first, bounds }
}

/// Adds cells to those of their flags and axis.
fn note(found: &mut Found, gap: FlagGap) {
    let all = found.entry((gap.flags, gap.axis)).or_insert(FlagGap { cells: 0, ..gap });
    all.cells += gap.cells;
    let order = |[x, y, z]: [u32; 3]| [z, y, x];
    if order(gap.first) < order(all.first) {
        all.first = gap.first;
    }
    for axis in 0..3 {
        all.bounds[0][axis] = all.bounds[0][axis].min(gap.bounds[0][axis]);
        all.bounds[1][axis] = all.bounds[1][axis].max(gap.bounds[1][axis]);
    }
}

//! Refinement: cells that are halved along each axis, again and again, where a surface is.
//!
//! Columns of several levels, each with twice as many cells along each axis as the one before -> [`Octree`], whose leaves are the cells that are not halved. Nothing is
//! made of single cells: which are halved is kept as runs.
//!
//! # Theory
//! Let R(l) be the cells of level l that are halved. Those with a child that touches a cell of another flag over a face are, where the surface gets cells of level l + 1; so both sides of a
//! surface have these cells. Two leaves that touch, if only at a corner, differ by one level at most: all that touches a cell of R(l) is of level l or finer, so its parent is halved.
//! R(l - 1) therefore is what the parents of R(l) and of all 26 cells around each of its cells are, and no more, but for what is asked for. Leaves of level l are the children of
//! R(l - 1) without R(l); each has the flag that the mesh of its level has there.
//!
//! Whether a cell of level 0 is halved depends on cells of level l less than 1/2 + 1/4 + ... + 1/2^l of its edge away, and on flags at most 1/2^l further. So a window that is
//! meshed with one cell of level 0 around it has the leaves of the whole in its own cells, however many levels there are.
//!
//! Source: ours; balanced as by Moore, "The cost of balancing generalized quadtrees" (1995). Cost: each row of cells and its neighbours are read once; 8 bytes a run.

mod cells;
mod marks;
#[cfg(test)]
mod tests;

use std::ops::Range;

use hexcast_core::base::control::Control;
use hexcast_core::base::error::{Error, Result};
use hexcast_core::base::parallel::*;
use hexcast_core::cells::columns::{Columns, spans};

use cells::{Cells, Plane};
use marks::Marks;
pub use marks::Wanted;

/// Planes of a round, after which cancel is looked at; wasm has one thread.
const ROUND: u32 = if cfg!(target_arch = "wasm32") { 4 } else { 64 };
/// Most levels above the first: cells are counted in 24 bits along an axis.
pub const MAX_LEVELS: u32 = 16;

/// Cells of several sizes that fill a box: of level 0 those of a mesh, of each further level of half their edge.
#[derive(Debug, Clone)]
pub struct Octree {
    /// By level.
    columns: Vec<Columns>,
    /// Cells that are halved, of all levels but the last.
    halved: Vec<Cells>,
}

/// Leaves that follow each other along x and have the same flag.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct LeafRun {
    /// The first cell of the level.
    pub start: u32,
    /// The end, exclusive.
    pub end: u32,
    /// Their flag.
    pub flag: u8,
}

impl LeafRun {
    /// Its cells.
    pub fn cells(&self) -> Range<u32> {
        self.start..self.end
    }
}

impl Octree {
    /// Finds which cells are halved. `columns` has the cells of each level, the first being level 0, all along x.
    ///
    /// # Errors
    /// `job-conflict` where there are more than [`MAX_LEVELS`] levels above the first, where columns do not lie along x, or have not twice the cells of those before; `job-value` where a level is asked for that
    /// there is not, or a box outside; `memory` where runs would take more than `max_bytes`; `io` where columns are in a store that fails; `cancelled`.
    pub async fn new(columns: Vec<Columns>, wanted: &Wanted, max_bytes: u64, control: &Control) -> Result<Octree> {
        check(&columns, wanted)?;
        let n_levels = columns.len() - 1;
        let mut halved: Vec<Cells> = Vec::new();
        let mut n_bytes = 0;
        for level in (0..n_levels).rev() {
            let [nx, ny, nz] = columns[level].dims();
            let marks = Marks::new(&columns[level + 1], wanted, level as u8 + 1);
            let finer = halved.last();
            let mut planes: Vec<Plane> = Vec::new();
            for start in (0..nz).step_by(ROUND as usize) {
                control.rest().await?;
                let found: Vec<Result<Plane>> = on_all_cores(|| {
                    map_within(start..(start + ROUND).min(nz), |memory: &mut Vec<[u32; 2]>, z| {
                        let mut of_plane = marks.plane(z)?;
                        let mut plane = Plane::default();
                        for y in 0..ny {
                            memory.clear();
                            of_plane.add([y, z], memory);
                            finer.iter().for_each(|finer| finer.add_parents([y, z], memory));
                            plane.add(memory, nx);
                        }
                        Ok(plane)
                    })
                });
                for plane in found {
                    let plane = plane?;
                    n_bytes += plane.n_bytes();
                    planes.push(plane);
                }
                if n_bytes > max_bytes {
                    let message = format!(
                        "the halved cells of level {level} up to plane {} of {nz} take {n_bytes} bytes: {max_bytes} are left of the memory allowed",
                        planes.len()
                    );
                    let hint = "allow more with max_memory (--max-memory), or ask for fewer levels";
                    return Err(Error::new("memory", message, hint));
                }
            }
            halved.push(Cells::new([nx, ny, nz], planes));
        }
        halved.reverse();
        Ok(Octree { columns, halved })
    }

    /// Number of levels, the first included.
    pub fn n_levels(&self) -> usize {
        self.columns.len()
    }

    /// Number of cells on x, y and z that a level has, were all of its size.
    pub fn dims(&self, level: usize) -> [u32; 3] {
        self.columns[level].dims()
    }

    /// Number of leaves of a level.
    pub fn n_leaves(&self, level: usize) -> u64 {
        let n_all = match level.checked_sub(1) {
            None => self.dims(0).iter().map(|n| u64::from(*n)).product(),
            Some(before) => 8 * self.halved[before].n_cells(),
        };
        n_all - self.halved.get(level).map_or(0, Cells::n_cells)
    }

    /// Hands over the leaves of some rows of a plane of a level: y and the runs along x, in the order of y. Rows without leaves are left out.
    ///
    /// # Errors
    /// `io` where the columns are in a store that fails.
    pub fn for_rows(
        &self,
        level: usize,
        z: u32,
        rows: Range<u32>,
        mut found: impl FnMut(u32, &[LeafRun]),
    ) -> Result<()> {
        let [nx, ny, _] = self.dims(level);
        let (mut here, mut leaves) = (Vec::new(), Vec::new());
        let mut y = rows.start;
        let first = u64::from(ny) * u64::from(z);
        self.columns[level].for_rays(first + u64::from(rows.start)..first + u64::from(rows.end), |runs| {
            here.clear();
            leaves.clear();
            match level.checked_sub(1) {
                None => here.push([0, nx]),
                Some(before) => {
                    here.extend(self.halved[before].row([y / 2, z / 2]).iter().map(|run| run.map(|x| 2 * x)))
                }
            }
            let own = self.halved.get(level).map_or(&[][..], |halved| halved.row([y, z]));
            without(&here, own, |start, end| {
                spans(runs, &(start..end), |start, end, flag| leaves.push(LeafRun { start, end, flag }));
            });
            if !leaves.is_empty() {
                found(y, &leaves);
            }
            y += 1;
        })
    }

    /// Hands over all leaves of a plane of a level, run by run: y, then x.
    ///
    /// # Errors
    /// Those of [`Octree::for_rows`].
    pub fn for_plane(&self, level: usize, z: u32, mut found: impl FnMut(u32, &LeafRun)) -> Result<()> {
        self.for_rows(level, z, 0..self.dims(level)[1], |y, leaves| leaves.iter().for_each(|run| found(y, run)))
    }

    /// Bytes in memory beside the columns.
    pub fn n_bytes(&self) -> u64 {
        self.halved.iter().map(Cells::n_bytes).sum()
    }
}

fn check(columns: &[Columns], wanted: &Wanted) -> Result<()> {
    let most = columns.len().saturating_sub(1);
    if columns.is_empty() || most > MAX_LEVELS as usize {
        let message = format!("{} levels; allowed: 1 to {}", columns.len(), MAX_LEVELS + 1);
        return Err(Error::new("job-conflict", message, "ask for fewer levels"));
    }
    for (level, of) in columns.iter().enumerate() {
        let twice = columns[level.saturating_sub(1)].dims().map(|n| if level == 0 { n } else { 2 * n });
        if of.dims() != twice || of.rays().axis != 0 {
            let message = format!(
                "level {level} has {:?} cells along axis {}, and {twice:?} along axis 0 are needed",
                of.dims(),
                of.rays().axis
            );
            return Err(Error::new(
                "job-conflict",
                message,
                "mesh each level with twice the cells of the one before, along x",
            ));
        }
    }
    let deepest = wanted.level_of_flag.iter().chain(wanted.boxes.iter().map(|(_, level)| level)).max();
    if let Some(&level) = deepest.filter(|level| usize::from(**level) > most) {
        let message = format!("level {level} is asked for, and the last is {most}");
        return Err(Error::new("job-value", message, "ask for more levels, or a level that there is"));
    }
    let dims = columns[0].dims();
    for (of, _) in &wanted.boxes {
        if (0..3).any(|axis| of[axis].start >= of[axis].end || of[axis].end > dims[axis]) {
            let message = format!("a box of cells {of:?} is asked for, and the mesh has {dims:?} cells");
            return Err(Error::new("job-value", message, "give a box within the mesh"));
        }
    }
    Ok(())
}

/// What of some runs is in none of others; both are sorted.
fn without(some: &[[u32; 2]], others: &[[u32; 2]], mut found: impl FnMut(u32, u32)) {
    let mut others = others.iter().peekable();
    for &[mut start, end] in some {
        while let Some(&&[low, high]) = others.peek().filter(|other| other[0] < end) {
            if low > start {
                found(start, low);
            }
            start = start.max(high);
            if high > end {
                break;
            }
            others.next();
        }
        if start < end {
            found(start, end);
        }
    }
}

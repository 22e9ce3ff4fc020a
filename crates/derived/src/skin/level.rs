//! Levels: the runs of a box of cells, as they are or coarsened by powers of two.
//!
//! Columns, a box -> [`Level`] of step 1; a level -> one of twice the step. Coarse cell c holds the cells 2 c and 2 c + 1 on
//! every axis, as far as they lie in the box. It is flagged if any of them is, and of several flags takes the rarest of
//! the mesh: that keeps plates and wires of one cell, alone or inside a thicker body, which a sample or the majority
//! would drop. "Any" and "rarest" are the same in one step or in many, so each level is made from the one before.
//!
//! Cost: O(n log n) time in the runs of a block of four rays; memory at most that of the level before, mostly a quarter.

use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};

use hexcast_core::base::parallel::*;

use hexcast_core::base::control::Control;
use hexcast_core::base::error::{Error, Result};
use hexcast_core::cells::columns::{Band, Columns, run, spans};
use hexcast_core::cells::flags::CellBox;

/// Rows of rays that are taken at once: enough to keep all cores busy.
pub(super) const ROWS: usize = 64;

/// A box of cells of one size.
#[derive(Debug)]
pub(super) struct Level<'a> {
    /// Edge of the cells in cells of the mesh.
    pub(super) step: u32,
    /// Cells along the rays.
    pub(super) along: Range<u32>,
    /// Rays on the two axes across.
    pub(super) across: [Range<u32>; 2],
    runs: Runs<'a>,
}

#[derive(Debug)]
enum Runs<'a> {
    /// The columns of the mesh, in memory.
    Fine(&'a Columns),
    /// A band for each row of rays of the box.
    Own(Vec<Band>),
}

impl<'a> Level<'a> {
    /// Takes a box of the mesh as it is.
    ///
    /// # Errors
    /// `io` where the columns are in a store that fails; such columns are read to memory, as far as the box has them.
    pub(super) fn fine(columns: &'a Columns, cells: &CellBox) -> Result<Level<'a>> {
        let rays = columns.rays();
        let across = rays.across.map(|axis| cells[axis].clone());
        let runs = if columns.is_spilled() { Runs::Own(bands_of(columns, &across)?) } else { Runs::Fine(columns) };
        Ok(Level { step: 1, along: cells[rays.axis].clone(), across, runs })
    }

    /// Whether the level is a single cell.
    pub(super) fn is_single(&self) -> bool {
        self.along.len() == 1 && self.across.iter().all(|range| range.len() == 1)
    }

    /// Runs of every ray of a row; none where the row is outside the box.
    pub(super) fn row(&self, row: u32) -> Vec<&[u32]> {
        let [rays, rows] = &self.across;
        if !rows.contains(&row) {
            return Vec::new();
        }
        match &self.runs {
            Runs::Fine(columns) => {
                let first = u64::from(columns.rays().counts[0]) * u64::from(row);
                rays.clone().map(|ray| columns.ray_in_memory(first + u64::from(ray))).collect()
            }
            Runs::Own(bands) => {
                let band = &bands[(row - rows.start) as usize];
                (0..rays.len()).map(|ray| band.ray(ray)).collect()
            }
        }
    }

    /// Joins eight cells to one. `order` names the flags, those first that win over later ones.
    pub(super) async fn coarser(&self, order: &[u8], control: &Control) -> Result<Level<'static>> {
        let halved = |range: &Range<u32>| range.start / 2..range.end.div_ceil(2);
        let across = self.across.each_ref().map(halved);
        let rows: Vec<u32> = across[1].clone().collect();
        let mut bands = Vec::with_capacity(rows.len());
        for rows in rows.chunks(ROWS) {
            control.rest().await?;
            bands.par_extend(rows.par_iter().map(|&row| self.coarse_row(row, &across[0], order)));
        }
        Ok(Level { step: 2 * self.step, along: halved(&self.along), across, runs: Runs::Own(bands) })
    }

    fn coarse_row(&self, row: u32, rays: &Range<u32>, order: &[u8]) -> Band {
        let mut rank = [0u8; 256];
        order.iter().enumerate().for_each(|(place, &flag)| rank[usize::from(flag)] = place as u8);
        let pair = [self.row(2 * row), self.row(2 * row + 1)];
        let mut band = Band::default();
        let mut edges = Vec::new();
        for ray in rays.clone() {
            edges.clear();
            // two rays of each row, where the box has them
            let first = (2 * ray).max(self.across[0].start) - self.across[0].start;
            let end = (2 * ray + 2).min(self.across[0].end) - self.across[0].start;
            for row in pair.iter().filter(|row| !row.is_empty()) {
                for runs in &row[first as usize..end as usize] {
                    spans(runs, &self.along, |start, end, flag| {
                        if flag != 0 {
                            let rank = rank[usize::from(flag)];
                            edges.extend([edge(start / 2, rank, true), edge(end.div_ceil(2), rank, false)]);
                        }
                    });
                }
            }
            edges.sort_unstable();
            push_runs(&edges, order, self.along.end.div_ceil(2), &mut band.runs);
            band.ends.push(band.runs.len() as u32);
        }
        band
    }
}

/// Reads the rays of a box, a band a row.
///
/// # Errors
/// `memory` where they are too many of an opened file; `io` where the store fails.
fn bands_of(columns: &Columns, [rays, rows]: &[Range<u32>; 2]) -> Result<Vec<Band>> {
    let n_held = AtomicU64::new(0);
    let max_bytes = columns.max_bytes().unwrap_or(u64::MAX);
    let band_of = |row: u32| {
        let mut band = Band::default();
        let first = u64::from(columns.rays().counts[0]) * u64::from(row);
        columns.for_rays(first + u64::from(rays.start)..first + u64::from(rays.end), |runs| {
            band.runs.extend_from_slice(runs);
            band.ends.push(band.runs.len() as u32);
        })?;
        let n_bytes = 4 * (band.ends.len() + band.runs.len()) as u64;
        if n_held.fetch_add(n_bytes, Ordering::Relaxed) + n_bytes > max_bytes {
            let message = format!("the surface of this mesh takes more than {max_bytes} bytes of runs");
            return Err(Error::new("memory", message, "cut a box from it, or look at slices"));
        }
        Ok(band)
    };
    rows.clone().into_par_iter().map(band_of).collect()
}

/// Where a span of a flag begins or ends; sorts by cell. A u64 like a face, so that one sort is compiled for both.
fn edge(cell: u32, rank: u8, begins: bool) -> u64 {
    u64::from(cell) << 9 | u64::from(rank) << 1 | u64::from(begins)
}

/// Appends the runs of a ray that overlapping spans of flags form, given by their sorted [`edge`]s. The lowest rank wins.
fn push_runs(edges: &[u64], order: &[u8], end: u32, runs: &mut Vec<u32>) {
    let mut n_open = [0u32; 256];
    let mut last = 0;
    for group in edges.chunk_by(|a, b| a >> 9 == b >> 9) {
        let cell = (group[0] >> 9) as u32;
        for &edge in group {
            // an end may come before a beginning of the same cell: counts wrap and come back
            let n = &mut n_open[(edge >> 1 & 0xff) as usize];
            *n = if edge & 1 == 1 { n.wrapping_add(1) } else { n.wrapping_sub(1) };
        }
        let flag = n_open[..order.len()].iter().position(|&n| n > 0).map_or(0, |rank| order[rank]);
        if flag != last && cell < end {
            runs.push(run(cell, flag));
            last = flag;
        }
    }
}

/// Flags in use, ascending by their number of cells in the mesh; of equal ones the lower flag first.
pub(super) fn by_rarity(columns: &Columns) -> Vec<u8> {
    let cells = columns.cells_per_flag();
    let cells = |flag: u8| cells[usize::from(flag)];
    let mut flags: Vec<u8> = Vec::new();
    for flag in (1..=255).filter(|&flag| cells(flag) > 0) {
        flags.insert(flags.partition_point(|&other| cells(other) <= cells(flag)), flag);
    }
    flags
}

//! Levels: the runs of a box of cells, as they are or coarsened by powers of two.
//!
//! Columns, a box -> [`Level`] of step 1; a level -> one of twice the step. Coarse cell c holds the cells 2 c and 2 c + 1 on
//! every axis, as far as they lie in the box. It is flagged if any of them is, and of several flags takes the rarest of
//! the mesh: that keeps plates and wires of one cell, alone or inside a thicker body, which a sample or the majority
//! would drop. "Any" and "rarest" are the same in one step or in many, so each level is made from the one before.
//! By majority the cell takes the flag that most of the eight have, background too; of equal ones the rarest, background last. That keeps
//! volumes rather than thin parts, and is the majority of eight cells of the level before, not of all cells of the mesh in it.
//!
//! Cost: O(n log n) time in the runs of a block of four rays; memory at most that of the level before, mostly a quarter.

use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};

use hexcast_core::base::parallel::*;

use super::Mesh;
use hexcast_core::base::control::Control;
use hexcast_core::base::error::{Error, Result};
use hexcast_core::cells::columns::{Band, Columns, run, spans};
use hexcast_core::cells::flags::CellBox;
use hexcast_core::grid::rays::Rays;
pub use hexcast_core::input::job::Levels;

/// Rows of rays that are taken at once: enough to keep all cores busy.
pub(crate) const ROWS: usize = 64;

/// Meshes of cells twice as large, one after the other, of a whole mesh.
#[derive(Debug, Clone)]
pub struct Pyramid {
    rule: Levels,
    /// Flags of the mesh, the rarest first.
    order: Vec<u8>,
}

impl Pyramid {
    /// Meshes of a rule; the mesh, of level 0, says which flags are rare.
    pub fn of(mesh: &Mesh, rule: Levels) -> Pyramid {
        Pyramid { rule, order: by_rarity(&mesh.columns) }
    }

    /// Makes the mesh of the next level from that of a level: its lines are every second one, and those of an odd number of equal cells reach half a cell
    /// beyond the box.
    ///
    /// # Errors
    /// `io` where the columns are in a store that fails; `cancelled`.
    pub async fn next(&self, mesh: &Mesh, control: &Control) -> Result<Mesh> {
        let level = Level::whole(&mesh.columns).coarser(&self.order, self.rule, control).await?;
        let lines = mesh.lines.doubled()?;
        let columns = level.into_columns(Rays::new(mesh.columns.rays().axis, lines.dims()))?;
        Mesh::new(lines, columns, mesh.names.clone(), mesh.unit.clone())
    }
}

/// A box of cells of one size.
#[derive(Debug)]
pub(crate) struct Level<'a> {
    /// Edge of the cells in cells of the mesh.
    pub(crate) step: u32,
    /// Cells along the rays.
    pub(crate) along: Range<u32>,
    /// Rays on the two axes across.
    pub(crate) across: [Range<u32>; 2],
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
    pub(crate) fn fine(columns: &'a Columns, cells: &CellBox) -> Result<Level<'a>> {
        let rays = columns.rays();
        let across = rays.across.map(|axis| cells[axis].clone());
        let max_bytes = columns.max_bytes().unwrap_or(u64::MAX);
        let runs = match columns.is_spilled() {
            true => Runs::Own(bands_of(columns, &across, max_bytes)?),
            false => Runs::Fine(columns),
        };
        Ok(Level { step: 1, along: cells[rays.axis].clone(), across, runs })
    }

    /// Takes all of the mesh, to make coarser levels of it: columns in a store stay there.
    fn whole(columns: &'a Columns) -> Level<'a> {
        let rays = columns.rays();
        Level { step: 1, along: 0..rays.depth, across: rays.counts.map(|n| 0..n), runs: Runs::Fine(columns) }
    }

    /// The same, of no more than some rows, read to memory.
    fn read(&self, columns: &Columns, rows: Range<u32>) -> Result<Level<'static>> {
        let across = [self.across[0].clone(), rows.start..rows.end.min(self.across[1].end)];
        let runs = Runs::Own(bands_of(columns, &across, u64::MAX)?);
        Ok(Level { step: self.step, along: self.along.clone(), across, runs })
    }

    /// The runs as columns, of a whole mesh.
    fn into_columns(self, rays: Rays) -> Result<Columns> {
        let Runs::Own(mut bands) = self.runs else { unreachable!("a coarser level has its own runs") };
        bands.iter_mut().zip((0..).step_by(rays.counts[0] as usize)).for_each(|(band, ray)| band.first_ray = ray);
        Columns::new(rays, bands)
    }

    /// Whether the level is a single cell.
    pub(crate) fn is_single(&self) -> bool {
        self.along.len() == 1 && self.across.iter().all(|range| range.len() == 1)
    }

    /// Runs of every ray of a row; none where the row is outside the box.
    pub(crate) fn row(&self, row: u32) -> Vec<&[u32]> {
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
    pub(crate) async fn coarser(&self, order: &[u8], rule: Levels, control: &Control) -> Result<Level<'static>> {
        let halved = |range: &Range<u32>| range.start / 2..range.end.div_ceil(2);
        let across = self.across.each_ref().map(halved);
        let rows: Vec<u32> = across[1].clone().collect();
        let mut bands = Vec::with_capacity(rows.len());
        for rows in rows.chunks(ROWS) {
            control.rest().await?;
            let read = match &self.runs {
                Runs::Fine(columns) if columns.is_spilled() => {
                    Some(self.read(columns, 2 * rows[0]..2 * rows[0] + 2 * rows.len() as u32)?)
                }
                _ => None,
            };
            let of = read.as_ref().unwrap_or(self);
            bands.par_extend(rows.par_iter().map(|&row| of.coarse_row(row, &across[0], order, rule)));
        }
        Ok(Level { step: 2 * self.step, along: halved(&self.along), across, runs: Runs::Own(bands) })
    }

    fn coarse_row(&self, row: u32, rays: &Range<u32>, order: &[u8], rule: Levels) -> Band {
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
            let mut n_rays = 0;
            for row in pair.iter().filter(|row| !row.is_empty()) {
                for runs in &row[first as usize..end as usize] {
                    n_rays += 1;
                    spans(runs, &self.along, |start, end, flag| {
                        if flag != 0 {
                            let rank = rank[usize::from(flag)];
                            edges.extend(match rule {
                                Levels::Majority => [edge(start, rank, true), edge(end, rank, false)],
                                _ => [edge(start / 2, rank, true), edge(end.div_ceil(2), rank, false)],
                            });
                        }
                    });
                }
            }
            edges.sort_unstable();
            match rule {
                Levels::Majority => push_majorities(&edges, order, (n_rays, &self.along), &mut band.runs),
                _ => push_runs(&edges, order, self.along.end.div_ceil(2), &mut band.runs),
            }
            band.ends.push(band.runs.len() as u32);
        }
        band
    }
}

/// Reads the rays of a box, a band a row.
///
/// # Errors
/// `memory` where they are too many of an opened file; `io` where the store fails.
fn bands_of(columns: &Columns, [rays, rows]: &[Range<u32>; 2], max_bytes: u64) -> Result<Vec<Band>> {
    let n_held = AtomicU64::new(0);
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
        step(group, &mut n_open);
        let flag = n_open[..order.len()].iter().position(|&n| n > 0).map_or(0, |rank| order[rank]);
        if flag != last && cell < end {
            runs.push(run(cell, flag));
            last = flag;
        }
    }
}

/// Appends the runs of the flags that most cells have, of so many rays along a range of cells, given by the sorted [`edge`]s of their spans.
fn push_majorities(edges: &[u64], order: &[u8], (n_rays, along): (u32, &Range<u32>), runs: &mut Vec<u32>) {
    // cells of each rank at a place along the rays, and at that before
    let mut here = vec![0u32; order.len()];
    let mut before = here.clone();
    let mut last = 0;
    let mut put = |cell: u32, [first, second]: [&[u32]; 2]| {
        let (mut flag, mut most, mut n_flagged) = (0, 0, 0);
        for (&flag_of_rank, n) in order.iter().zip(first.iter().zip(second).map(|(a, b)| a + b)) {
            n_flagged += n;
            if n > most {
                (flag, most) = (flag_of_rank, n);
            }
        }
        let flag = if 2 * n_rays - n_flagged > most { 0 } else { flag };
        if flag != last {
            runs.push(run(cell, flag));
            last = flag;
        }
    };
    let mut groups =
        edges.chunk_by(|a, b| a >> 9 == b >> 9).filter(|group| group[0] >> 9 < u64::from(along.end)).peekable();
    while let Some(group) = groups.next() {
        let place = (group[0] >> 9) as u32;
        let cell = place / 2;
        before.copy_from_slice(&here);
        step(group, &mut here);
        if place.is_multiple_of(2) {
            before.copy_from_slice(&here);
            if let Some(group) = groups.next_if(|next| next[0] >> 9 == u64::from(place) + 1) {
                step(group, &mut here);
            }
        } else if place == along.start {
            before.copy_from_slice(&here);
        }
        // the last cell has but one place where their number is odd
        put(cell, [&before, if 2 * cell + 1 < along.end { &here } else { &before }]);
        let is_free = groups.peek().is_none_or(|next| next[0] >> 10 > u64::from(cell) + 1);
        if is_free && 2 * cell + 2 < along.end {
            put(cell + 1, [&here, &here]);
        }
    }
}

/// Adds the spans that begin, and takes those that end.
fn step(group: &[u64], n_open: &mut [u32]) {
    for &edge in group {
        // an end may come before a beginning of the same cell: counts wrap and come back
        let n = &mut n_open[(edge >> 1 & 0xff) as usize];
        *n = if edge & 1 == 1 { n.wrapping_add(1) } else { n.wrapping_sub(1) };
    }
}

/// Flags in use, ascending by their number of cells in the mesh; of equal ones the lower flag first.
pub(crate) fn by_rarity(columns: &Columns) -> Vec<u8> {
    let cells = columns.cells_per_flag();
    let cells = |flag: u8| cells[usize::from(flag)];
    let mut flags: Vec<u8> = Vec::new();
    for flag in (1..=255).filter(|&flag| cells(flag) > 0) {
        flags.insert(flags.partition_point(|&other| cells(other) <= cells(flag)), flag);
    }
    flags
}

#[cfg(test)]
mod tests;

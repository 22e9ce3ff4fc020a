//! Gaps: openings narrower than a number of cells get a flag, for casings that must be tight.
//!
//! Columns, K -> columns and [`Gaps`]. A background cell is in a gap if on its line of cells along x, y or z fewer than K
//! background cells in a row lie between two flagged cells, and it is one of these. All three axes are looked at before a
//! cell changes, so the result does not depend on the ray axis. A hole of a x b cells through a wall is closed if the
//! lesser of the two is below K, and keeps all its cells if it is not; a round hole of K cells and more keeps its middle.
//! A slit across the axes is wider along them than it is: at 45 degrees by a factor of 1.4. Dents, slits between parts and
//! rooms narrower than K are gaps, too. Cells beyond the mesh are background without end.
//!
//! Along the rays a gap is an open run. Across them a sweep goes from ray to ray and keeps, as pieces of the ray, where the
//! background began; a piece that ends within K rays is a gap.
//!
//! Cost: two sweeps over the runs, on all cores; 8 bytes a background run, 12 a run of a gap, and the columns a second time.

use serde::Serialize;

use crate::leak::passage::{OpenRun, Passage};
use crate::leak::rooms::Rooms;
use hexcast_core::base::control::Control;
use hexcast_core::base::error::{Error, Result};
use hexcast_core::base::parallel::*;
use hexcast_core::base::sort::sort_by_key;
use hexcast_core::cells::columns::{Band, CellRun, Columns, run, run_flag, spans};
use hexcast_core::grid::lines::Lines;
use hexcast_core::set;

mod sweep;

use sweep::Sweep;

/// Name of the flag of closed gaps.
pub const NAME: &str = "closed gaps";
/// Most gaps that are listed.
const MAX_LISTED: usize = 100;
/// Rays of a band of the new columns.
const BAND_RAYS: u64 = 1 << 16;

/// The gaps that were closed.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(any(test, feature = "testing"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Gaps {
    /// Openings of fewer cells were closed.
    pub width: u32,
    /// Flag that their cells got.
    pub flag: u8,
    /// Number of these cells.
    pub cells: u64,
    /// Number of gaps: their cells are connected over faces.
    pub gaps: u64,
    /// The gaps of most cells, at most 100.
    pub largest: Vec<Gap>,
}

/// Connected cells that were added.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(any(test, feature = "testing"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Gap {
    /// Number of cells.
    pub cells: u64,
    /// Corners of the box around them, in world coordinates.
    pub bounds: [[f64; 3]; 2],
}

/// Gives the cells of gaps narrower than `width` cells a flag; at most `max_bytes` of memory are taken beside the columns.
///
/// # Errors
/// `memory` where the columns are in a store outside memory, or the gaps take more than is allowed; `cancelled`.
pub fn close(
    columns: &Columns,
    lines: &Lines,
    (width, flag): (u32, u8),
    max_bytes: u64,
    control: &Control,
) -> Result<(Columns, Gaps)> {
    check_memory(columns, max_bytes)?;
    let mut is_open = [false; 256];
    is_open[0] = true;
    let background = Passage::new(columns, &is_open, control)?;
    let found = gap_runs(&background, width, control)?;
    let closed = with_flag(columns, &found, flag, control)?;
    let per_ray = found.iter().map(|gap| (gap.ray as u32, OpenRun { start: gap.start, end: gap.end }));
    let mut largest = connected(columns, lines, &background.with_runs(per_ray));
    let (cells, gaps) = (largest.iter().map(|gap| gap.cells).sum(), largest.len() as u64);
    largest.truncate(MAX_LISTED);
    Ok((closed, Gaps { width, flag, cells, gaps, largest }))
}

fn check_memory(columns: &Columns, max_bytes: u64) -> Result<()> {
    let n_rays = columns.rays().n_rays();
    let needed = columns.n_bytes() + 4 * n_rays + 8 * (columns.n_runs() / 2 + n_rays);
    let hint = "allow more with max_memory (--max-memory), use larger cells, or leave out close_gaps (--close-gaps)";
    if columns.is_spilled() {
        let message = format!("gaps are closed in memory, but the columns of {n_rays} rays do not fit there");
        return Err(Error::new("memory", message, hint));
    }
    if needed > max_bytes || n_rays >= u64::from(u32::MAX) {
        let message = format!("closing gaps among {n_rays} rays takes {needed} bytes; {max_bytes} are left for it");
        return Err(Error::new("memory", message, hint));
    }
    Ok(())
}

/// The cells of all gaps, ascending by ray and cell; runs of one ray do not touch.
fn gap_runs(background: &Passage, width: u32, control: &Control) -> Result<Vec<CellRun>> {
    let [n, m] = background.counts;
    let along_rays = |row: u32| {
        let rays = (0..n).map(|column| background.ray([column, row]));
        let inner = |run: &OpenRun| run.start > 0 && run.end < background.depth && run.end - run.start < width;
        let of_ray = |ray: u32| {
            let runs = background.runs[background.runs_of(ray)].iter().filter(|run| inner(run));
            runs.map(move |run| CellRun { ray: ray.into(), start: run.start, end: run.end })
        };
        rays.flat_map(of_ray).collect::<Vec<CellRun>>()
    };
    let along_row = |row: u32| Sweep::new(width).gaps(background, (0..n).map(|column| [column, row]));
    let along_column = |column: u32| Sweep::new(width).gaps(background, (0..m).map(|row| [column, row]));
    let mut found = Vec::new();
    found.extend((0..m).into_par_iter().map(along_rays).collect::<Vec<Vec<CellRun>>>());
    control.check()?;
    found.extend((0..m).into_par_iter().map(along_row).collect::<Vec<Vec<CellRun>>>());
    control.check()?;
    found.extend((0..n).into_par_iter().map(along_column).collect::<Vec<Vec<CellRun>>>());
    control.check()?;
    Ok(CellRun::united(found.concat()))
}

/// The columns with a flag in the gaps.
fn with_flag(columns: &Columns, gaps: &[CellRun], flag: u8, control: &Control) -> Result<Columns> {
    let n_rays = columns.rays().n_rays();
    let band = |index: u64| {
        control.check()?;
        let rays = index * BAND_RAYS..n_rays.min((index + 1) * BAND_RAYS);
        let mut band = set!(Band { first_ray: rays.start, ..Band::default() });
        if index == 0 {
            (band.odd_rays, band.n_crossings) = (columns.odd_rays(), columns.n_crossings());
        }
        let mut ray = rays.start;
        let mut rest = &gaps[gaps.partition_point(|gap| gap.ray < ray)..];
        columns.for_rays(rays, |runs| {
            let (of_ray, after) = rest.split_at(rest.iter().take_while(|gap| gap.ray == ray).count());
            if of_ray.is_empty() {
                band.runs.extend_from_slice(runs);
            } else {
                push_ray(&mut band.runs, runs, of_ray, flag, columns.rays().depth);
            }
            band.ends.push(band.runs.len() as u32);
            (rest, ray) = (after, ray + 1);
        })?;
        Ok(band)
    };
    let bands = (0..n_rays.div_ceil(BAND_RAYS)).into_par_iter().map(band).collect::<Result<Vec<Band>>>()?;
    Columns::new(*columns.rays(), bands)
}

/// Adds the runs of a ray with a flag in its gaps, which lie in its background.
fn push_ray(out: &mut Vec<u32>, runs: &[u32], gaps: &[CellRun], flag: u8, depth: u32) {
    let first = out.len();
    let mut push = |cell: u32, flag: u8| {
        if flag != out[first..].last().map_or(0, |&run| run_flag(run)) {
            out.push(run(cell, flag));
        }
    };
    let mut rest = gaps.iter().peekable();
    spans(runs, &(0..depth), |start, end, of_span| {
        let mut next = start;
        while let Some(gap) = rest.next_if(|gap| gap.start < end) {
            if next < gap.start {
                push(next, of_span);
            }
            push(gap.start, flag);
            next = gap.end;
        }
        if next < end {
            push(next, of_span);
        }
    });
}

/// Connected cells, those of most cells first.
fn connected(columns: &Columns, lines: &Lines, added: &Passage) -> Vec<Gap> {
    let rooms = Rooms::new(added);
    let rays = columns.rays();
    let mut boxes: Vec<(u32, u64, [[u32; 3]; 2])> = Vec::new();
    let mut index_of_room = vec![0; added.runs.len()];
    for ray in 0..rays.n_rays() as u32 {
        for run in added.runs_of(ray) {
            let OpenRun { start, end } = added.runs[run];
            let [i, j] = [ray % rays.counts[0], ray / rays.counts[0]];
            let [low, high] = [rays.cell([i, j, start]), rays.cell([i + 1, j + 1, end])];
            let room = rooms.of(run);
            // the first run of a room comes first
            if room as usize == run {
                index_of_room[run] = boxes.len();
                boxes.push((room, 0, [low, high]));
            }
            let (_, n_cells, around) = &mut boxes[index_of_room[room as usize]];
            *n_cells += u64::from(end - start);
            for axis in 0..3 {
                around[0][axis] = around[0][axis].min(low[axis]);
                around[1][axis] = around[1][axis].max(high[axis]);
            }
        }
    }
    // of equal ones the first in the order of the cells, whatever the ray axis
    sort_by_key(&mut boxes, |(_, n_cells, [low, high])| (u64::MAX - n_cells, [low[2], low[1], low[0]], *high));
    boxes.into_iter().map(|(_, cells, around)| Gap { cells, bounds: lines.corners(around) }).collect()
}

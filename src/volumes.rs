//! The volume of the cells of each flag.
//!
//! Columns, lines -> volumes, in cubed file units. If all cells are equal, it is their number times the volume of one. Otherwise
//! it is the sum over rays, in their order, of the lengths of the runs times the area of the ray: it does not depend on bands.
//! Cost: nothing, or a pass over the runs.

use crate::columns::{Columns, run_cell, run_flag};
use crate::error::Result;
use crate::lines::Lines;

/// Volumes of the cells of flags 1 to 255; that of the background, 0, is left out.
///
/// # Errors
/// `io` where the columns are in a store that fails.
pub(crate) fn volumes(columns: &Columns, lines: &Lines) -> Result<[f64; 256]> {
    let mut volumes = [0.0; 256];
    if let Some(cell) = lines.cell_volume() {
        let cells = columns.cells_per_flag();
        volumes.iter_mut().zip(cells).skip(1).for_each(|(volume, n)| *volume = n as f64 * cell);
        return Ok(volumes);
    }
    let rays = &columns.rays;
    let along = lines.list(rays.axis);
    let n_across = u64::from(rays.counts[0]);
    let mut ray = 0;
    columns.for_rays(0..rays.n_rays(), |runs| {
        let size = |side: usize, cell: u64| lines.cell_size(rays.across[side], cell as u32);
        let area = size(0, ray % n_across) * size(1, ray / n_across);
        for (index, &run) in runs.iter().enumerate().filter(|(_, run)| run_flag(**run) != 0) {
            let end = runs.get(index + 1).map_or(rays.depth, |&next| run_cell(next));
            volumes[usize::from(run_flag(run))] += (along[end as usize] - along[run_cell(run) as usize]) * area;
        }
        ray += 1;
    })?;
    Ok(volumes)
}

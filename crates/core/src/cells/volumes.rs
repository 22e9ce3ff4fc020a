//! The volume of the cells of each flag.
//!
//! Columns, lines -> volumes, in cubed file units. If all cells are equal, it is their number times the volume of one. Otherwise
//! it is an exact sum over runs, rounded once ([`crate::grid::totals`]): the same along any axis and in any bands.
//! Cost: nothing, or a pass over the runs.

use crate::base::error::Result;
use crate::cells::columns::{Columns, run_cell, run_flag};
use crate::grid::lines::Lines;
use crate::grid::totals::{Ruler, Total};

/// Volumes of the cells of flags 1 to 255; that of the background, 0, is left out.
pub struct Volumes {
    /// In cubed file units.
    pub of_flags: [f64; 256],
    /// In units of the box, where cells differ in size.
    pub totals: Option<[Total; 256]>,
}

impl Volumes {
    /// Of columns with these lines, some of those of a box or around it.
    ///
    /// # Errors
    /// `io` where the columns are in a store that fails.
    pub fn new(columns: &Columns, lines: &Lines, whole: &Lines) -> Result<Volumes> {
        let mut of_flags = [0.0; 256];
        if let Some(cell) = lines.cell_volume() {
            let cells = columns.cells_per_flag();
            of_flags.iter_mut().zip(cells).skip(1).for_each(|(volume, n)| *volume = n as f64 * cell);
            return Ok(Volumes { of_flags, totals: None });
        }
        let (ruler, rays) = (Ruler::new(lines, whole), &columns.rays);
        let mut totals = [Total::default(); 256];
        let n_across = u64::from(rays.counts[0]);
        let mut ray = 0;
        columns.for_rays(0..rays.n_rays(), |runs| {
            let size = |side: usize, cell: u64| ruler.length(rays.across[side], [cell as u32, cell as u32 + 1]);
            let area = Total::from(u128::from(size(0, ray % n_across)) * u128::from(size(1, ray / n_across)));
            for (index, &run) in runs.iter().enumerate().filter(|(_, run)| run_flag(**run) != 0) {
                let end = runs.get(index + 1).map_or(rays.depth, |&next| run_cell(next));
                let length = ruler.length(rays.axis, [run_cell(run), end]);
                totals[usize::from(run_flag(run))].add(area.times(length));
            }
            ray += 1;
        })?;
        let of_flags = totals.map(|total| ruler.volume(total, 1));
        Ok(Volumes { of_flags, totals: Some(totals) })
    }
}

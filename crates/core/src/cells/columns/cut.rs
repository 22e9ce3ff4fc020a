//! Columns of a box of cells, or of blocks of cells.

use std::ops::Range;

use super::{Band, Columns, ColumnsBuilder, run, run_flag, spans};
use crate::base::control::Control;
use crate::base::error::Result;
use crate::grid::rays::Rays;

/// Rays of a band, at least.
const BAND_RAYS: usize = 1 << 16;

impl Columns {
    /// The columns of blocks of `stride` cells of a box: each has the flag of the cell in its middle, number n / 2 of n, rounded down. Cells at the end of the
    /// box that do not fill a block are left out. Crossings and odd rays are those of all rays. At most `max_bytes` of memory are taken.
    ///
    /// # Errors
    /// `memory` where the columns take more than is allowed; `io` where these cannot be read; `cancelled`.
    #[doc(hidden)]
    pub fn cut(&self, cells: &[Range<u32>; 3], stride: [u32; 3], max_bytes: u64, control: &Control) -> Result<Columns> {
        let rays = Rays::new(self.rays.axis, [0, 1, 2].map(|axis| cells[axis].len() as u32 / stride[axis]));
        let middle = |axis: usize, block: u32| cells[axis].start + block * stride[axis] + stride[axis] / 2;
        // the first block whose middle is not before a cell
        let block = |cell: u32| cell.saturating_sub(middle(rays.axis, 0)).div_ceil(stride[rays.axis]).min(rays.depth);
        let mut builder = ColumnsBuilder::new(rays, max_bytes, None);
        let mut band = Band { n_crossings: self.n_crossings(), odd_rays: self.odd_rays(), ..Band::default() };
        let [across, along_row] = rays.across;
        for row in 0..rays.counts[1] {
            control.check()?;
            let start = u64::from(middle(along_row, row)) * u64::from(self.rays.counts[0]);
            let of_row =
                start + u64::from(middle(across, 0))..start + u64::from(middle(across, rays.counts[0] - 1)) + 1;
            let mut next = 0;
            self.for_rays(of_row, |runs| {
                let is_taken = next % stride[across] == 0;
                next += 1;
                if !is_taken {
                    return;
                }
                let first = band.runs.len();
                spans(runs, &cells[rays.axis], |from, to, flag| {
                    let (from, to) = (block(from), block(to));
                    let before = band.runs[first..].last().map_or(0, |&last| run_flag(last));
                    if from < to && flag != before {
                        band.runs.push(run(from, flag));
                    }
                });
                band.ends.push(band.runs.len() as u32);
            })?;
            if band.ends.len() >= BAND_RAYS || row + 1 == rays.counts[1] {
                let next = Band { first_ray: band.first_ray + band.ends.len() as u64, ..Band::default() };
                builder.push(vec![std::mem::replace(&mut band, next)])?;
            }
        }
        builder.finish()
    }
}

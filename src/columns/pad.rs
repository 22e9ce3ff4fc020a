//! Columns with background cells around them.

use super::Columns;
use super::run::{Band, run, run_cell, run_flag};
use crate::error::{Error, Result};
use crate::rays::Rays;

/// Rays of a band, at least.
const BAND_RAYS: usize = 1 << 16;

impl Columns {
    /// These columns with so many background cells more before and behind them on x, y, z.
    ///
    /// # Errors
    /// `memory` where they have left it.
    pub(crate) fn padded(&self, [before, behind]: [[u32; 3]; 2]) -> Result<Columns> {
        if self.is_spilled() {
            let message = "cells beyond the box are added in memory, and the columns had to leave it";
            let hint = "allow more with max_memory (--max-memory), leave out --resume, or use smaller windows";
            return Err(Error::new("memory", message, hint));
        }
        let dims = self.dims();
        let rays = Rays::new(self.rays.axis, [0, 1, 2].map(|axis| before[axis] + dims[axis] + behind[axis]));
        let [i, j] = rays.across;
        let (first, n_inside) = (before[rays.axis], self.rays.depth);
        let mut bands = vec![Band { n_crossings: self.n_crossings(), odd_rays: self.odd_rays(), ..Band::default() }];
        for row in 0..rays.counts[1] {
            let mut band = bands.pop().unwrap_or_default();
            let empty =
                |band: &mut Band, n: u32| band.ends.extend(std::iter::repeat_n(band.runs.len() as u32, n as usize));
            match row.checked_sub(before[j]).filter(|row| *row < self.rays.counts[1]) {
                None => empty(&mut band, rays.counts[0]),
                Some(row) => {
                    empty(&mut band, before[i]);
                    let start = u64::from(row) * u64::from(self.rays.counts[0]);
                    self.for_rays(start..start + u64::from(self.rays.counts[0]), |runs| {
                        band.runs.extend(runs.iter().map(|&of| run(run_cell(of) + first, run_flag(of))));
                        let ends_flagged = runs.last().is_some_and(|&last| run_flag(last) != 0);
                        if ends_flagged && behind[rays.axis] > 0 {
                            band.runs.push(run(first + n_inside, 0));
                        }
                        band.ends.push(band.runs.len() as u32);
                    })?;
                    empty(&mut band, behind[i]);
                }
            }
            let next_ray = band.first_ray + band.ends.len() as u64;
            let is_full = band.ends.len() >= BAND_RAYS;
            bands.push(band);
            if is_full && next_ray < rays.n_rays() {
                bands.push(Band { first_ray: next_ray, ..Band::default() });
            }
        }
        Columns::new(rays, bands)
    }
}

#[cfg(test)]
mod tests {
    use crate::mesh::tests::pattern;

    #[test]
    fn padded_columns_are_background_around_the_same_flags() {
        let dims = [9, 5, 7];
        for axis in 0..3 {
            let mesh = pattern(axis, dims, 3);
            for [before, behind] in [[[0; 3], [0; 3]], [[2, 3, 1], [1, 0, 4]], [[0, 0, 2], [0, 1, 0]]] {
                let padded = mesh.columns.padded([before, behind]).unwrap();
                assert_eq!(padded.dims(), [0, 1, 2].map(|axis| before[axis] + dims[axis] + behind[axis]));
                assert_eq!(
                    (padded.n_crossings(), padded.odd_rays()),
                    (mesh.columns.n_crossings(), mesh.columns.odd_rays())
                );
                let [nx, ny, nz] = padded.dims();
                for cell in (0..nz).flat_map(|z| (0..ny).flat_map(move |y| (0..nx).map(move |x| [x, y, z]))) {
                    let inside =
                        [0, 1, 2].map(|axis| cell[axis].checked_sub(before[axis]).filter(|&at| at < dims[axis]));
                    let expected = match inside {
                        [Some(x), Some(y), Some(z)] => mesh.columns.flag([x, y, z]).unwrap(),
                        _ => 0,
                    };
                    assert_eq!(
                        padded.flag(cell).unwrap(),
                        expected,
                        "axis {axis}, {before:?}, {behind:?}, cell {cell:?}"
                    );
                }
            }
        }
    }
}

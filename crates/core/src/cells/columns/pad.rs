//! Columns with cells around them: background, or the flags of the outermost cells.

use super::Columns;
use super::run::{Band, run, run_cell, run_flag};
use crate::base::error::{Error, Result};
use crate::grid::rays::Rays;
use crate::input::job::HaloEdge;

/// Rays of a band, at least.
const BAND_RAYS: usize = 1 << 16;

impl Columns {
    /// These columns with so many cells more before and behind them on x, y, z.
    ///
    /// # Errors
    /// `memory` where they have left it.
    #[doc(hidden)]
    pub fn padded(&self, [before, behind]: [[u32; 3]; 2], edge: HaloEdge) -> Result<Columns> {
        if self.is_spilled() {
            let message = "halo cells beyond the box are added in memory, but the columns do not fit there";
            let hint = "allow more with max_memory (--max-memory), leave out --resume, or use smaller windows";
            return Err(Error::new("memory", message, hint));
        }
        let dims = self.dims();
        let rays = Rays::new(self.rays.axis, [0, 1, 2].map(|axis| before[axis] + dims[axis] + behind[axis]));
        let along = [before, behind].map(|cells| cells[rays.axis]);
        let mut bands = vec![Band { n_crossings: self.n_crossings(), odd_rays: self.odd_rays(), ..Band::default() }];
        for row in 0..rays.counts[1] {
            let mut band = bands.pop().unwrap_or_default();
            let (first, n) = (before[rays.across[1]], self.rays.counts[1]);
            let of_row = match source(row, first, n, edge) {
                Some(row) => self.row(row, along, edge)?,
                None => Vec::new(),
            };
            for column in 0..rays.counts[0] {
                let column = source(column, before[rays.across[0]], self.rays.counts[0], edge);
                if let Some(runs) = column.and_then(|column| of_row.get(column as usize)) {
                    band.runs.extend_from_slice(runs);
                }
                band.ends.push(band.runs.len() as u32);
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

    /// The runs of a row of rays, each with so many cells more before and behind it.
    fn row(&self, row: u32, [before, behind]: [u32; 2], edge: HaloEdge) -> Result<Vec<Vec<u32>>> {
        let (n, mut padded) = (u64::from(self.rays.counts[0]), Vec::new());
        let start = u64::from(row) * n;
        let is_clamped = edge == HaloEdge::Clamp;
        self.for_rays(start..start + n, |runs| {
            let moved = |cell: u32| if is_clamped && cell == 0 { 0 } else { cell + before };
            let mut of_ray: Vec<u32> = runs.iter().map(|&of| run(moved(run_cell(of)), run_flag(of))).collect();
            let ends_flagged = runs.last().is_some_and(|&last| run_flag(last) != 0);
            if ends_flagged && behind > 0 && !is_clamped {
                of_ray.push(run(before + self.rays.depth, 0));
            }
            padded.push(of_ray);
        })?;
        Ok(padded)
    }
}

/// Which of `n` rows, of which the first is number `first`, a number stands for: None for background.
fn source(number: u32, first: u32, n: u32, edge: HaloEdge) -> Option<u32> {
    if edge == HaloEdge::Clamp {
        return Some(number.saturating_sub(first).min(n - 1));
    }
    number.checked_sub(first).filter(|row| *row < n)
}

#[cfg(test)]
mod tests {
    use super::BAND_RAYS;
    use crate::cells::columns::{Band, Columns, run, run_cell, run_flag};
    use crate::grid::rays::Rays;
    use crate::input::job::HaloEdge;
    use crate::testing::pattern_columns;

    #[test]
    fn more_rays_than_a_band_holds_are_padded_in_several() {
        // a flag for each of 256 x 300 rays of 2 cells; without background around them, a band is full with row 256
        let (nx, ny) = (256, 300);
        let flag_of = |x: u32, y: u32| ((x + 7 * y) % 255 + 1) as u8;
        let runs = (0..ny).flat_map(|y| (0..nx).map(move |x| run(0, flag_of(x, y)))).collect();
        let band = Band { ends: (1..=nx * ny).collect(), runs, ..Band::default() };
        let columns = Columns::new(Rays::new(2, [nx, ny, 2]), vec![band]).unwrap();
        assert!((nx * ny) as usize > BAND_RAYS);
        for behind in [[0, 0, 1], [1, 2, 0]] {
            let padded = columns.padded([[0; 3], behind], HaloEdge::Background).unwrap();
            for y in 0..ny + behind[1] {
                for x in 0..nx + behind[0] {
                    let expected = if x < nx && y < ny { flag_of(x, y) } else { 0 };
                    assert_eq!(padded.flag([x, y, 1]).unwrap(), expected, "{x} {y}");
                    assert!(behind[2] == 0 || padded.flag([x, y, 2]).unwrap() == 0, "{x} {y}");
                }
            }
        }
    }

    #[test]
    fn padded_columns_have_the_same_flags_within_and_background_or_the_nearest_around_them() {
        let dims = [9, 5, 7];
        for axis in 0..3 {
            let columns = pattern_columns(axis, dims, 3);
            for [before, behind] in [[[0; 3], [0; 3]], [[2, 3, 1], [1, 0, 4]], [[0, 0, 2], [0, 1, 0]]] {
                for edge in [HaloEdge::Background, HaloEdge::Clamp] {
                    let padded = columns.padded([before, behind], edge).unwrap();
                    assert_eq!(padded.dims(), [0, 1, 2].map(|axis| before[axis] + dims[axis] + behind[axis]));
                    assert_eq!((padded.n_crossings(), padded.odd_rays()), (columns.n_crossings(), columns.odd_rays()));
                    // every ray has runs within it, ascending, each of another flag than the one before
                    let depth = padded.rays.depth;
                    let check = |runs: &[u32]| {
                        let of = runs.iter().map(|&run| (run_cell(run), run_flag(run)));
                        let (mut before, mut flag) = (None, 0);
                        for (cell, next) in of {
                            assert!(before < Some(cell) && cell < depth && next != flag, "{runs:?}");
                            (before, flag) = (Some(cell), next);
                        }
                    };
                    padded.for_rays(0..padded.rays.n_rays(), check).unwrap();
                    let [nx, ny, nz] = padded.dims();
                    for cell in (0..nz).flat_map(|z| (0..ny).flat_map(move |y| (0..nx).map(move |x| [x, y, z]))) {
                        let at = [0, 1, 2].map(|axis| i64::from(cell[axis]) - i64::from(before[axis]));
                        let nearest = [0, 1, 2].map(|axis| at[axis].clamp(0, i64::from(dims[axis]) - 1));
                        let flag = columns.flag(nearest.map(|cell| cell as u32)).unwrap();
                        let expected = if at == nearest || edge == HaloEdge::Clamp { flag } else { 0 };
                        let found = padded.flag(cell).unwrap();
                        assert_eq!(found, expected, "axis {axis}, {edge:?}, {before:?}, {behind:?}, cell {cell:?}");
                    }
                }
            }
        }
    }
}

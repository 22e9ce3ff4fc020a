//! What tests of several crates use: runs whose every cell is known.

use crate::cells::columns::{Band, Columns, run};
use crate::grid::rays::Rays;

pub use hexcast_job::testing::{assert_schema_is_committed, in_plain_text};

/// The runs of cells with these flags, one band for all rays.
pub fn band_of(rays: &Rays, flag_of: impl Fn([u32; 3]) -> u8) -> Band {
    let mut band = Band::default();
    for j in 0..rays.counts[1] {
        for i in 0..rays.counts[0] {
            let mut last = 0;
            for along in 0..rays.depth {
                let mut cell = [along; 3];
                (cell[rays.across[0]], cell[rays.across[1]]) = (i, j);
                let flag = flag_of(cell);
                if flag != last {
                    band.runs.push(run(along, flag));
                }
                last = flag;
            }
            band.ends.push(band.runs.len() as u32);
        }
    }
    band
}

/// Columns whose flags follow a fixed pattern of `n_flags` flags, the same for every ray axis.
pub fn pattern_columns(axis: usize, dims: [u32; 3], n_flags: u32) -> Columns {
    let rays = Rays::new(axis, dims);
    let band = band_of(&rays, |cell| pattern_flag(cell, n_flags));
    Columns::new(rays, vec![Band { odd_rays: 2, n_crossings: 1234567, ..band }]).unwrap()
}

/// The flag that [`pattern_columns`] gives a cell: 0, or one of `n_flags`.
pub fn pattern_flag([x, y, z]: [u32; 3], n_flags: u32) -> u8 {
    let mixed = (x / 3 * 5 + y / 2 * 3 + z / 2 * 7) % 11;
    if mixed < 6 { 0 } else { (1 + mixed % n_flags) as u8 }
}

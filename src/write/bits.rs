//! Bit-packed flags: eight cells a byte, for meshes with a single flag.
//!
//! A bit is 1 where the flag of the cell is not 0. The first cell along x is the least significant bit of a byte; every
//! row along x starts a new byte, and the unused high bits of its last byte are 0: `ceil(nx / 8)` bytes a row, rows in the
//! order y, then z. NumPy reads it with `np.unpackbits(bytes, axis=-1, count=nx, bitorder='little')` over the last axis.
//! Cost: one pass over the flags at the speed of memory, 1/8 of a slab.

use crate::error::{Error, Result};
use crate::mesh::Mesh;
use crate::parallel::*;

/// Number of bytes of a row of `nx` cells.
pub fn row_bytes(nx: u32) -> u32 {
    nx.div_ceil(8)
}

/// Refuses meshes that bits cannot tell apart from others.
///
/// # Errors
/// `job-conflict` where more than one flag besides the background is in use.
pub fn check(mesh: &Mesh) -> Result<()> {
    let cells = mesh.columns.cells_per_flag();
    let used: Vec<usize> = (1..cells.len()).filter(|&flag| cells[flag] > 0).collect();
    if used.len() > 1 {
        let message = format!("bits hold one flag, and the mesh has {}: {used:?}", used.len());
        return Err(Error::new("job-conflict", message, "write bytes, or give all geometries the same flag"));
    }
    Ok(())
}

/// Packs whole rows of `nx` flags into `out`, which is overwritten.
pub fn pack_rows(flags: &[u8], nx: u32, out: &mut Vec<u8>) {
    let row = row_bytes(nx) as usize;
    let nx = nx as usize;
    out.resize(flags.len() / nx * row, 0);
    // many short rows a task
    let rows = 65536usize.div_ceil(nx);
    out.par_chunks_mut(row * rows).zip(flags.par_chunks(nx * rows)).for_each(|(out, flags)| {
        for (out, flags) in out.chunks_exact_mut(row).zip(flags.chunks_exact(nx)) {
            pack_row(flags, out);
        }
    });
}

fn pack_row(flags: &[u8], out: &mut [u8]) {
    let (eights, rest) = flags.as_chunks::<8>();
    for (out, &eight) in out.iter_mut().zip(eights) {
        *out = pack_eight(eight);
    }
    if !rest.is_empty() {
        let mut eight = [0; 8];
        eight[..rest.len()].copy_from_slice(rest);
        out[eights.len()] = pack_eight(eight);
    }
}

/// Gathers "is not 0" of eight bytes, the first in the lowest bit.
fn pack_eight(eight: [u8; 8]) -> u8 {
    const LOW: u64 = 0x7f7f_7f7f_7f7f_7f7f;
    let bytes = u64::from_le_bytes(eight);
    // bit 7 of every byte that is not 0: its low seven bits carry into it, or it is set already
    let not_zero = (((bytes & LOW) + LOW) | bytes) & !LOW;
    // the multiplication brings bit 8 i to bit 56 + i; no two partial products meet
    ((not_zero >> 7).wrapping_mul(0x0102_0408_1020_4080) >> 56) as u8
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::tests::pattern;

    #[test]
    fn every_pattern_of_eight_cells_packs_bit_by_bit() {
        for value in 0..=255u8 {
            for flag in [1, 127, 128, 255] {
                let eight = std::array::from_fn(|i| if value >> i & 1 == 1 { flag } else { 0 });
                assert_eq!(pack_eight(eight), value, "flag {flag}");
            }
        }
    }

    #[test]
    fn rows_start_new_bytes() {
        let mut out = vec![9; 100];
        pack_rows(&[1, 0, 0, 0, 0, 0, 0, 0, 1, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0], 10, &mut out);
        assert_eq!(out, [0b1, 0b1, 0b1, 0b0]);
        pack_rows(&[0, 3, 0, 1, 1, 0], 3, &mut out);
        assert_eq!(out, [0b010, 0b011]);
        pack_rows(&[1; 300_000], 1, &mut out);
        assert_eq!(out, vec![1; 300_000]);
    }

    #[test]
    fn several_flags_are_refused_by_name() {
        assert!(check(&pattern(0, [9, 5, 7], 1)).is_ok());
        let error = check(&pattern(0, [9, 5, 7], 3)).unwrap_err();
        assert_eq!(error.code(), "job-conflict");
        assert!(error.to_string().contains("[1, 2, 3]"), "{error}");
    }
}

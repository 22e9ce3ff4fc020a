//! `.raw`: nothing but the flags, x fastest, then y, then z.
//!
//! One byte a cell, or eight cells a byte (see [`row_bytes`]); no header. The sidecar says what the numbers mean.
//! Cost: two slabs of memory.

use hexcast_core::cells::flags::row_bytes;

/// Number of bytes of the file; None where it would not fit 64 bits.
pub fn n_bytes([nx, ny, nz]: [u32; 3], bits: bool) -> Option<u64> {
    let row = if bits { row_bytes(nx) } else { nx };
    (u64::from(row) * u64::from(ny)).checked_mul(u64::from(nz))
}

//! Numbers in bytes, and the error of bytes that do not follow the layout.

use crate::base::error::Error;

/// The error of a file that does not follow the layout.
pub fn corrupt(message: String) -> Error {
    Error::new("columns-corrupt", message, "copy or write the file again")
}

/// The little-endian u32 at an offset.
pub(super) fn u32_at(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]])
}

/// The little-endian u64 at an offset.
pub(super) fn u64_at(bytes: &[u8], at: usize) -> u64 {
    u64::from(u32_at(bytes, at)) | u64::from(u32_at(bytes, at + 4)) << 32
}

//! CRC-32, the checksum of the column file and of columns aside.
//!
//! Source: PNG (RFC 2083), section 15.

/// CRC-32 of bytes, little-endian.
#[cfg(not(target_arch = "wasm32"))]
pub(crate) fn crc32(bytes: &[u8]) -> [u8; 4] {
    let mut crc = flate2::Crc::new();
    crc.update(bytes);
    crc.sum().to_le_bytes()
}

/// CRC-32 of bytes, little-endian; slower than flate2, whose tables are 16 KiB that a page would load. This one is made here.
#[cfg(target_arch = "wasm32")]
pub(crate) fn crc32(bytes: &[u8]) -> [u8; 4] {
    use std::sync::LazyLock;

    use crc::{CRC_32_ISO_HDLC, Crc, Table};

    static CRC: LazyLock<Crc<u32, Table<1>>> = LazyLock::new(|| Crc::<u32, Table<1>>::new(&CRC_32_ISO_HDLC));
    CRC.checksum(bytes).to_le_bytes()
}

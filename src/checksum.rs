//! CRC-32 (PNG, RFC 2083, section 15), the checksum of the column file, by flate2.

/// CRC-32 of bytes, little-endian.
pub(crate) fn crc32(bytes: &[u8]) -> [u8; 4] {
    let mut crc = flate2::Crc::new();
    crc.update(bytes);
    crc.sum().to_le_bytes()
}

//! CRC-32 (PNG, RFC 2083, section 15), the checksum of the column file, by flate2; the hash of files that are read, BLAKE3 by its authors' crate, which
//! a core makes about as fast as it reads; hashes as text.

use std::fmt::Write;

/// CRC-32 of bytes, little-endian.
pub fn crc32(bytes: &[u8]) -> [u8; 4] {
    let mut crc = flate2::Crc::new();
    crc.update(bytes);
    crc.sum().to_le_bytes()
}

/// The hash of a file that comes in parts.
#[derive(Default)]
pub struct FileHash(blake3::Hasher);

impl FileHash {
    /// Takes the next part.
    pub fn update(&mut self, part: &[u8]) {
        self.0.update(part);
    }

    /// In hexadecimal, as `b3sum` prints it.
    pub fn finish(self) -> String {
        self.0.finalize().to_string()
    }
}

/// Writes bytes in lower-case hexadecimal.
pub fn hex(bytes: &[u8]) -> String {
    bytes.iter().fold(String::with_capacity(2 * bytes.len()), |mut text, byte| {
        let _ = write!(text, "{byte:02x}"); // writing to a String cannot fail
        text
    })
}

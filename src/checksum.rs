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

/// CRC-32 of bytes, little-endian.
#[cfg(target_arch = "wasm32")]
pub(crate) fn crc32(bytes: &[u8]) -> [u8; 4] {
    small_crc32(bytes)
}

/// CRC-32 four bits at a time. Natively flate2 does it, faster; its tables are 8 KiB that a page would load.
#[cfg(any(target_arch = "wasm32", test))]
fn small_crc32(bytes: &[u8]) -> [u8; 4] {
    let mut table = [0u32; 16];
    for (index, entry) in table.iter_mut().enumerate() {
        *entry = (0..4).fold(index as u32, |value, _| value >> 1 ^ if value & 1 == 1 { 0xedb8_8320 } else { 0 });
    }
    let step = |crc: u32| crc >> 4 ^ table[(crc & 15) as usize];
    let crc = bytes.iter().fold(!0, |crc, &byte| step(step(crc ^ u32::from(byte))));
    (!crc).to_le_bytes()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sum_is_that_of_the_standard_and_of_flate2() {
        assert_eq!(small_crc32(b"123456789"), 0xcbf4_3926u32.to_le_bytes());
        let bytes: Vec<u8> = (0..70_123u32).map(|i| (i.wrapping_mul(i) >> 5) as u8).collect();
        for end in [0, 1, 15, 16, 17, 5000, bytes.len()] {
            assert_eq!(small_crc32(&bytes[..end]), crc32(&bytes[..end]));
        }
    }
}

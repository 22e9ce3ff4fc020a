//! The checksums of zlib: Adler-32 of what a stream holds, and CRC-32, which the column file uses too.
//!
//! Source: RFC 1950, section 9; PNG (RFC 2083), section 15.

/// Largest prime below 2^16.
const ADLER_BASE: u32 = 65521;
/// Bytes summed side by side.
const LANES: usize = 16;
/// Rows of lanes after which a sum could pass 2^32: 255 * n * (n + 1) / 2.
const ROWS: usize = 4096;

/// Adler-32 of bytes.
pub(crate) fn adler32(bytes: &[u8]) -> u32 {
    let (mut sum, mut sums) = (1u64, 0u64);
    let (rows, rest) = bytes.as_chunks::<LANES>();
    for rows in rows.chunks(ROWS) {
        // of each lane: the sum of its bytes, and the sum of that sum after every row but the last
        let (mut lanes, mut before) = ([0u32; LANES], [0u32; LANES]);
        for row in rows {
            for lane in 0..LANES {
                before[lane] += lanes[lane];
                lanes[lane] += u32::from(row[lane]);
            }
        }
        let n = (rows.len() * LANES) as u64;
        sums += n * sum;
        for lane in 0..LANES {
            sums += LANES as u64 * u64::from(before[lane]) + (LANES - lane) as u64 * u64::from(lanes[lane]);
            sum += u64::from(lanes[lane]);
        }
        (sum, sums) = (sum % u64::from(ADLER_BASE), sums % u64::from(ADLER_BASE));
    }
    for &byte in rest {
        sum += u64::from(byte);
        sums += sum;
    }
    ((sums as u32 % ADLER_BASE) << 16) | (sum as u32 % ADLER_BASE)
}

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
    fn sums_are_those_of_the_standards() {
        assert_eq!(adler32(b""), 1);
        assert_eq!(adler32(b"Wikipedia"), 0x11e6_0398);
        assert_eq!(small_crc32(b"123456789"), 0xcbf4_3926u32.to_le_bytes());
    }

    #[test]
    fn sums_are_those_of_flate2_and_of_the_definition() {
        let bytes: Vec<u8> =
            (0..200_123u32).map(|i| if i < 150_000 { 255 } else { (i.wrapping_mul(i) >> 5) as u8 }).collect();
        for end in [1, 15, 16, 17, 5000, LANES * ROWS - 1, LANES * ROWS, 150_000, bytes.len()] {
            assert_eq!(small_crc32(&bytes[..end]), crc32(&bytes[..end]));
            let (sum, sums) = bytes[..end].iter().fold((1, 0), |(sum, sums), &byte| {
                let sum = (sum + u32::from(byte)) % ADLER_BASE;
                (sum, (sums + sum) % ADLER_BASE)
            });
            assert_eq!(adler32(&bytes[..end]), sums << 16 | sum);
        }
    }
}

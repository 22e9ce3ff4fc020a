//! `.npy`: a NumPy array of shape (nz, ny, nx), or on request (nx, ny, nz), C order, one unsigned byte a cell.
//!
//! Version 1.0: magic, header length, a Python dictionary padded with spaces so that the data starts at a multiple of 64;
//! then the same bytes as `.raw`. Bit-packed the shape is (nz, ny, ceil(nx / 8)), bits as [`expand_bits`](hexcast_core::cells::flags::expand_bits) has them.
//! Source: NumPy's `numpy.lib.format`. Cost: two slabs of memory.

use super::{AxisOrder, Options, raw};
use hexcast_core::cells::flags::row_bytes;

/// Number of bytes of the file; None where it would not fit 64 bits.
pub fn n_bytes(dims: [u32; 3], bits: bool) -> Option<u64> {
    raw::n_bytes(dims, bits)?.checked_add(header(dims, &Options::default().with_bits(bits)).len() as u64)
}

/// Everything before the data.
pub(super) fn header([nx, ny, nz]: [u32; 3], options: &Options) -> Vec<u8> {
    let nx = if options.bits { row_bytes(nx) } else { nx };
    let shape = shape([nx, ny, nz], options.axis_order);
    header_of("|u1", &format!("({}, {}, {})", shape[0], shape[1], shape[2]))
}

/// Lengths of the axes of an array, the last one fastest.
fn shape([nx, ny, nz]: [u32; 3], order: AxisOrder) -> [u32; 3] {
    match order {
        AxisOrder::Zyx => [nz, ny, nx],
        AxisOrder::Xyz => [nx, ny, nz],
    }
}

/// Everything before the data of an array of a type and a shape, as NumPy writes them.
pub(super) fn header_of(kind: &str, shape: &str) -> Vec<u8> {
    const PREFIX: usize = 10;
    let mut text = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}, }}");
    let padded = (PREFIX + text.len() + 1).next_multiple_of(64);
    text.extend(std::iter::repeat_n(' ', padded - PREFIX - 1 - text.len()));
    text.push('\n');
    // three numbers of ten digits at most: always far below the 65,535 bytes of version 1.0
    let length = (text.len() as u16).to_le_bytes();
    [b"\x93NUMPY\x01\x00".as_slice(), &length, text.as_bytes()].concat()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_header_is_the_one_numpy_writes() {
        // numpy.save of zeros((7, 5, 9), 'u1'), up to the data
        let mut expected =
            b"\x93NUMPY\x01\x00\x76\x00{'descr': '|u1', 'fortran_order': False, 'shape': (7, 5, 9), }".to_vec();
        expected.resize(127, b' ');
        expected.push(b'\n');
        assert_eq!(header([9, 5, 7], &Options::default()), expected);
        assert!(header([9, 5, 7], &Options::default().with_bits(true)).windows(9).any(|text| text == b"(7, 5, 2)"));
        assert_eq!(header([u32::MAX; 3], &Options::default()).len() % 64, 0);
    }
}

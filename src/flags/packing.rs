//! How cells lie in memory: a byte or a bit each.
//!
//! Bits hold a single flag: 1 where the flag of the cell is not 0. The first cell along x is the least significant bit of a
//! byte; every row along x starts a new byte, and the unused high bits of its last byte are 0: [`row_bytes`] a row, rows in
//! the order y, then z. NumPy reads it with `np.unpackbits(bytes, axis=-1, count=nx, bitorder='little')` over the last axis.

/// Number of bytes of a row of `nx` cells, a bit each.
pub fn row_bytes(nx: u32) -> u32 {
    nx.div_ceil(8)
}

/// Cells in memory. A place counts cells from the start of a slice, with those that pad the end of each row.
pub(super) trait Packing {
    /// Bytes of so many cells, which start at a byte and end at the end of a row.
    fn n_bytes(places: usize) -> usize;
    /// Places of a row of `nx` cells.
    fn row(nx: usize) -> usize;
    /// Sets one cell.
    fn put(out: &mut [u8], place: usize, flag: u8);
    /// Sets the cells from one place to another, exclusive, in a row of which nothing after `from` is set yet.
    fn fill(row: &mut [u8], from: usize, to: usize, flag: u8);
}

/// A byte a cell.
pub(super) struct Bytes;

impl Packing for Bytes {
    fn n_bytes(places: usize) -> usize {
        places
    }

    fn row(nx: usize) -> usize {
        nx
    }

    fn put(out: &mut [u8], place: usize, flag: u8) {
        out[place] = flag;
    }

    fn fill(row: &mut [u8], from: usize, to: usize, flag: u8) {
        row[from..to].fill(flag);
    }
}

/// A bit a cell.
pub(super) struct Bits;

impl Packing for Bits {
    fn n_bytes(places: usize) -> usize {
        places / 8
    }

    fn row(nx: usize) -> usize {
        nx.next_multiple_of(8)
    }

    fn put(out: &mut [u8], place: usize, flag: u8) {
        let bit = 1 << (place % 8);
        let byte = &mut out[place / 8];
        *byte = if flag == 0 { *byte & !bit } else { *byte | bit };
    }

    /// The byte in which the last stretch ended keeps its bits; all others are written whole.
    fn fill(row: &mut [u8], from: usize, to: usize, flag: u8) {
        if from == to {
            return;
        }
        let ones = if flag == 0 { 0 } else { 0xff };
        let (first, last) = (from / 8, (to - 1) / 8);
        let kept = row[first] & !(0xff << (from % 8));
        row[first..=last].fill(ones);
        row[first] = kept | (ones << (from % 8));
        row[last] &= 0xff >> (7 - (to - 1) % 8);
    }
}

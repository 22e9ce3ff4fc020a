//! The layout of cells in memory: a byte or a bit each.
//!
//! Bits hold a single flag: 1 where the flag of the cell is not 0. The first cell along x is the least significant bit of a
//! byte; every row along x starts a new byte, and the unused high bits of its last byte are 0: [`row_bytes`] a row, rows in
//! the order y, then z. NumPy reads it with `np.unpackbits(bytes, axis=-1, count=nx, bitorder='little')` over the last axis.

/// Number of bytes of a row of `nx` cells, a bit each.
pub fn row_bytes(nx: u32) -> u32 {
    nx.div_ceil(8)
}

/// Cells in memory. A slot is the index of a cell in a slice, where rows are padded to whole bytes.
pub(super) trait Packing {
    /// Bytes of whole rows with so many slots.
    fn n_bytes(slots: usize) -> usize;
    /// Slots of a row of `nx` cells.
    fn row(nx: usize) -> usize;
    /// Sets one cell.
    fn put(out: &mut [u8], slot: usize, flag: u8);
    /// Prepares rows of which every cell will be set.
    fn begin(rows: &mut [u8]);
    /// Sets the cells from one slot to another, exclusive, in a row that was prepared.
    fn fill(row: &mut [u8], from: usize, to: usize, flag: u8);
}

/// A byte a cell. With `IN_ZEROS` the memory is all 0 before, and nothing is written where the flag is 0.
pub(super) struct Bytes<const IN_ZEROS: bool>;

impl<const IN_ZEROS: bool> Packing for Bytes<IN_ZEROS> {
    fn n_bytes(slots: usize) -> usize {
        slots
    }

    fn row(nx: usize) -> usize {
        nx
    }

    fn put(out: &mut [u8], slot: usize, flag: u8) {
        out[slot] = flag;
    }

    fn begin(_: &mut [u8]) {}

    fn fill(row: &mut [u8], from: usize, to: usize, flag: u8) {
        if !IN_ZEROS || flag != 0 {
            row[from..to].fill(flag);
        }
    }
}

/// A bit a cell.
pub(super) struct Bits;

impl Packing for Bits {
    fn n_bytes(slots: usize) -> usize {
        slots / 8
    }

    fn row(nx: usize) -> usize {
        nx.next_multiple_of(8)
    }

    fn put(out: &mut [u8], slot: usize, flag: u8) {
        let bit = 1 << (slot % 8);
        let byte = &mut out[slot / 8];
        *byte = if flag == 0 { *byte & !bit } else { *byte | bit };
    }

    fn begin(rows: &mut [u8]) {
        rows.fill(0);
    }

    fn fill(row: &mut [u8], from: usize, to: usize, flag: u8) {
        if flag == 0 || from == to {
            return;
        }
        let (first, last) = (from / 8, (to - 1) / 8);
        let (after, before) = (0xff << (from % 8), 0xff >> (7 - (to - 1) % 8));
        if first == last {
            row[first] |= after & before;
            return;
        }
        row[first] |= after;
        row[first + 1..last].fill(0xff);
        row[last] |= before;
    }
}

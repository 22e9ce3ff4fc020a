//! A facet of a binary STL: twelve f32 (normal, three corners) and a 16-bit attribute word, little-endian, behind a header and a count.

use crate::input::geometry::Facet;

/// Length of header and count, in bytes.
pub(super) const HEADER: usize = 84;
/// Length of a facet, in bytes.
pub(super) const RECORD: usize = 50;

/// Splits a record into normal and corners.
#[inline]
pub(super) fn facet_of(record: &[u8; RECORD]) -> ([f32; 3], Facet) {
    let number =
        |i: usize| f32::from_le_bytes([record[4 * i], record[4 * i + 1], record[4 * i + 2], record[4 * i + 3]]);
    let vector = |i: usize| [number(i), number(i + 1), number(i + 2)];
    (vector(0), [vector(3), vector(6), vector(9)])
}

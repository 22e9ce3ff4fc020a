//! An entry of the list of fractions.

/// The fraction of a cell that a flag has.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Fraction {
    /// Index of the cell: x + nx (y + ny z).
    pub cell: u64,
    /// The fraction: greater than 0, less than 1.
    pub fraction: f32,
    /// The flag.
    pub flag: u8,
}

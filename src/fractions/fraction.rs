//! The fractions of a mesh.

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

/// The fractions of flags in all cells that have more than one.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Fractions {
    /// m: a cell has m x m rays.
    pub rays: u32,
    /// Number of cells of the box on x, y, z.
    pub dims: [u32; 3],
    /// The fractions, in the order of cells, then of flags. Those of a cell add up to 1.
    pub fractions: Vec<Fraction>,
    /// Volume of each flag, 0 to 255, in the box: that of whole cells and of fractions.
    pub volumes: Vec<f64>,
}

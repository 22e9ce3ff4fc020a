//! The fractions of a mesh.

use crate::parallel::*;

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
    /// The fractions, part after part; no cell is in two parts.
    pub(super) parts: Vec<Vec<Fraction>>,
    /// Volume of each flag, 0 to 255, in the box: that of whole cells and of fractions.
    pub volumes: Vec<f64>,
}

impl Fractions {
    /// The fractions, in the order of cells, then of flags. Those of a cell add up to 1.
    pub fn iter(&self) -> impl Iterator<Item = &Fraction> + Clone {
        self.parts.iter().flatten()
    }

    /// Number of fractions.
    pub fn len(&self) -> usize {
        self.parts.iter().map(Vec::len).sum()
    }

    /// Whether no cell has more than one flag.
    pub fn is_empty(&self) -> bool {
        self.parts.iter().all(Vec::is_empty)
    }

    /// Number of cells with more than one flag.
    pub(crate) fn n_cells(&self) -> u64 {
        let of_part = |part: &Vec<Fraction>| part.chunk_by(|one, other| one.cell == other.cell).count() as u64;
        self.parts.par_iter().map(of_part).sum()
    }
}

//! Partial cells: which fraction of a cell each flag has, where a surface cuts it.
//!
//! Frame, rays along x, m -> [`Fractions`]. A cell has m x m rays along x, each in the middle of a square of its face. Where a ray changes from
//! flag to flag is known exactly, and is rounded to 2^-24 of a cell. So a flag has the mean of m x m lengths for its fraction.
//!
//! # Theory
//! Under one square, a ray in its middle has the exact volume where the surface is a plane that ends neither at the near nor at the far face of the cell
//! there. A plane ends along two lines, each over at most 2 m - 1 of the m x m squares, and in a square the middle is off by at most
//! half of its volume. So the fraction of a flag in a cell that one plane cuts is off by less than 1 / m, and on average by far less.
//! Fractions of a cell are multiples of 2^-24 / m^2 before they are rounded to f32, and their sum is 1 exactly.
//!
//! A change from flag to flag adds to one cell, and to all cells behind it. These sums are kept sparsely, column after column, so that cells
//! that no surface cuts cost nothing (`fractions/column.rs`).
//!
//! Cost: a cast of m x m times as many rays as the mesh has along x; 16 bytes for each flag of each cell that is cut.

mod column;
mod faces;
mod fraction;
mod measure;
mod refined;
mod surface;

pub use fraction::{CutSurface, Fraction, Fractions};
#[cfg(not(feature = "stages"))]
pub(crate) use measure::fractions;
#[cfg(feature = "stages")]
pub use measure::fractions;

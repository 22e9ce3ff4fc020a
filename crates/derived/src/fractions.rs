//! Partial cells: which fraction of a cell each flag has, where a surface cuts it.
//!
//! Frame, rays along x, m -> [`Fractions`]. A cell has m x m rays along x, each in the middle of a square of its face. Where a ray changes from
//! flag to flag is known exactly, and is rounded to 2^-24 of a cell. So a flag has the mean of m x m lengths for its fraction.
//!
//! # Theory
//! Let one plane cut a cell. The length before it is a function L over the face, linear, but held between 0 and 1: it has a bend along two lines at most. A line
//! passes at most 2 m - 1 of the m x m squares. Where a square has no bend, its middle has the mean of L. Where it has one, the middle is off by at most 1/4:
//! let c be L in the middle and s the difference of L over the square, were it linear. The mean of the part above 0 is at most `(s / 2 + c)^2 / 2 s`, as L is spread most
//! where it changes along one side, and `s / 2 + c <= 1`. For c <= 0 that is at most 1/4, as `s >= 2 (s / 2 + c)`; for c > 0 the mean exceeds c by less. Where a square has
//! both bends, half of it has at least c, and half at most c, so that the middle is off by at most 1/2. Together that is at most `(2 m - 1) / 2 m^2 < 1 / m`.
//!
//! A plate is what lies below one plane and not below another, so that it is off by less than 2 / m. Of any convex part L is concave where it is above 0, so that the places
//! with L > l are a convex part of the face, for every l. Its border passes at most 4 (m - 1) of the m x m squares, for the way around it goes at most m - 1 squares there and back
//! along each side; where it passes none, a middle decides rightly. So a convex part is off by less than 4 / m, and several by the sum. That holds whether rays meet what lies in the cell, or
//! not: then it is no larger. So all cells through which a surface passes count as cut (`fractions/cut.rs`).
//!
//! Fractions of a cell are multiples of 2^-24 / m^2 before they are rounded to f32, and their sum is 1 exactly.
//!
//! A change from flag to flag adds to one cell, and to all cells behind it. These sums are kept sparsely, column after column, so that cells
//! that no surface cuts cost nothing (`fractions/column.rs`).
//!
//! `fractions/faces.rs` has the fractions of faces, `fractions/surface.rs` the surfaces within cells.
//!
//! Cost: a cast of m x m times as many rays as the mesh has along x; 16 bytes for each flag of each cell that is cut.

mod column;
mod cut;
mod faces;
mod fraction;
mod measure;
mod polygon;
mod refined;
mod surface;
mod volumes;

pub(crate) use column::EXACT_PARTS;
pub use column::parts_of_cell;
pub use fraction::Part;
#[doc(hidden)]
pub use fraction::Totals;
pub(crate) use fraction::rounded_part;
pub use fraction::{CutSurface, Fraction, Fractions};
#[doc(hidden)]
pub use measure::fractions;
pub(crate) use volumes::Volumes;

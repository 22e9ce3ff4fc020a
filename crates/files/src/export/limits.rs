//! Meshes that a format cannot hold.

use hexcast_core::base::error::{Error, Result};
use hexcast_core::grid::lines::Lines;

/// Cell sizes along an axis that differ by less are equal: rounding of f64.
const ROUNDING: f64 = 1e-9;

/// The size of the cells on each axis, for formats that have one.
///
/// # Errors
/// `lines-graded` where cells differ in size.
pub(super) fn equal_cells(lines: &Lines, what: &str) -> Result<[f64; 3]> {
    lines.spacing().ok_or_else(|| {
        let message = format!("cells differ in size, and {what} holds equal ones only");
        Error::new(
            "lines-graded",
            message,
            "mesh without graded lines, or write .vtr or .npz, which hold the lines of each axis",
        )
    })
}

/// The size of the cells, for formats that have one number for all axes.
///
/// # Errors
/// `lines-graded` where cells differ in size, or are no cubes.
pub(super) fn cubes(lines: &Lines, what: &str) -> Result<f64> {
    let [x, y, z] = equal_cells(lines, what)?;
    if [y, z].iter().any(|size| (size / x - 1.0).abs() > ROUNDING) {
        let message = format!("cells are {x:?} x {y:?} x {z:?}, and {what} holds cubes only");
        return Err(Error::new("lines-graded", message, "mesh with --cells or --cell-size, which make cubes"));
    }
    Ok(x)
}

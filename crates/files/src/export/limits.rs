//! Meshes that a format cannot hold.

use hexcast_core::base::error::{Error, Result};
use hexcast_core::grid::lines::Lines;
use hexcast_derived::mesh::Mesh;
use hexcast_derived::mesh::outline::Outline;

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

/// The outline of the one flag that is kept.
///
/// # Errors
/// `job-conflict` where there is none.
pub(super) fn fluid<'a>(mesh: &'a Mesh, keeps: &[bool; 256]) -> Result<&'a Outline> {
    let cells = mesh.columns().cells_per_flag();
    let Some(outline) = mesh.outline() else {
        let message = "cells are to be cut, and the mesh does not know where surfaces cross its lines";
        let hint = "mesh the surfaces with cut_cells.boundary = true, as hexcast mesh does for this output; column files do not hold it";
        return Err(Error::new("job-conflict", message, hint));
    };
    let kept: Vec<u8> = (0..=255).filter(|&flag| keeps[usize::from(flag)] && cells[usize::from(flag)] > 0).collect();
    if kept.iter().any(|&flag| flag != outline.fluid) {
        let kept = kept.iter().map(u8::to_string).collect::<Vec<_>>().join(", ");
        let message =
            format!("flags {kept} are exported, and cut cells are those of one fluid, here of flag {}", outline.fluid);
        return Err(Error::new(
            "job-conflict",
            message,
            "export that flag alone (export_flags), or mesh without cut_cells",
        ));
    }
    Ok(outline)
}

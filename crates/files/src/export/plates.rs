//! The faces of plates, geometries without thickness, for programs whose conductors may be faces.
//!
//! Mesh, flag -> rectangles of cells' faces that together are the plate, each face in one of them: a run of faces along one axis, as long as it
//! goes, that goes on along the other as long as it can. Cost: O(faces) time and memory, but for the order, which they have.

use std::collections::BTreeSet;

use super::electric::{Electric, check_background, substances};
use super::names::said;
use super::options::ExportOptions;
use hexcast_core::base::error::{Error, Result};
use hexcast_derived::mesh::Mesh;

/// The flags that plates have and that are exported.
///
/// # Errors
/// `export-material` where one is not a perfect conductor: of all others a program would need to know the thickness.
pub(super) fn flags(mesh: &Mesh, options: &ExportOptions, what: &str) -> Result<Vec<u8>> {
    let of_plates: BTreeSet<u8> = mesh.plates().iter().map(|plate| plate.flag).collect();
    let flags = options.chosen(of_plates);
    for (flag, Electric { pec, .. }) in substances(mesh.names(), &flags, what)? {
        if !pec {
            let message = format!(
                "{} has no thickness, and {what} holds faces of perfect conductors only",
                said(mesh.names(), flag)
            );
            let hint = "give it pec = true, cells with fill = \"separating\", or leave the flag out (--export-flags)";
            return Err(Error::new("export-material", message, hint));
        }
    }
    Ok(flags)
}

/// Refuses conductors that a program for electromagnetic fields cannot have.
pub(super) fn check_conductors(mesh: &Mesh, options: &ExportOptions, keeps: &[bool; 256], what: &str) -> Result<()> {
    flags(mesh, options, what)?;
    check_background(mesh, keeps, what)
}

/// Rectangles of the faces of a flag: the first line on each axis, and the last, of which those across it are the same.
pub(super) fn rectangles(mesh: &Mesh, flag: u8) -> Vec<[[u32; 3]; 2]> {
    let of_flag = mesh.plates().iter().filter(|plate| plate.flag == flag);
    // by axis, line, and then row by row
    let across = |axis: usize| [[1, 2], [0, 2], [0, 1]][axis];
    let mut left: BTreeSet<(usize, u32, u32, u32)> = of_flag
        .map(|plate| {
            let axis = usize::from(plate.axis);
            let [along, down] = across(axis).map(|of| plate.face[of]);
            (axis, plate.face[axis], down, along)
        })
        .collect();
    let mut all = Vec::new();
    while let Some(&(axis, line, down, along)) = left.first() {
        let n_along = (along..).take_while(|&along| left.contains(&(axis, line, down, along))).count() as u32;
        let row = |down: u32| (along..along + n_along).map(move |along| (axis, line, down, along));
        let n_down = (down..).take_while(|&down| row(down).all(|face| left.contains(&face))).count() as u32;
        (down..down + n_down).flat_map(row).for_each(|face| {
            left.remove(&face);
        });
        let corner = |along: u32, down: u32| {
            let mut corner = [line; 3];
            let [first, second] = across(axis);
            (corner[first], corner[second]) = (along, down);
            corner
        };
        all.push([corner(along, down), corner(along + n_along, down + n_down)]);
    }
    all
}

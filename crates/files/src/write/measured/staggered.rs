//! The flags of a staggered grid, as `.npz`. `docs/staggered.md` describes it.

use std::io;

use crate::write::archive::{Array, write_named};
use crate::write::{Compress, npz};
use hexcast_core::base::error::Result;
use hexcast_derived::mesh::Mesh;
use hexcast_derived::staggered::{COMPONENTS, SheetFace, Staggered};

/// Points that are expanded at a time.
const AT_ONCE: usize = 1 << 24;

/// Writes a NumPy archive: an array `[z, y, x]` of flags for each component and for the cells of the mesh, lines, and the faces of
/// sheets. Returns the number of bytes.
///
/// # Errors
/// `io` where `out` fails, or columns are in a store that does.
pub fn write_staggered(staggered: &Staggered, mesh: &Mesh, compress: Compress, out: &mut dyn io::Write) -> Result<u64> {
    write_named(&arrays(staggered, mesh), "the staggered grid", compress, out)
}

/// The arrays of the archive.
pub fn arrays<'a>(staggered: &'a Staggered, mesh: &'a Mesh) -> Vec<Array<'a>> {
    let components = COMPONENTS.iter().zip(&staggered.points);
    let mut arrays: Vec<Array> = components
        .map(|((name, _), points)| npz::flags(name, points.dims(), AT_ONCE, |some| points.flags(some)))
        .collect();
    arrays.push(npz::flags("cell", mesh.dims(), AT_ONCE, |some| mesh.box_flags(some)));
    arrays.extend(npz::lines(mesh.lines()));
    arrays.push(Array::of_list(("origin", "<i4"), &staggered.origin, |n, out| out.extend((*n as i32).to_le_bytes())));
    let sheet = |named, put| Array::of_list(named, &staggered.sheets, put);
    arrays.extend([
        sheet(("sheet_axis", "|u1"), |sheet: &SheetFace, out: &mut Vec<u8>| out.push(sheet.axis)),
        sheet(("sheet_x", "<u4"), |sheet, out| out.extend(sheet.face[0].to_le_bytes())),
        sheet(("sheet_y", "<u4"), |sheet, out| out.extend(sheet.face[1].to_le_bytes())),
        sheet(("sheet_z", "<u4"), |sheet, out| out.extend(sheet.face[2].to_le_bytes())),
        sheet(("sheet_flag", "|u1"), |sheet, out| out.push(sheet.flag)),
    ]);
    arrays
}

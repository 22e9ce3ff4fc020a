//! The flags of a staggered grid, as `.npz`. `docs/staggered.md` describes it.

use std::io;

use super::archive::Arrays;
use super::{Compress, Sink, archive};
use crate::error::{Error, Result};
use crate::flags::{CellBox, slabs_of_box};
use crate::mesh::Mesh;
use crate::staggered::{COMPONENTS, SheetFace, Staggered};

/// Points that are expanded at a time.
const AT_ONCE: usize = 1 << 24;

/// Writes a NumPy archive: an array `[z, y, x]` of flags for each component and for the cells of the mesh, lines, and the faces of
/// sheets. Returns the number of bytes.
///
/// # Errors
/// `io` where `out` fails, or columns are in a store that does.
pub fn write_staggered(staggered: &Staggered, mesh: &Mesh, compress: Compress, out: &mut dyn io::Write) -> Result<u64> {
    let mut sink = Sink { out, n_bytes: 0, hash: None };
    let all = || (staggered.sheets.len(), staggered.sheets.iter());
    archive::write(compress, &mut sink, |arrays| {
        for ((name, _), points) in COMPONENTS.iter().zip(&staggered.points) {
            put(arrays, name, points.dims(), |some| points.flags(some))?;
        }
        put(arrays, "cell", mesh.dims(), |some| mesh.box_flags(some))?;
        for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
            let lines = mesh.lines.list(axis);
            arrays.list((name, "<f8"), (lines.len(), lines.iter()), |line| line.to_le_bytes())?;
        }
        arrays.list(("sheet_axis", "|u1"), all(), |sheet| [sheet.axis])?;
        for (axis, name) in ["sheet_x", "sheet_y", "sheet_z"].into_iter().enumerate() {
            arrays.list((name, "<u4"), all(), |SheetFace { face, .. }| face[axis].to_le_bytes())?;
        }
        arrays.list(("sheet_flag", "|u1"), all(), |sheet| [sheet.flag])
    })?;
    sink.out.flush().map_err(|error| Error::io("writing the staggered grid", error))?;
    Ok(sink.n_bytes)
}

fn put(
    arrays: &mut Arrays,
    name: &str,
    [nx, ny, nz]: [u32; 3],
    flags: impl Fn(&CellBox) -> Result<Vec<u8>>,
) -> Result<()> {
    arrays.begin(name, "|u1", &format!("({nz}, {ny}, {nx})"))?;
    slabs_of_box(&[0..nx, 0..ny, 0..nz], AT_ONCE).try_for_each(|some| arrays.put(&flags(&some)?))
}

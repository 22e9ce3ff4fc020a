//! The fractions of cells that surfaces cut, as `.npz`. `docs/fractions.md` describes it.

use std::io;

use super::{Compress, Sink, archive};
use crate::error::{Error, Result};
use crate::fractions::Fractions;

/// Writes a NumPy archive of the arrays `cell`, `flag` and `fraction`, an entry for each fraction, and `dims`; `faces` and those of the surfaces
/// where they were asked for. Returns the number of bytes.
///
/// # Errors
/// `io` where `out` fails.
pub fn write_fractions(fractions: &Fractions, compress: Compress, out: &mut dyn io::Write) -> Result<u64> {
    let mut sink = Sink { out, n_bytes: 0, hash: None };
    let (n, all) = (fractions.len(), || fractions.iter());
    archive::write(compress, &mut sink, |arrays| {
        arrays.list(("dims", "<u4"), (3, fractions.dims.iter()), |n| n.to_le_bytes())?;
        arrays.list(("cell", "<u8"), (n, all()), |fraction| fraction.cell.to_le_bytes())?;
        arrays.list(("flag", "|u1"), (n, all()), |fraction| [fraction.flag])?;
        arrays.list(("fraction", "<f4"), (n, all()), |fraction| fraction.fraction.to_le_bytes())?;
        if fractions.has_faces {
            arrays.rows(("faces", "<f4", 6), (n, fractions.faces().flatten()), |of| of.to_le_bytes())?;
        }
        match &fractions.areas {
            Some(_) => write_surfaces(fractions, arrays),
            None => Ok(()),
        }
    })?;
    sink.out.flush().map_err(|error| Error::io("writing the fractions", error))?;
    Ok(sink.n_bytes)
}

/// The arrays of the surfaces within cells.
fn write_surfaces(fractions: &Fractions, arrays: &mut archive::Arrays) -> Result<()> {
    let (n, all) = (fractions.surfaces().count(), || fractions.surfaces());
    arrays.list(("surface_cell", "<u8"), (n, all()), |surface| surface.cell.to_le_bytes())?;
    arrays.list(("surface_geometry", "<i2"), (n, all()), |surface| surface.geometry.to_le_bytes())?;
    arrays.list(("surface_area", "<f4"), (n, all()), |surface| surface.area.to_le_bytes())?;
    let (points, normals) = (all().flat_map(|surface| &surface.point), all().flat_map(|surface| &surface.normal));
    arrays.rows(("surface_point", "<f4", 3), (n, points), |at| at.to_le_bytes())?;
    arrays.rows(("surface_normal", "<f4", 3), (n, normals), |of| of.to_le_bytes())
}

//! Edges and faces outside metal, as `.npz`. `docs/conformal.md` describes it.

use std::io;

use crate::write::archive::{Array, write_named};
use crate::write::{Compress, npz};
use hexcast_core::base::error::Result;
use hexcast_derived::cut_cells::conformal::Conformal;
use hexcast_derived::mesh::Mesh;

/// Fractions that are expanded at a time.
const AT_ONCE: usize = 1 << 21;

/// Writes a NumPy archive: an array `[z, y, x]` of fractions for each component, lines, and the step. Returns the number of bytes.
///
/// # Errors
/// `io` where `out` fails, or columns are in a store that does.
pub fn write_conformal(conformal: &Conformal, mesh: &Mesh, compress: Compress, out: &mut dyn io::Write) -> Result<u64> {
    write_named(&arrays(conformal, mesh), "edges and faces outside metal", compress, out)
}

/// The arrays of the archive.
pub fn arrays<'a>(conformal: &'a Conformal, mesh: &'a Mesh) -> Vec<Array<'a>> {
    let parts = conformal.parts.iter();
    let mut arrays: Vec<Array> = parts
        .map(|part| {
            let bytes = |fractions: Vec<f64>| fractions.iter().flat_map(|fraction| fraction.to_le_bytes()).collect();
            npz::boxes((part.name, "<f8"), part.dims(), AT_ONCE, move |some| part.fractions(some).map(bytes))
        })
        .collect();
    arrays.extend(npz::lines(mesh.lines()));
    arrays.push(Array::of_list(("origin", "<i4"), &conformal.origin, |n, out| out.extend((*n as i32).to_le_bytes())));
    arrays.push(Array::new(("dt_factor", "<f8"), &[], 1, |_| Ok(conformal.dt_factor.to_le_bytes().to_vec())));
    arrays
}

//! Smoothed permittivity, as `.npz`. `docs/tensors.md` describes it.

use std::io;

use crate::write::archive::{Array, write_named};
use crate::write::{Compress, npz};
use hexcast_core::base::error::Result;
use hexcast_derived::cut_cells::tensors::{Tensor, Tensors};
use hexcast_derived::mesh::Mesh;

/// Points that are expanded at a time.
const AT_ONCE: usize = 1 << 19;

/// Writes a NumPy archive: an array `[z, y, x, 6]` of tensors for each component of E, and lines. Returns the number of bytes.
///
/// # Errors
/// `io` where `out` fails, or columns are in a store that does.
pub fn write_tensors(tensors: &Tensors, mesh: &Mesh, compress: Compress, out: &mut dyn io::Write) -> Result<u64> {
    write_named(&arrays(tensors, mesh), "smoothed permittivity", compress, out)
}

/// The arrays of the archive.
pub fn arrays<'a>(tensors: &'a Tensors, mesh: &'a Mesh) -> Vec<Array<'a>> {
    let parts = tensors.parts.iter();
    let mut arrays: Vec<Array> = parts
        .map(|part| {
            let bytes = |of: Vec<Tensor>| of.iter().flatten().flat_map(|number| number.to_le_bytes()).collect();
            let bytes = move |some: &_| part.tensors(some).map(bytes);
            npz::several_in_boxes((part.name, "<f8"), (part.dims(), &[6]), AT_ONCE, bytes)
        })
        .collect();
    arrays.extend(npz::lines(mesh.lines()));
    arrays.push(Array::of_list(("origin", "<i4"), &tensors.origin, |n, out| out.extend((*n as i32).to_le_bytes())));
    arrays
}

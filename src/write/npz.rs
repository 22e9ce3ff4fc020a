//! `.npz`: the flags and the lines of each axis as NumPy arrays in a ZIP archive.
//!
//! `flag` has the shape (nz, ny, nx) and the type uint8, as in `.npy`; `x`, `y` and `z` have all lines of their axis, cells + 1 numbers of
//! the type float64. Cost: two slabs of memory.

use super::{Options, Sink, archive, npy, ordered};
use crate::control::Control;
use crate::error::Result;
use crate::lines::AXES;
use crate::mesh::Mesh;

/// Writes the archive: the lines, then the flags.
pub(super) fn write(mesh: &Mesh, options: &Options, sink: &mut Sink, control: &Control) -> Result<()> {
    archive::write(options.compress, sink, |arrays| {
        for (axis, name) in AXES.into_iter().enumerate() {
            let lines = mesh.lines.list(axis);
            arrays.list((name, "<f8"), (lines.len(), lines.iter()), |line| line.to_le_bytes())?;
        }
        arrays.begin_with("flag", &npy::header(mesh.dims(), options))?;
        ordered::for_each_slab(mesh, options, control, |flags| arrays.put(flags))
    })
}

//! `.npz`: the flags and the lines of each axis as NumPy arrays in a ZIP archive.
//!
//! `flag` has the shape (nz, ny, nx), or on request (nx, ny, nz), and the type uint8, as in `.npy`; `x`, `y` and `z` have all lines of their axis, cells + 1 numbers of
//! the type float64. Cost: two slabs of memory.

use super::archive::{Archive, Array, Buffer};
use super::{Options, Sink, npy, ordered};
use hexcast_core::base::control::Control;
use hexcast_core::base::error::Result;
use hexcast_core::cells::flags::{CellBox, slabs_of_box};
use hexcast_core::grid::lines::{AXES, Lines};
use hexcast_derived::mesh::Mesh;

/// The lines of each axis.
pub(super) fn lines(lines: &Lines) -> [Array<'_>; 3] {
    [0, 1, 2].map(|axis: usize| {
        let all = move |_| Ok(lines.list(axis).iter().flat_map(|line| line.to_le_bytes()).collect());
        Array::new((AXES[axis], "<f8"), &[u64::from(lines.dims()[axis]) + 1], 1, all)
    })
}

/// Flags of a box of so many cells, some of them at a time.
pub(super) fn flags<'a>(
    name: &'static str,
    dims: [u32; 3],
    cells_at_once: usize,
    flags: impl Fn(&CellBox) -> Result<Vec<u8>> + 'a,
) -> Array<'a> {
    boxes((name, "|u1"), dims, cells_at_once, flags)
}

/// Numbers of a type for a box of so many cells, some of them at a time, by their bytes.
pub(super) fn boxes<'a>(
    named: (&'static str, &'static str),
    [nx, ny, nz]: [u32; 3],
    cells_at_once: usize,
    bytes: impl Fn(&CellBox) -> Result<Vec<u8>> + 'a,
) -> Array<'a> {
    several_in_boxes(named, ([nx, ny, nz], &[]), cells_at_once, bytes)
}

/// The same with several numbers a cell, of this shape.
pub(super) fn several_in_boxes<'a>(
    named: (&'static str, &'static str),
    ([nx, ny, nz], of_one): ([u32; 3], &[u64]),
    cells_at_once: usize,
    bytes: impl Fn(&CellBox) -> Result<Vec<u8>> + 'a,
) -> Array<'a> {
    let slabs: Vec<CellBox> = slabs_of_box(&[0..nx, 0..ny, 0..nz], cells_at_once).collect();
    let shape = [&[nz, ny, nx].map(u64::from), of_one].concat();
    Array::new(named, &shape, slabs.len(), move |index| bytes(&slabs[index]))
}

/// Writes the archive.
pub(super) async fn write(mesh: &Mesh, options: &Options, sink: &mut Sink<'_>, control: &Control) -> Result<()> {
    let mut archive = Archive::new(options.compress, Buffer::default());
    for array in &lines(mesh.lines()) {
        archive.add(array, sink, control).await?;
    }
    let mut entry = archive.begin("flag", &npy::header(mesh.dims(), options))?;
    ordered::for_each_slab(mesh, options, control, &mut |flags| entry.pass(flags, sink)).await?;
    entry.end()?;
    sink.put(&archive.finish()?)
}

//! Signed distances, one number a cell or node: `.npz`, and with [`Cells`](crate::write::cells::Cells) `.vti` and `.vtr` (array `distance`, Float64), `.npy` of shape (nz, ny, nx), or a
//! Zarr store. `docs/distance.md` describes them.

use std::io;

use serde_json::json;

use crate::write::archive::{Array, write_named};
use crate::write::store::{OfBox, OfCells};
use crate::write::{Compress, npz};
use hexcast_core::base::error::{Error, Result};
use hexcast_core::cells::columns::Columns;
use hexcast_core::cells::flags::CellBox;
use hexcast_derived::distance::Distance;
use hexcast_derived::mesh::Mesh;

/// Distances that are made at a time; in wasm few, so that there is a rest between them.
const AT_ONCE: usize = if cfg!(target_arch = "wasm32") { 1 << 19 } else { 1 << 22 };

/// Writes a NumPy archive: `distance` `[z, y, x]`, lines, and up to which width distances are known. Returns the number of bytes.
///
/// # Errors
/// `io` where `out` fails, or flags are in a store that does.
pub fn write_distance(distance: &Distance, mesh: &Mesh, compress: Compress, out: &mut dyn io::Write) -> Result<u64> {
    write_named(&arrays(distance, mesh), "the distances", compress, out)
}

/// The arrays of the archive.
pub fn arrays<'a>(distance: &'a Distance, mesh: &'a Mesh) -> Vec<Array<'a>> {
    let mut arrays = vec![npz::boxes(("distance", "<f8"), distance.dims(), AT_ONCE, |some| bytes(distance, some))];
    arrays.extend(npz::lines(mesh.lines()));
    arrays.push(Array::of_list(("origin", "<i4"), &distance.origin, |n, out| out.extend((*n as i32).to_le_bytes())));
    arrays.push(Array::new(("width", "<f8"), &[], 1, |_| Ok(distance.width.to_le_bytes().to_vec())));
    arrays
}

/// The numbers of a box.
pub(in crate::write) fn bytes(distance: &Distance, some: &CellBox) -> Result<Vec<u8>> {
    Ok(distance.distances(some)?.iter().flat_map(|number| number.to_le_bytes()).collect())
}

/// The numbers of a store.
///
/// # Errors
/// `job-conflict` where mesh and distances are not of the same box, or they are those of nodes.
pub(crate) fn cells_of_store<'a>(mesh: &Mesh, distance: &'a Distance) -> Result<OfCells<'a>> {
    check_dims(mesh, distance)?;
    if distance.of_nodes {
        let message = "a Zarr store holds numbers of cells, and the distances are those of nodes";
        return Err(Error::new("job-conflict", message, "ask for those at centres, or write .npz, .npy, .vti or .vtr"));
    }
    let of_box = OfBox::Numbers(Box::new(move |_: &Columns, cells: &CellBox| bytes(distance, cells)));
    Ok(OfCells { name: "distance", numbers: ("float64", json!(0.0), size_of::<f64>()), rays: None, of_box })
}

/// Refuses distances of another box than that of the mesh.
pub(in crate::write) fn check_dims(mesh: &Mesh, distance: &Distance) -> Result<()> {
    let more = u32::from(distance.of_nodes);
    let expected = mesh.dims().map(|n| n + more);
    if distance.dims() == expected {
        return Ok(());
    }
    let message = format!("the mesh has {expected:?} points, and distances are those of {:?}", distance.dims());
    Err(Error::new("job-conflict", message, "use mesh and distances of one job"))
}

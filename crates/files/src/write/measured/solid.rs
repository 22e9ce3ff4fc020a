//! The fraction of every cell that is not background: `.vti` and `.vtr` with the array `solid` (Float32), `.npy` of shape (nz, ny, nx), or `.zarr.zip`.
//!
//! Cells without fractions have 0 or 1 by their flag, which is that of their centre: a wall between the rays is seen there and not in the volumes of the report.
//! Cells that surfaces cut have the sum of the fractions of flags that are not 0. Cost: two slabs of memory, and what `.vti` takes.

use serde_json::json;

use crate::write::store::{OfBox, OfCells};
use hexcast_core::base::error::{Error, Result};
use hexcast_core::cells::columns::Columns;
use hexcast_core::cells::flags::{CellBox, flags_of_box};
use hexcast_derived::fractions::Fractions;
use hexcast_derived::mesh::Mesh;

/// The numbers of consecutive cells, the first of which has this index, by their flags.
pub(in crate::write) fn bytes(flags: &[u8], first: u64, fractions: &Fractions) -> Vec<u8> {
    solid(flags, first, fractions).flat_map(f32::to_le_bytes).collect()
}

/// The numbers of a store.
///
/// # Errors
/// `job-conflict` where mesh and fractions are not of the same box.
pub(crate) fn cells_of_store<'a>(mesh: &Mesh, fractions: &'a Fractions) -> Result<OfCells<'a>> {
    check_dims(mesh, fractions)?;
    let [nx, ny, _] = mesh.dims().map(u64::from);
    let of_box = move |columns: &Columns, cells: &CellBox| {
        let [across, down, up] = cells;
        let flags = flags_of_box(columns, cells)?;
        let rows = up.clone().flat_map(|z| down.clone().map(move |y| u64::from(y) + ny * u64::from(z)));
        let firsts = rows.map(|row| u64::from(across.start) + nx * row);
        let rows = firsts.zip(flags.chunks_exact(across.len()));
        Ok(rows.flat_map(|(first, row)| solid(row, first, fractions).flat_map(f32::to_le_bytes)).collect())
    };
    let numbers = ("float32", json!(0.0), size_of::<f32>());
    Ok(OfCells {
        name: "solid",
        numbers,
        rays: (fractions.rays > 0).then_some(fractions.rays),
        of_box: OfBox::Numbers(Box::new(of_box)),
    })
}

/// The fraction that is not background of consecutive cells, the first of which has this index, by their flags.
fn solid(flags: &[u8], first: u64, fractions: &Fractions) -> impl Iterator<Item = f32> {
    let mut cut = fractions.from_cell(first).peekable();
    (first..).zip(flags).map(move |(cell, &flag)| {
        if cut.peek().is_none_or(|cut| cut.cell != cell) {
            return f32::from(u8::from(flag != 0));
        }
        let mut sum = 0.0;
        while let Some(cut) = cut.next_if(|cut| cut.cell == cell) {
            sum += if cut.flag == 0 { 0.0 } else { f64::from(cut.fraction) };
        }
        sum.min(1.0) as f32
    })
}

/// Refuses fractions of another box than that of the mesh, and a mesh of which only the cells within a halo are measured.
pub(in crate::write) fn check_dims(mesh: &Mesh, fractions: &Fractions) -> Result<()> {
    if fractions.halo > 0 {
        let message = format!("the mesh has a halo of {} cells, whose fractions are not measured", fractions.halo);
        return Err(Error::new(
            "job-conflict",
            message,
            "leave out halo (--halo), or write .npz, which lists cut cells",
        ));
    }
    if mesh.dims() == fractions.dims {
        return Ok(());
    }
    let message = format!("the mesh has {:?} cells, and fractions are those of {:?}", mesh.dims(), fractions.dims);
    Err(Error::new("job-conflict", message, "use mesh and fractions of one job"))
}

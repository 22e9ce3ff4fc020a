//! The fraction of every cell that is not background: `.vti` and `.vtr` with the array `solid` (Float32), or `.npy` of shape (nz, ny, nx).
//!
//! Cells without fractions have 0 or 1 by their flag, which is that of their centre: a wall between the rays is seen there and not in the volumes of the report.
//! Cells that surfaces cut have the sum of the fractions of flags that are not 0. Cost: two slabs of memory, and
//! what `.vti` takes.

use std::io;

use super::{Compress, Format, Options, Sink, check, check_lines, npy, vti};
use crate::control::Control;
use crate::error::{Error, Result};
use crate::fractions::Fractions;
use crate::mesh::Mesh;

/// Writes the fraction of every cell that is not background, as 32-bit floating point, x fastest. Returns the number of bytes.
///
/// # Errors
/// `job-conflict` where mesh and fractions are not of the same box, the mesh has a halo, or the format is none of `.vti`, `.vtr` and `.npy`; `lines-graded` for `.vti`
/// where cells differ in size; `job-value` where the compression level is not 1 to 9; `io` where `out` fails; `cancelled`.
pub fn write_solid(
    mesh: &Mesh,
    fractions: &Fractions,
    (format, options): (Format, &Options),
    out: &mut dyn io::Write,
    control: &Control,
) -> Result<u64> {
    check_dims(mesh, fractions)?;
    if !matches!(format, Format::Vti | Format::Vtr | Format::Npy) {
        let message = format!(".{} does not hold fractions of cells", format.extension());
        return Err(Error::new("job-conflict", message, "use .vti, .vtr or .npy"));
    }
    check(format, options)?;
    check_lines(mesh, format)?;
    let mut sink = Sink { out, n_bytes: 0, hash: None };
    // a number has four bytes
    let slab_bytes = options.slab_bytes / 4;
    let each = |put: &mut dyn FnMut(&[u8]) -> Result<()>| {
        let mut cell = 0;
        mesh.for_each_slab(slab_bytes, control, |flags| {
            let bytes: Vec<u8> = solid(flags, cell, fractions).flat_map(f32::to_le_bytes).collect();
            cell += flags.len() as u64;
            put(&bytes)
        })
    };
    let n_bytes = 4 * mesh.n_cells();
    let array = vti::Array { name: "solid", kind: "Float32", n_bytes, each: Box::new(each) };
    match (format, options.compress) {
        (Format::Npy, _) => {
            let [nx, ny, nz] = mesh.dims();
            sink.put(&npy::header_of("<f4", &format!("({nz}, {ny}, {nx})")))?;
            (array.each)(&mut |bytes| sink.put(bytes))?;
        }
        (_, Compress::None) => vti::write_plain(mesh, &array, format, &mut sink)?,
        (_, Compress::Zlib(level)) => vti::write(mesh, &array, (format, level), options, &mut sink)?,
    }
    sink.out.flush().map_err(|error| Error::io("writing the fractions", error))?;
    Ok(sink.n_bytes)
}

/// The fraction that is not background of consecutive cells, the first of which has this index, by their flags.
pub(super) fn solid(flags: &[u8], first: u64, fractions: &Fractions) -> impl Iterator<Item = f32> {
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
pub(super) fn check_dims(mesh: &Mesh, fractions: &Fractions) -> Result<()> {
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

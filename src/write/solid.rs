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
/// `job-conflict` where mesh and fractions are not of the same box, or the format is none of `.vti`, `.vtr` and `.npy`; `lines-graded` for `.vti`
/// where cells differ in size; `job-value` where the compression level is not 1 to 9; `io` where `out` fails; `cancelled`.
pub fn write_solid(
    mesh: &Mesh,
    fractions: &Fractions,
    (format, options): (Format, &Options),
    out: &mut dyn io::Write,
    control: &Control,
) -> Result<u64> {
    if mesh.dims() != fractions.dims {
        let message = format!("the mesh has {:?} cells, and fractions are those of {:?}", mesh.dims(), fractions.dims);
        return Err(Error::new("job-conflict", message, "use mesh and fractions of one job"));
    }
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
        let mut solid = Solid { cell: 0, cut: fractions.iter().peekable() };
        mesh.for_each_slab(slab_bytes, control, |flags| put(&solid.of(flags)))
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

/// Where we are among the cells.
struct Solid<'a, I: Iterator<Item = &'a crate::fractions::Fraction>> {
    cell: u64,
    cut: std::iter::Peekable<I>,
}

impl<'a, I: Iterator<Item = &'a crate::fractions::Fraction>> Solid<'a, I> {
    /// The bytes of the next cells.
    fn of(&mut self, flags: &[u8]) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(4 * flags.len());
        for &flag in flags {
            let mut solid = f32::from(u8::from(flag != 0));
            if self.cut.peek().is_some_and(|cut| cut.cell == self.cell) {
                let mut sum = 0.0;
                while let Some(cut) = self.cut.next_if(|cut| cut.cell == self.cell) {
                    sum += if cut.flag == 0 { 0.0 } else { f64::from(cut.fraction) };
                }
                solid = sum.min(1.0) as f32;
            }
            bytes.extend_from_slice(&solid.to_le_bytes());
            self.cell += 1;
        }
        bytes
    }
}

//! `.npz`: the flags and the lines of each axis as NumPy arrays in a ZIP archive, as `numpy.savez` writes them.
//!
//! `flag` has the shape (nz, ny, nx) and the type uint8, as in `.npy`; `x`, `y` and `z` have all lines of their axis, cells + 1 numbers of
//! the type float64. Entries are stored, or deflated. Sizes are 64-bit, so that nothing ends at 4 GiB, and follow the data, so that nothing
//! is written twice. Source: NumPy's `numpy.lib.npyio`, PKWARE's APPNOTE. Cost: two slabs of memory.

use std::io::{self, Write};

use zip::write::{SimpleFileOptions, StreamWriter};
use zip::{CompressionMethod, DateTime, ZipWriter};

use super::{Compress, Options, Sink, npy};
use crate::control::Control;
use crate::error::{Error, Result};
use crate::mesh::Mesh;

/// Writes the archive.
pub(super) fn write(mesh: &Mesh, options: &Options, sink: &mut Sink, control: &Control) -> Result<()> {
    let method = match options.compress {
        Compress::None => SimpleFileOptions::default().compression_method(CompressionMethod::Stored),
        Compress::Zlib(level) => SimpleFileOptions::default()
            .compression_method(CompressionMethod::Deflated)
            .compression_level(Some(level.into())),
    };
    // the same bytes whenever they are written
    let method = method.large_file(true).last_modified_time(DateTime::default());
    let mut archive = ZipWriter::new_stream(Through(sink));
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        let lines = mesh.lines.list(axis);
        start(&mut archive, name, method)?;
        put(&mut archive, &npy::header_of("<f8", &format!("({},)", lines.len())))?;
        put(&mut archive, &lines.iter().flat_map(|line| line.to_le_bytes()).collect::<Vec<u8>>())?;
    }
    start(&mut archive, "flag", method)?;
    put(&mut archive, &npy::header(mesh.dims(), false))?;
    mesh.for_each_slab(options.slab_bytes, control, |flags| put(&mut archive, flags))?;
    archive.finish().map_err(failed)?;
    Ok(())
}

type Archive<'a, 'b> = ZipWriter<StreamWriter<Through<'a, 'b>>>;

fn start(archive: &mut Archive, name: &str, options: SimpleFileOptions) -> Result<()> {
    archive.start_file(format!("{name}.npy"), options).map_err(failed)
}

fn put(archive: &mut Archive, bytes: &[u8]) -> Result<()> {
    archive.write_all(bytes).map_err(|error| Error::io("writing the mesh", error))
}

fn failed(error: zip::result::ZipError) -> Error {
    Error::io("writing the mesh", io::Error::other(error))
}

/// A sink as an output.
struct Through<'a, 'b>(&'a mut Sink<'b>);

impl Write for Through<'_, '_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.put(bytes).map_err(io::Error::other)?;
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

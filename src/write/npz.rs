//! `.npz`: the flags and the lines of each axis as NumPy arrays in a ZIP archive, as `numpy.savez` writes them.
//!
//! `flag` has the shape (nz, ny, nx) and the type uint8, as in `.npy`; `x`, `y` and `z` have all lines of their axis, cells + 1 numbers of
//! the type float64. Entries are stored, or deflated. Sizes are 64-bit, so that nothing ends at 4 GiB, and follow the data, so that nothing
//! is written twice. Source: NumPy's `numpy.lib.npyio`, PKWARE's APPNOTE. Cost: two slabs of memory.

use std::cell::RefCell;
use std::io::{self, Write};

use zip::write::{SimpleFileOptions, StreamWriter};
use zip::{CompressionMethod, DateTime, ZipWriter};

use super::{Compress, Options, Sink, npy, ordered};
use crate::control::Control;
use crate::error::{Error, Result};
use crate::lines::AXES;
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
    let failure = RefCell::new(None);
    {
        let mut archive = ZipWriter::new_stream(Through { sink, failure: &failure });
        match entries(&mut archive, &failure, mesh, (options, method), control) {
            Ok(()) => {
                archive.finish().map_err(failed)?;
            }
            // an archive that is given up ends itself: that reaches nobody
            Err(error) => {
                failure.borrow_mut().get_or_insert(error);
            }
        }
    }
    failure.into_inner().map_or(Ok(()), Err)
}

type Archive<'a, 'b> = ZipWriter<StreamWriter<Through<'a, 'b>>>;
type Failure = RefCell<Option<Error>>;

/// Writes the lines, then the flags.
fn entries(
    archive: &mut Archive,
    failure: &Failure,
    mesh: &Mesh,
    (options, method): (&Options, SimpleFileOptions),
    control: &Control,
) -> Result<()> {
    for (axis, name) in AXES.into_iter().enumerate() {
        let lines = mesh.lines.list(axis);
        archive.start_file(format!("{name}.npy"), method).map_err(failed)?;
        put(archive, failure, &npy::header_of("<f8", &format!("({},)", lines.len())))?;
        put(archive, failure, &lines.iter().flat_map(|line| line.to_le_bytes()).collect::<Vec<u8>>())?;
    }
    archive.start_file("flag.npy", method).map_err(failed)?;
    put(archive, failure, &npy::header(mesh.dims(), options))?;
    ordered::for_each_slab(mesh, options, control, |flags| put(archive, failure, flags))
}

fn put(archive: &mut Archive, failure: &Failure, bytes: &[u8]) -> Result<()> {
    archive.write_all(bytes).map_err(|error| Error::io("writing the mesh", error))?;
    failure.borrow().clone().map_or(Ok(()), Err)
}

fn failed(error: zip::result::ZipError) -> Error {
    Error::io("writing the mesh", io::Error::other(error))
}

/// A sink as an output. It keeps its first error, and takes nothing from then on.
struct Through<'a, 'b> {
    sink: &'a mut Sink<'b>,
    failure: &'a Failure,
}

impl Write for Through<'_, '_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let mut failure = self.failure.borrow_mut();
        if failure.is_none() {
            *failure = self.sink.put(bytes).err();
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

//! A ZIP archive of NumPy arrays, as `numpy.savez` writes them: what `.npz` files are.
//!
//! Entries are stored, or deflated. Sizes are 64-bit, so that nothing ends at 4 GiB, and follow the data, so that nothing
//! is written twice. Source: NumPy's `numpy.lib.npyio`, PKWARE's APPNOTE.

use std::cell::RefCell;
use std::io::{self, Write};

use zip::write::{SimpleFileOptions, StreamWriter};
use zip::{CompressionMethod, DateTime, ZipWriter};

use super::{Compress, Sink, npy};
use crate::error::{Error, Result};

type Failure = RefCell<Option<Error>>;

/// The arrays of an archive, one after the other.
pub(super) struct Arrays<'a, 'b, 'c> {
    archive: &'c mut ZipWriter<StreamWriter<Through<'a, 'b>>>,
    failure: &'a Failure,
    method: SimpleFileOptions,
}

impl Arrays<'_, '_, '_> {
    /// Begins an array: its name, its type as NumPy names it, and its shape, such as `(3, 4)` or `(5,)`.
    ///
    /// # Errors
    /// `io`.
    pub(super) fn begin(&mut self, name: &str, kind: &str, shape: &str) -> Result<()> {
        self.begin_with(name, &npy::header_of(kind, shape))
    }

    /// Begins an array with a header that is made.
    ///
    /// # Errors
    /// `io`.
    pub(super) fn begin_with(&mut self, name: &str, header: &[u8]) -> Result<()> {
        self.archive.start_file(format!("{name}.npy"), self.method).map_err(failed)?;
        self.put(header)
    }

    /// Writes more of the array.
    ///
    /// # Errors
    /// `io`.
    pub(super) fn put(&mut self, bytes: &[u8]) -> Result<()> {
        self.archive.write_all(bytes).map_err(|error| Error::io("writing the mesh", error))?;
        self.failure.borrow().clone().map_or(Ok(()), Err)
    }

    /// Writes a whole array of one axis, some of it at a time.
    ///
    /// # Errors
    /// `io`.
    pub(super) fn list<'i, T: 'i, const N: usize>(
        &mut self,
        (name, kind): (&str, &str),
        (n, items): (usize, impl Iterator<Item = &'i T>),
        bytes: impl Fn(&T) -> [u8; N],
    ) -> Result<()> {
        self.begin(name, kind, &format!("({n},)"))?;
        self.put_all(items, bytes)
    }

    /// Writes a whole array of so many numbers a row.
    ///
    /// # Errors
    /// `io`.
    pub(super) fn rows<'i, T: 'i, const N: usize>(
        &mut self,
        (name, kind, of_row): (&str, &str, usize),
        (n, items): (usize, impl Iterator<Item = &'i T>),
        bytes: impl Fn(&T) -> [u8; N],
    ) -> Result<()> {
        self.begin(name, kind, &format!("({n}, {of_row})"))?;
        self.put_all(items, bytes)
    }

    fn put_all<'i, T: 'i, const N: usize>(
        &mut self,
        items: impl Iterator<Item = &'i T>,
        bytes: impl Fn(&T) -> [u8; N],
    ) -> Result<()> {
        let mut some = Vec::with_capacity(AT_ONCE + N);
        for item in items {
            some.extend_from_slice(&bytes(item));
            if some.len() >= AT_ONCE {
                self.put(&some)?;
                some.clear();
            }
        }
        self.put(&some)
    }
}

/// Bytes of a list that are written at a time.
const AT_ONCE: usize = 1 << 18;

/// Writes an archive of the arrays that `fill` hands over.
///
/// # Errors
/// `io`; whatever `fill` returns.
pub(super) fn write(compress: Compress, sink: &mut Sink, fill: impl FnOnce(&mut Arrays) -> Result<()>) -> Result<()> {
    let method = match compress {
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
        match fill(&mut Arrays { archive: &mut archive, failure: &failure, method }) {
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

//! HDF5 files, written a part at a time.
//!
//! By crate `rust-hdf5`: pure Rust, and it writes slices of a dataset as they come. `hdf5-pure` holds whole datasets; it streams MATLAB's files
//! alone. A chunk is compressed when it is whole, so slices are those of whole chunks. HDF5 is not written from its first byte to its last: it
//! needs a place where it can go back, not a writer.

use std::io;

use rust_hdf5::{H5Dataset, H5File, H5Type};

use super::output::{Files, failed};
use crate::error::{Error, Result};
use crate::write::Compress;

/// Bytes of a chunk, about: readers hold 1 MiB of chunks by default.
const CHUNK_BYTES: usize = 1 << 19;

pub(super) fn wrong(error: rust_hdf5::Hdf5Error) -> Error {
    failed(io::Error::other(error.to_string()))
}

pub(super) fn create(files: &mut dyn Files, name: &str) -> Result<H5File> {
    H5File::create(files.place(name)?).map_err(wrong)
}

pub(super) fn finish(file: H5File) -> Result<()> {
    file.close_no_sync().map_err(wrong)
}

/// A dataset in chunks of this shape.
pub(super) fn dataset<T: H5Type>(
    file: &H5File,
    name: &str,
    shape: &[usize],
    chunk: &[usize],
    compress: Compress,
) -> Result<H5Dataset> {
    let new = file.new_dataset::<T>().shape(shape).chunk(chunk);
    let new = match compress {
        Compress::None => new,
        Compress::Zlib(level) => new.deflate(level.into()),
    };
    new.create(name).map_err(wrong)
}

/// Rows of a chunk of rows of so many bytes.
pub(super) fn chunk_rows(row_bytes: usize, n_rows: usize) -> usize {
    (CHUNK_BYTES / row_bytes.max(1)).clamp(1, n_rows.max(1))
}

/// A table that is written row by row.
pub(super) struct Table<T: H5Type> {
    dataset: H5Dataset,
    width: usize,
    chunk_rows: usize,
    n_written: usize,
    rows: Vec<T>,
}

impl<T: H5Type> Table<T> {
    /// A table of so many rows; of one column it is a list.
    pub(super) fn new(file: &H5File, name: &str, n_rows: usize, width: usize, compress: Compress) -> Result<Table<T>> {
        let chunk_rows = chunk_rows(width * size_of::<T>(), n_rows);
        let n = if width == 1 { 1 } else { 2 };
        let dataset = dataset::<T>(file, name, &[n_rows, width][..n], &[chunk_rows, width][..n], compress)?;
        Ok(Table { dataset, width, chunk_rows, n_written: 0, rows: Vec::new() })
    }

    /// Adds a row.
    pub(super) fn push(&mut self, row: &[T]) -> Result<()> {
        self.rows.extend_from_slice(row);
        if self.rows.len() == self.chunk_rows * self.width { self.write() } else { Ok(()) }
    }

    /// Writes the rows that are held; all of them are then in the file.
    pub(super) fn finish(mut self) -> Result<()> {
        if self.rows.is_empty() { Ok(()) } else { self.write() }
    }

    fn write(&mut self) -> Result<()> {
        let n = self.rows.len() / self.width;
        let (starts, counts) = ([self.n_written, 0], [n, self.width]);
        let axes = if self.width == 1 { 1 } else { 2 };
        self.dataset.write_slice(&starts[..axes], &counts[..axes], &self.rows).map_err(wrong)?;
        self.n_written += n;
        self.rows.clear();
        Ok(())
    }
}

//! HDF5 to a path, chunk by chunk. A chunk is compressed when it is whole, so whole chunks are written.

pub(crate) use rust_hdf5::H5Type as Item;
use rust_hdf5::{FileLocking, H5Dataset, H5File};

use super::{Shape, failed};
use crate::export::output::Files;
use crate::write::Compress;
use hexcast_core::base::error::Result;

/// A file being written.
pub(crate) struct File {
    /// None once it is closed.
    file: Option<H5File>,
}

impl File {
    /// Begins a file, whose datasets will have so many bytes.
    pub(crate) fn create(files: &mut dyn Files, name: &str, _n_bytes: u64) -> Result<File> {
        // the caller may hold a lock of its own
        let options = H5File::options().locking(FileLocking::Disabled);
        Ok(File { file: Some(options.create(files.place(name)?).map_err(failed)?) })
    }

    fn open(&self) -> Result<&H5File> {
        self.file.as_ref().ok_or_else(|| failed("the file is closed"))
    }

    /// Adds an attribute.
    pub(crate) fn text(&mut self, name: &str, value: &str) -> Result<()> {
        self.open()?.set_attr_string(name, value).map_err(failed)
    }

    /// Adds an attribute of numbers.
    pub(crate) fn numbers(&mut self, name: &str, values: &[f64]) -> Result<()> {
        self.open()?.set_attr_array_numeric(name, values).map_err(failed)
    }

    /// Adds a dataset of strings.
    pub(crate) fn texts(&mut self, name: &str, values: &[&str]) -> Result<()> {
        self.open()?.write_vlen_strings(name, values).map(|_| ()).map_err(failed)
    }

    /// Ends the file.
    pub(crate) fn finish(mut self, _files: &mut dyn Files) -> Result<()> {
        self.open()?.flush().map_err(failed)?;
        self.file.take().map_or(Ok(()), H5File::close_no_sync).map_err(failed)
    }
}

/// Where it could not be written: the crate prints what goes wrong with a file that is not closed.
impl Drop for File {
    fn drop(&mut self) {
        let _ = self.file.take().map(H5File::close_no_sync);
    }
}

/// A dataset being written.
pub(crate) struct Table<T: Item> {
    dataset: H5Dataset,
    dims: Vec<usize>,
    chunk_rows: usize,
    /// Rows that are in the file, and the items of those that are not.
    n_written: usize,
    items: Vec<T>,
}

impl<T: Item> Table<T> {
    /// Begins a dataset.
    pub(crate) fn new(file: &mut File, shape: Shape) -> Result<Table<T>> {
        let chunk = shape.chunk(size_of::<T>());
        let new = file.open()?.new_dataset::<T>().shape(shape.dims).chunk(&chunk);
        let new = match shape.compress {
            Compress::None => new,
            Compress::Zlib(level) => new.deflate(level.into()),
        };
        let dataset = new.create(shape.name).map_err(failed)?;
        Ok(Table { dataset, dims: shape.dims.to_vec(), chunk_rows: chunk[0], n_written: 0, items: Vec::new() })
    }

    /// Adds items behind those before, the last axis fastest: whole rows of the first axis.
    pub(crate) fn push(&mut self, items: &[T]) -> Result<()> {
        self.items.extend_from_slice(items);
        let n = self.items.len() / self.row();
        if n >= self.chunk_rows { self.write(n - n % self.chunk_rows) } else { Ok(()) }
    }

    /// Ends the dataset; all items are then in the file.
    pub(crate) fn finish(mut self, _file: &mut File) -> Result<()> {
        if self.items.is_empty() { Ok(()) } else { self.write(self.items.len() / self.row()) }
    }

    /// Items of a row of the first axis.
    fn row(&self) -> usize {
        self.dims[1..].iter().product()
    }

    /// Writes the first of the rows that are held.
    fn write(&mut self, n: usize) -> Result<()> {
        let (mut starts, mut counts) = (vec![0; self.dims.len()], self.dims.clone());
        (starts[0], counts[0]) = (self.n_written, n);
        let n_items = n * self.row();
        self.dataset.write_slice(&starts, &counts, &self.items[..n_items]).map_err(failed)?;
        self.items.drain(..n_items);
        self.n_written += n;
        Ok(())
    }
}

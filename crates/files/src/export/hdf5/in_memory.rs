//! HDF5 held in memory, and written from its first byte to its last when it ends. Without compression datasets have no chunks.

pub(crate) use hdf5_pure::H5Element as Item;
use hdf5_pure::{AttrValue, FileBuilder};

use super::{Shape, failed};
use crate::export::output::{Files, Out};
use crate::write::Compress;
use hexcast_core::base::error::{Error, Result};

/// Most bytes of the datasets of a file, which are held twice at its end: wasm has 4 GiB.
const MAX_BYTES: u64 = 1 << 28;

/// Longest side of a chunk: hdf5-pure 0.47 writes longer ones as four bytes, where libhdf5 (2.0) takes three and refuses the dataset.
const MAX_CHUNK: u64 = 0xffff;

/// A file being made.
pub(crate) struct File {
    name: String,
    builder: FileBuilder,
}

impl File {
    /// Begins a file, whose datasets will have so many bytes.
    ///
    /// # Errors
    /// `memory` where these are too many.
    pub(crate) fn create(_files: &mut dyn Files, name: &str, n_bytes: u64) -> Result<File> {
        if n_bytes > MAX_BYTES {
            let message =
                format!("{name} has {n_bytes} bytes, and HDF5 files of up to {MAX_BYTES} are made here, in memory");
            let hint = "export fewer flags, use larger cells, or make it natively, which needs no memory for it: save the mesh as .hxc, then hexcast convert";
            return Err(Error::new("memory", message, hint));
        }
        Ok(File { name: name.into(), builder: FileBuilder::new() })
    }

    /// Adds an attribute.
    pub(crate) fn text(&mut self, name: &str, value: &str) -> Result<()> {
        self.builder.set_attr(name, AttrValue::VarLenString(value.into()));
        Ok(())
    }

    /// Adds an attribute of numbers.
    pub(crate) fn numbers(&mut self, name: &str, values: &[f64]) -> Result<()> {
        self.builder.set_attr(name, AttrValue::F64Array(values.into()));
        Ok(())
    }

    /// Adds a dataset of strings.
    pub(crate) fn texts(&mut self, name: &str, values: &[&str]) -> Result<()> {
        self.builder.create_dataset(name).with_vlen_strings(values);
        Ok(())
    }

    /// Writes the file.
    pub(crate) fn finish(self, files: &mut dyn Files) -> Result<()> {
        let mut out = Out::create(files, &self.name)?;
        self.builder.finish_to(&mut out.file).map_err(failed)?;
        out.finish()
    }
}

/// A dataset being made.
pub(crate) struct Table<T: Item> {
    name: String,
    dims: Vec<u64>,
    chunk: Vec<u64>,
    compress: Compress,
    items: Vec<T>,
}

impl<T: Item> Table<T> {
    /// Begins a dataset.
    ///
    /// # Errors
    /// `memory` where there is no room for it.
    pub(crate) fn new(_file: &mut File, shape: Shape) -> Result<Table<T>> {
        let n_items: usize = shape.dims.iter().product();
        let mut items = Vec::new();
        items.try_reserve_exact(n_items).map_err(|_| {
            let message = format!("the dataset {} has {n_items} items, for which there is no memory", shape.name);
            Error::new("memory", message, "export fewer flags, or use larger cells")
        })?;
        let dims = shape.dims.iter().map(|&n| n as u64).collect();
        let chunk = shape.chunk(size_of::<T>()).into_iter().map(|n| MAX_CHUNK.min(n as u64)).collect();
        Ok(Table { name: shape.name.into(), dims, chunk, compress: shape.compress, items })
    }

    /// Adds items behind those before, the last axis fastest.
    pub(crate) fn push(&mut self, items: &[T]) -> Result<()> {
        self.items.extend_from_slice(items);
        Ok(())
    }

    /// Ends the dataset.
    pub(crate) fn finish(self, file: &mut File) -> Result<()> {
        let dataset = file.builder.create_dataset(&self.name).with_data(&self.items).with_shape(&self.dims);
        if let Compress::Zlib(level) = self.compress {
            dataset.with_chunks(&self.chunk).with_deflate(level.into());
        }
        Ok(())
    }
}

//! What exporters work on, and the files that they write.

use std::cell::RefCell;
use std::io::{self, Write};
#[cfg(not(target_arch = "wasm32"))]
use std::path::PathBuf;

use super::options::ExportOptions;
use hexcast_core::base::control::Control;
use hexcast_core::base::error::{Error, Result};
use hexcast_derived::mesh::Mesh;

/// Where an exporter's files go.
pub trait Files {
    /// Begins a file of [`super::Exporter::file_names`] and returns its writer; the one before is complete.
    ///
    /// # Errors
    /// Those of the implementation, such as `io`.
    fn create(&mut self, name: &str) -> Result<Box<dyn Write + '_>>;

    /// Returns the path at which a file of [`super::Exporter::file_names`] is made that is not written from its first byte to its last:
    /// HDF5. The file need not be there; its folder is.
    ///
    /// # Errors
    /// Those of the implementation, such as `io`.
    #[cfg(not(target_arch = "wasm32"))]
    fn place(&mut self, name: &str) -> Result<PathBuf>;
}

/// What every exporter works on.
pub(super) struct Export<'a> {
    pub(super) mesh: &'a Mesh,
    pub(super) options: &'a ExportOptions,
    pub(super) control: &'a Control,
    /// What the files lack of the mesh, a sentence each.
    lacks: RefCell<Vec<String>>,
}

impl<'a> Export<'a> {
    pub(super) fn new(mesh: &'a Mesh, options: &'a ExportOptions, control: &'a Control) -> Export<'a> {
        Export { mesh, options, control, lacks: RefCell::default() }
    }

    /// Says what the files lack.
    pub(super) fn say(&self, sentences: impl IntoIterator<Item = String>) {
        self.lacks.borrow_mut().extend(sentences);
    }

    /// What the files lack.
    pub(super) fn lacks(self) -> Vec<String> {
        self.lacks.into_inner()
    }

    /// Hands the flags of all cells over, as [`Mesh::for_each_slab`] does: at least so many at once.
    ///
    /// # Errors
    /// Those of [`Mesh::for_each_slab`].
    pub(super) async fn for_each_slab(&self, least: usize, consume: &mut dyn FnMut(&[u8]) -> Result<()>) -> Result<()> {
        self.mesh.for_each_slab_with_rests(self.options.slab_bytes.max(least), self.control, consume).await
    }
}

/// A file being written; what is written to it is gathered first.
pub(super) struct Out<'a> {
    pub(super) file: io::BufWriter<Box<dyn Write + 'a>>,
}

impl<'a> Out<'a> {
    pub(super) fn create(files: &'a mut dyn Files, name: &str) -> Result<Out<'a>> {
        Ok(Out { file: io::BufWriter::with_capacity(1 << 20, files.create(name)?) })
    }

    pub(super) fn put(&mut self, bytes: &[u8]) -> Result<()> {
        self.file.write_all(bytes).map_err(failed)
    }

    /// Writes what `format_args!` makes.
    pub(super) fn text(&mut self, text: std::fmt::Arguments) -> Result<()> {
        self.file.write_fmt(text).map_err(failed)
    }

    pub(super) fn finish(mut self) -> Result<()> {
        self.file.flush().map_err(failed)
    }
}

pub(super) fn failed(error: io::Error) -> Error {
    Error::io("writing the mesh", error)
}

//! One output file: written to a temporary file beside its target, and given its name at the end.

use std::io::{BufWriter, Seek, Write};
use std::path::{Path, PathBuf};

use hexcast::files::place::{folder_of, refused};
use hexcast::{Error, Result};
use tempfile::NamedTempFile;

use crate::files::{ledger::Output, standard_streams};

/// A file that was written.
pub(crate) struct OutputFile {
    pub(crate) path: PathBuf,
    pub(crate) n_bytes: u64,
}

/// A temporary file and the name that it will have.
pub(crate) struct PendingFile {
    /// The name that the caller gave.
    pub(crate) path: PathBuf,
    output: Output,
    pub(crate) temporary: NamedTempFile,
}

impl PendingFile {
    /// Opens a temporary file beside what `path` leads to, which must be no input and no other output.
    pub(crate) fn open(path: &Path) -> Result<PendingFile> {
        if standard_streams::is_standard(path) {
            standard_streams::check_output()?;
        }
        let output = Output::file(path)?;
        let temporary = output.temporary_file().map_err(|error| refused(path, folder_of(&output.target), &error))?;
        Ok(PendingFile { path: path.to_path_buf(), output, temporary })
    }

    /// Whether it goes to standard output.
    pub(crate) fn is_standard(&self) -> bool {
        self.output.is_standard()
    }

    /// The folder that it is written in.
    pub(crate) fn folder(&self) -> &Path {
        folder_of(if self.is_standard() { self.temporary.path() } else { &self.output.target })
    }

    /// Writes bytes.
    pub(crate) fn put(&mut self, bytes: impl AsRef<[u8]>) -> Result<()> {
        let outcome = self.temporary.write_all(bytes.as_ref());
        outcome.map_err(|error| Error::io(format!("writing {}", self.path.display()), error))
    }

    /// Writes what `write` does, through a buffer.
    pub(crate) fn fill<T>(&self, write: impl FnOnce(&mut dyn Write) -> Result<T>) -> Result<T> {
        let mut out = BufWriter::with_capacity(1 << 20, self.temporary.as_file());
        write(&mut out).map_err(|error| error.at(self.path.display()))
    }

    /// The file as one of so many bytes that was written.
    pub(crate) fn of_bytes(&self, n_bytes: u64) -> OutputFile {
        OutputFile { path: self.path.clone(), n_bytes }
    }

    /// Gives the file its name, or prints it.
    pub(crate) fn persist(mut self) -> Result<()> {
        if self.is_standard() {
            self.temporary.rewind().map_err(|error| Error::io("reading what was written", error))?;
            return standard_streams::print_all(self.temporary.as_file());
        }
        self.output.put_file(self.temporary)
    }
}

/// The path with an ending appended.
pub(crate) fn with_ending(path: &Path, ending: &str) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(ending);
    name.into()
}

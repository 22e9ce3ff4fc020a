//! One output file: written to a temporary file beside its target, and given its name at the end.

use std::io::{ErrorKind, Seek, Write};
use std::path::{Path, PathBuf};

use hexcast::{Error, Result};
use tempfile::NamedTempFile;

use super::place::{check_kind, folder_of, target_of};
use super::{standard, temporary};

/// A file that was written.
pub(crate) struct OutputFile {
    pub(crate) path: PathBuf,
    pub(crate) n_bytes: u64,
}

/// A temporary file and the name that it will have.
pub(crate) struct PendingFile {
    /// The name that the caller gave.
    pub(crate) path: PathBuf,
    /// What it leads to; [`standard::NAME`] where that is standard output.
    target: PathBuf,
    pub(crate) temporary: NamedTempFile,
}

impl PendingFile {
    /// Opens a temporary file beside what `path` leads to; also returns that without links.
    pub(crate) fn open(path: &Path) -> Result<(PathBuf, PendingFile)> {
        if standard::is_standard(path) {
            return PendingFile::for_standard_output();
        }
        if path.is_dir() {
            return Err(Error::new("io", format!("{} is a folder", path.display()), "name a file in it"));
        }
        check_kind(path)?;
        let target = target_of(path)?;
        let folder = folder_of(&target);
        let refused = |error: std::io::Error| refused(path, folder, &error);
        let temporary = temporary::file_for(&target, folder).map_err(refused)?;
        let folder = folder.canonicalize().map_err(refused)?;
        let place = target.canonicalize().unwrap_or_else(|_| folder.join(target.file_name().unwrap_or_default()));
        Ok((place, PendingFile { path: path.to_path_buf(), target, temporary }))
    }

    /// A temporary file whose bytes go to standard output once all is written.
    fn for_standard_output() -> Result<(PathBuf, PendingFile)> {
        standard::check_output()?;
        let folder = std::env::temp_dir();
        let name = PathBuf::from(standard::NAME);
        let temporary = NamedTempFile::new_in(&folder).map_err(|error| refused(&name, &folder, &error))?;
        Ok((name.clone(), PendingFile { path: name.clone(), target: name, temporary }))
    }

    /// Whether it goes to standard output.
    pub(crate) fn is_standard(&self) -> bool {
        standard::is_standard(&self.path)
    }

    /// The folder that it is written in.
    pub(crate) fn folder(&self) -> &Path {
        folder_of(if self.is_standard() { self.temporary.path() } else { &self.target })
    }

    /// Writes bytes.
    pub(crate) fn put(&mut self, bytes: impl AsRef<[u8]>) -> Result<()> {
        let outcome = self.temporary.write_all(bytes.as_ref());
        outcome.map_err(|error| Error::io(format!("writing {}", self.path.display()), error))
    }

    /// Gives the file its name, or prints it.
    pub(crate) fn persist(mut self) -> Result<()> {
        if self.is_standard() {
            self.temporary.rewind().map_err(|error| Error::io("reading what was written", error))?;
            return standard::print_all(self.temporary.as_file());
        }
        let outcome = self.temporary.persist(&self.target);
        outcome.map_err(|error| Error::io(format!("writing {}", self.path.display()), error.error))?;
        Ok(())
    }
}

/// The error of a folder in which no file can be made; it does not name the temporary file.
pub(crate) fn refused(path: &Path, folder: &Path, error: &std::io::Error) -> Error {
    let (name, folder) = (path.display(), folder.display());
    match error.kind() {
        ErrorKind::NotFound => {
            let message = format!("{name} cannot be written: there is no folder {folder}");
            Error::new("io", message, "make the folder first, or name another")
        }
        kind => {
            let message = format!("{name} cannot be written: the folder {folder} says \"{kind}\"");
            Error::new("io", message, "make sure that the folder is yours and has room")
        }
    }
}

/// The path with an ending appended.
pub(crate) fn with_ending(path: &Path, ending: &str) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(ending);
    name.into()
}

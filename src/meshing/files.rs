//! Reads the files of a job from disk, and blocks until all are read.
//!
//! Names of files -> [`Source`]s, several files at the same time on all cores. [`WrittenFolder`] writes those of a store. Natively only.

mod file_store;
pub mod place;
mod written_folder;

use std::fs::File;
use std::io::ErrorKind;
use std::path::Path;

use hexcast_core::base::control::Control;
use hexcast_core::base::error::{Error, Result};
use hexcast_core::base::memory::Memory;
use hexcast_core::base::parallel::*;
use hexcast_core::input::job::{GeometryJob, Job};
use hexcast_core::input::sources::Source;

pub use file_store::FileStore;
pub use written_folder::WrittenFolder;

/// Reads the file of every geometry of a job, in their order, within the memory that it allows; the first that fails decides the error.
///
/// # Errors
/// Those of [`read_file`].
pub fn read_job_files(job: &Job, control: &Control) -> Result<Vec<Source>> {
    let mut control = control.clone();
    if let Some(max) = job.max_memory {
        control.memory = Memory::limited(max.0, 0);
    }
    let read = |geometry: &GeometryJob| read_file(&geometry.file, &control);
    let sources: Vec<Result<Source>> = job.geometries.par_iter().map(read).collect();
    sources.into_iter().collect()
}

/// Reads a file in chunks; `file` is its path, and its name in reports and messages.
///
/// # Errors
/// Those of [`open_file`] and [`Source::read`]; `io` where the path is a pipe or a device, which have no length.
pub fn read_file(file: &str, control: &Control) -> Result<Source> {
    let mut input = open_file(Path::new(file))?;
    let metadata = input.metadata().map_err(|error| Error::io(format!("reading {file}"), error))?;
    if !metadata.is_file() {
        return Err(Error::new(
            "io",
            format!("{file} is not a file"),
            "name a file of a surface (STL, OBJ, PLY, OFF, 3MF, GLB), or give its bytes",
        ));
    }
    Source::read(file, metadata.len(), &mut input, control)
}

/// Opens a file, or a pipe or device, to read it.
///
/// # Errors
/// `io`: there is no such file, it may not be read, or it is a folder.
pub fn open_file(path: &Path) -> Result<File> {
    let name = path.display();
    let failed = |error: std::io::Error| match error.kind() {
        ErrorKind::NotFound => {
            Error::new("io", format!("{name}: there is no such file"), "look at its name and at the current folder")
        }
        _ => Error::new("io", format!("{name} cannot be read: {error}"), "make sure that it is yours to read"),
    };
    let file = File::open(path).map_err(failed)?;
    if file.metadata().map_err(failed)?.is_dir() {
        return Err(Error::new("io", format!("{name} is a folder"), "name the files in it"));
    }
    Ok(file)
}

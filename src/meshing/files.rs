//! Files on disk: reads those of a job, and blocks until all are read. Natively only.
//!
//! Names of files -> [`Source`]s, several files at the same time on all cores. [`FileAt`] reads at any place; [`FileStore`] keeps columns in a file, and [`WrittenFolder`] writes
//! the files of a Zarr store.

mod cad;
pub mod place;
#[cfg(feature = "save")]
pub mod saved;
mod written_folder;

use std::fs::File;
use std::io::{self, ErrorKind, Read, Seek, SeekFrom, Write};
use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use hexcast_core::base::control::Control;
use hexcast_core::base::error::{Error, Result};
use hexcast_core::base::memory::Memory;
use hexcast_core::base::parallel::*;
use hexcast_core::cells::columns::{Store, sealed};
use hexcast_core::input::job::Job;
use hexcast_core::input::read::ReadAt;
use hexcast_core::input::sources::Source;

pub use cad::{Fineness, format_of_cad, read_cad, use_python};
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
    let read = |geometry: usize| read_geometry(job, geometry, &control);
    let sources: Vec<Result<Source>> = (0..job.geometries.len()).into_par_iter().map(read).collect();
    sources.into_iter().collect()
}

/// Reads the file of one geometry of a job; triangles of STEP and IGES are as fine as its cells ask for.
///
/// # Errors
/// Those of [`read_file`].
pub fn read_geometry(job: &Job, geometry: usize, control: &Control) -> Result<Source> {
    read_fine(&job.geometries[geometry].file, &Fineness::of_job(job, geometry, 1.0), control)
}

/// Reads a file in chunks; `file` is its path, and its name in reports and messages. STEP and IGES become triangles as for 128 cells along the
/// longest axis.
///
/// # Errors
/// Those of [`open_file`] and [`Source::read`]; of STEP and IGES `cad-program` where no program converts them, `file-syntax`, `stl-empty`; `io` where the path is a pipe or a device, which have no length.
pub fn read_file(file: &str, control: &Control) -> Result<Source> {
    read_fine(file, &Fineness::default(), control)
}

/// The same; `fineness` is how fine the triangles of STEP and IGES are.
///
/// # Errors
/// Those of [`read_file`].
pub fn read_fine(file: &str, fineness: &Fineness, control: &Control) -> Result<Source> {
    let mut input = open_file(Path::new(file))?;
    let failed = |error| Error::io(format!("reading {file}"), error);
    let metadata = input.metadata().map_err(failed)?;
    if !metadata.is_file() {
        return Err(Error::new(
            "io",
            format!("{file} is not a file"),
            "name a file of a surface (STL, OBJ, PLY, OFF, 3MF, GLB, STEP, IGES), or give its bytes",
        ));
    }
    if let Some(format) = format_of_cad(&mut input).map_err(failed)? {
        return read_cad((file, format), &mut input, fineness, control);
    }
    let again = FileAt::new(input.try_clone().map_err(failed)?);
    Source::read_again(file, metadata.len(), (&mut input, Arc::new(again)), control)
}

/// Opens a file, or a pipe or device, to read it.
///
/// # Errors
/// `io`: there is no such file, it may not be read, or it is a folder.
pub fn open_file(path: &Path) -> Result<File> {
    let name = path.display();
    let failed = |error: io::Error| match error.kind() {
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

/// A file on disk that several threads read at any place, at the same time.
pub struct FileAt(File);

impl FileAt {
    /// Uses a file that is open. Where it is read from there on does not matter, and may change.
    pub fn new(file: File) -> FileAt {
        FileAt(file)
    }
}

impl ReadAt for FileAt {
    #[cfg(unix)]
    fn read_at(&self, at: u64, bytes: &mut [u8]) -> io::Result<()> {
        std::os::unix::fs::FileExt::read_exact_at(&self.0, bytes, at)
    }

    #[cfg(windows)]
    fn read_at(&self, mut at: u64, mut bytes: &mut [u8]) -> io::Result<()> {
        while !bytes.is_empty() {
            match std::os::windows::fs::FileExt::seek_read(&self.0, bytes, at) {
                Ok(0) => return Err(ErrorKind::UnexpectedEof.into()),
                Ok(n) => (at, bytes) = (at + n as u64, &mut bytes[n..]),
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) => return Err(error),
            }
        }
        Ok(())
    }
}

/// A file as a store of columns, read and appended under a lock.
pub struct FileStore(Mutex<File>);

impl FileStore {
    /// Uses a file that is open.
    pub fn new(file: File) -> FileStore {
        FileStore(Mutex::new(file))
    }

    /// Its length; 0 where the system does not say.
    pub fn n_bytes(&self) -> u64 {
        self.lock().metadata().map_or(0, |metadata| metadata.len())
    }

    fn lock(&self) -> MutexGuard<'_, File> {
        // a panic elsewhere leaves the file as it is
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl sealed::Sealed for FileStore {}

impl Store for FileStore {
    fn append(&self, bytes: &[u8]) -> io::Result<u64> {
        let mut file = self.lock();
        let at = file.seek(SeekFrom::End(0))?;
        file.write_all(bytes)?;
        Ok(at)
    }

    fn read(&self, at: u64, bytes: &mut [u8]) -> io::Result<()> {
        let mut file = self.lock();
        file.seek(SeekFrom::Start(at))?;
        file.read_exact(bytes)
    }

    fn truncate(&self, n_bytes: u64) -> io::Result<()> {
        self.lock().set_len(n_bytes)
    }
}

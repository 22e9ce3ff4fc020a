//! A file as a store of columns.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::sync::{Mutex, PoisonError};

use hexcast_core::cells::columns::{Store, sealed};

/// A file, read and appended under a lock.
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

    fn lock(&self) -> std::sync::MutexGuard<'_, File> {
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

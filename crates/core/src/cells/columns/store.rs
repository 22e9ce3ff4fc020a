//! A store for columns outside memory.

use std::io;
use std::sync::{Mutex, MutexGuard, PoisonError};

#[doc(hidden)]
pub mod sealed {
    /// What only this crate implements.
    pub trait Sealed {}
}

/// Bytes outside memory, such as a file. Calls may come from several threads. Only this crate implements it, so that it may get more methods:
/// [`MemoryStore`], and natively `files::FileStore`.
pub trait Store: sealed::Sealed + Send + Sync {
    /// Appends bytes and returns the offset of the first.
    ///
    /// # Errors
    /// The error of the medium.
    fn append(&self, bytes: &[u8]) -> io::Result<u64>;

    /// Reads bytes that were appended before, from an offset on.
    ///
    /// # Errors
    /// The error of the medium.
    fn read(&self, at: u64, bytes: &mut [u8]) -> io::Result<()>;

    /// Drops all bytes from an offset on; the next append starts there.
    ///
    /// # Errors
    /// The error of the medium.
    fn truncate(&self, n_bytes: u64) -> io::Result<()>;
}

/// A store in memory, for a file that is there already and for tests.
#[derive(Debug, Default)]
pub struct MemoryStore(Mutex<Vec<u8>>);

impl MemoryStore {
    /// Holds the bytes of a file.
    pub fn new(bytes: Vec<u8>) -> MemoryStore {
        MemoryStore(Mutex::new(bytes))
    }

    /// The bytes, locked.
    pub fn bytes(&self) -> MutexGuard<'_, Vec<u8>> {
        // no operation leaves them half done
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl sealed::Sealed for MemoryStore {}

impl Store for MemoryStore {
    fn append(&self, bytes: &[u8]) -> io::Result<u64> {
        let mut all = self.bytes();
        all.extend_from_slice(bytes);
        Ok((all.len() - bytes.len()) as u64)
    }

    fn read(&self, at: u64, bytes: &mut [u8]) -> io::Result<()> {
        let all = self.bytes();
        let start = usize::try_from(at).unwrap_or(usize::MAX);
        let found = all.get(start..start.saturating_add(bytes.len())).ok_or(io::ErrorKind::UnexpectedEof)?;
        bytes.copy_from_slice(found);
        Ok(())
    }

    fn truncate(&self, n_bytes: u64) -> io::Result<()> {
        self.bytes().truncate(n_bytes as usize);
        Ok(())
    }
}

//! A folder as a Zarr store that remembers the files that were written, to find out whether they are still there at the end.
//!
//! The store makes every folder that a file needs. If somebody removes the folder while it is filled, nothing fails, and the
//! files that are gone would read as cells without a flag.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard, PoisonError};

use hexcast_core::base::error::{Error, Result};

/// A folder and the lengths of the files that were written to it, by their keys.
pub struct WrittenFolder {
    root: PathBuf,
    lengths: Mutex<BTreeMap<String, u64>>,
}

impl WrittenFolder {
    /// A folder, which may not be there yet.
    pub fn new(root: PathBuf) -> WrittenFolder {
        WrittenFolder { root, lengths: Mutex::default() }
    }

    /// Writes a file, and makes the folders that it needs: a key of a Zarr store is its path (`flag/c/0/0/0`).
    ///
    /// # Errors
    /// `io`.
    pub fn put(&self, key: &str, bytes: &[u8]) -> Result<()> {
        let path = self.root.join(key);
        let made = path.parent().map_or(Ok(()), std::fs::create_dir_all);
        made.and_then(|()| std::fs::write(&path, bytes)).map_err(|error| Error::io(format!("writing {key}"), error))?;
        self.lengths().insert(key.into(), bytes.len() as u64);
        Ok(())
    }

    fn lengths(&self) -> MutexGuard<'_, BTreeMap<String, u64>> {
        // every change is a single insertion
        self.lengths.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Bytes of all files.
    pub fn n_bytes(&self) -> u64 {
        self.lengths().values().sum()
    }

    /// Checks that every file is there and as long as it was written.
    ///
    /// # Errors
    /// `io`, with the number of files that are not and the first of them.
    pub fn verify(&self) -> Result<()> {
        let lengths = self.lengths();
        let found = |key: &str| self.root.join(key).metadata().ok().map(|metadata| metadata.len());
        let mut wrong = lengths.iter().filter(|(key, length)| found(key) != Some(**length));
        let Some((key, length)) = wrong.next() else { return Ok(()) };
        let now = found(key).map_or("is gone".into(), |length| format!("has {length}"));
        let (n_wrong, n_files) = (1 + wrong.count(), lengths.len());
        let message = format!(
            "{n_wrong} of {n_files} files that were written are missing or have another length; the first, {key}, had {length} \
             bytes and {now}"
        );
        Err(Error::new("io", message, "find out what removes files from the folder of the output, and mesh again"))
    }
}

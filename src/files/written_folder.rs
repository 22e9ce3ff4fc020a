//! A folder as a Zarr store that remembers the files that were written, to find out whether they are still there at the end.
//!
//! The store makes every folder that a file needs. If somebody removes the folder while it is filled, nothing fails, and the
//! files that are gone would read as cells without a flag.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use zarrs::filesystem::FilesystemStore;
use zarrs::storage::{Bytes, OffsetBytesIterator, StorageError, StoreKey, StorePrefix, WritableStorageTraits};

use crate::error::{Error, Result};

/// A folder and the lengths of the files that were written to it, by their keys.
pub struct WrittenFolder {
    root: PathBuf,
    store: FilesystemStore,
    lengths: Mutex<BTreeMap<String, u64>>,
}

impl WrittenFolder {
    /// Opens a folder, which may not be there yet.
    ///
    /// # Errors
    /// `io` where it cannot be a store, such as where it is a file.
    pub fn new(root: &Path) -> Result<WrittenFolder> {
        let store = FilesystemStore::new(root);
        let store = store.map_err(|error| Error::new("io", format!("writing Zarr: {error}"), ""))?;
        Ok(WrittenFolder { root: root.into(), store, lengths: Mutex::default() })
    }

    fn lengths(&self) -> MutexGuard<'_, BTreeMap<String, u64>> {
        // every change is a single insertion or removal
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

impl WritableStorageTraits for WrittenFolder {
    fn set(&self, key: &StoreKey, value: Bytes) -> std::result::Result<(), StorageError> {
        let length = value.len() as u64;
        self.store.set(key, value)?;
        self.lengths().insert(key.as_str().into(), length);
        Ok(())
    }

    fn set_partial_many(&self, _: &StoreKey, _: OffsetBytesIterator) -> std::result::Result<(), StorageError> {
        Err(StorageError::Unsupported("files are written whole".into()))
    }

    fn erase(&self, key: &StoreKey) -> std::result::Result<(), StorageError> {
        self.store.erase(key)?;
        self.lengths().remove(key.as_str());
        Ok(())
    }

    fn erase_prefix(&self, prefix: &StorePrefix) -> std::result::Result<(), StorageError> {
        self.store.erase_prefix(prefix)?;
        self.lengths().retain(|key, _| !key.starts_with(prefix.as_str()));
        Ok(())
    }

    fn supports_set_partial(&self) -> bool {
        false
    }
}

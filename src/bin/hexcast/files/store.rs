//! A Zarr store that several processes may fill: values by keys, wherever they are.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use hexcast::write::zarr::Stored;
use hexcast::{Error, Result};

/// Values by keys.
pub(crate) trait Store: Send + Sync {
    /// The value of a key; None where there is none.
    fn get(&self, key: &str) -> Result<Option<Vec<u8>>>;
    /// Sets the value of a key: readers see the old one or the new one, never a part.
    fn put(&self, key: &str, value: &[u8]) -> Result<()>;
    /// All keys that begin so, in any order.
    fn keys(&self, prefix: &str) -> Result<Vec<String>>;
}

/// A store for the writer of Zarr, which other processes may fill at the same time: what is there already of its metadata must be what
/// this one would write; shards are replaced.
pub(crate) struct Shared {
    store: Arc<dyn Store>,
    n_bytes: AtomicU64,
}

impl Shared {
    pub(crate) fn new(store: Arc<dyn Store>) -> Shared {
        Shared { store, n_bytes: AtomicU64::new(0) }
    }

    /// Bytes that were written.
    pub(crate) fn n_bytes(&self) -> u64 {
        self.n_bytes.load(Ordering::Relaxed)
    }

    /// Whether a value is there; another one is refused.
    pub(crate) fn has(&self, key: &str, value: &[u8]) -> Result<bool> {
        let there = self.store.get(key)?;
        if there.as_ref().is_none_or(|there| there == value) {
            return Ok(there.is_some());
        }
        let message = format!("the store is that of another mesh: {key} differs");
        let hint = "name another store, remove this one, or mesh with the job and the options that it was begun with";
        Err(Error::new("io", message, hint))
    }

    /// Sets a value.
    pub(crate) fn set(&self, key: &str, value: &[u8]) -> Result<()> {
        if !Stored::is_of_shard(key) && self.has(key, value)? {
            return Ok(());
        }
        self.store.put(key, value)?;
        self.n_bytes.fetch_add(value.len() as u64, Ordering::Relaxed);
        Ok(())
    }
}

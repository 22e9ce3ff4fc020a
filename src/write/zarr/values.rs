//! A store that hands each value to a function.

use zarrs::storage::{Bytes, OffsetBytesIterator, StorageError, StoreKey, StorePrefix, WritableStorageTraits};

use crate::error::Result;

/// A store for [`super::write_part`] that hands each key and its value to a function, which keeps or compares it. Nothing is ever removed.
pub struct Values<F>(pub F);

impl<F: Fn(&str, Bytes) -> Result<()> + Send + Sync> WritableStorageTraits for Values<F> {
    fn set(&self, key: &StoreKey, value: Bytes) -> std::result::Result<(), StorageError> {
        (self.0)(key.as_str(), value).map_err(|error| {
            let hint = if error.hint().is_empty() { String::new() } else { format!("; {}", error.hint()) };
            StorageError::Other(format!("{error}{hint}"))
        })
    }

    fn set_partial_many(&self, _: &StoreKey, _: OffsetBytesIterator) -> std::result::Result<(), StorageError> {
        Err(StorageError::Unsupported("values are written whole".into()))
    }

    fn erase(&self, _: &StoreKey) -> std::result::Result<(), StorageError> {
        Err(StorageError::Unsupported("every value is kept".into()))
    }

    fn erase_prefix(&self, _: &StorePrefix) -> std::result::Result<(), StorageError> {
        Err(StorageError::Unsupported("every value is kept".into()))
    }

    fn supports_set_partial(&self) -> bool {
        false
    }
}

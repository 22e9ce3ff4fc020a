//! The column file that columns in the making are written to.

use std::sync::Arc;

use super::part::Part;
use super::store::Store;
use super::stored::{Record, Stored};
use crate::error::{Error, Result};
use crate::rays::Rays;

/// A store for columns, and the head of the file in it.
pub(super) struct Target {
    pub(super) stored: Arc<Stored>,
    pub(super) head: Vec<u8>,
    /// Whether it gets every band.
    pub(super) keeps: bool,
    /// The pieces in the store: none, or those of all rays.
    pub(super) records: Vec<Record>,
    pub(super) n_bytes: u64,
}

impl Target {
    /// Uses a store for columns of these rays, and at most `max_bytes` of memory for what is read back.
    pub(super) fn new(rays: &Rays, max_bytes: u64, (head, store): (Vec<u8>, Arc<dyn Store>)) -> Target {
        let stored = Arc::new(Stored::own(store, rays.depth, max_bytes));
        Target { stored, head, keeps: false, records: Vec::new(), n_bytes: 0 }
    }

    /// Appends parts, the head of the file before the first.
    pub(super) fn append(&mut self, parts: &[(Part, [u64; 2])]) -> Result<()> {
        if self.n_bytes == 0 {
            self.append_bytes(&self.head.clone())?;
        }
        let (records, n_bytes) = self.stored.append(parts)?;
        self.records.extend(records);
        self.n_bytes += n_bytes;
        Ok(())
    }

    /// Appends bytes that are not pieces.
    pub(super) fn append_bytes(&mut self, bytes: &[u8]) -> Result<()> {
        self.stored.store.append(bytes).map_err(|error| Error::io("writing columns to the disk", error))?;
        self.n_bytes += bytes.len() as u64;
        Ok(())
    }
}

/// The first bytes of a store, at most `n`.
pub(super) fn begun(store: &dyn Store, n: usize) -> Vec<u8> {
    let mut head = vec![0; n];
    if store.read(0, &mut head).is_ok() {
        return head;
    }
    // bytes that can be read come before those that cannot
    let (mut least, mut most) = (0, n);
    while most - least > 1 {
        let middle = least.midpoint(most);
        if store.read(0, &mut head[..middle]).is_ok() { least = middle } else { most = middle }
    }
    let is_read = store.read(0, &mut head[..least]).is_ok();
    head[..if is_read { least } else { 0 }].to_vec()
}

//! The bytes of the buffers that a device holds for kernels: counted where each is made and where it is freed.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

/// Bytes that a device holds.
#[derive(Debug, Default)]
pub(crate) struct Held {
    now: AtomicU64,
    peak: AtomicU64,
}

impl Held {
    /// Bytes that it holds now.
    pub(crate) fn now(&self) -> u64 {
        self.now.load(Relaxed)
    }

    /// Most bytes that it has held since the last call of [`Held::begin`].
    pub(crate) fn peak(&self) -> u64 {
        self.peak.load(Relaxed)
    }

    /// Forgets what it held before.
    pub(crate) fn begin(&self) {
        self.peak.store(self.now(), Relaxed);
    }
}

/// The bytes of one buffer, for as long as it lives.
#[derive(Debug)]
pub(crate) struct Share {
    held: Arc<Held>,
    n_bytes: u64,
}

impl Share {
    pub(crate) fn new(held: &Arc<Held>, n_bytes: u64) -> Share {
        let now = held.now.fetch_add(n_bytes, Relaxed) + n_bytes;
        held.peak.fetch_max(now, Relaxed);
        Share { held: held.clone(), n_bytes }
    }
}

impl Drop for Share {
    fn drop(&mut self) {
        self.held.now.fetch_sub(self.n_bytes, Relaxed);
    }
}

//! The pool: buffers of finished meshes, kept for the next mesh. To make new buffers, clear them and touch their pages for the
//! first time takes a driver longer than a small mesh.

use std::sync::{Mutex, PoisonError};

use wgpu::Buffer;

use crate::buffers::Buffers;
use hexcast_core::stages::cast::sizes::Capacity;

/// Most bytes kept between meshes.
const MAX_BYTES: u64 = 256 << 20;

/// Buffers of one band, and the one by which its results reach the host.
pub(crate) struct Pooled {
    pub(crate) buffers: Buffers,
    pub(crate) staging: Option<Buffer>,
}

impl Pooled {
    fn n_bytes(&self) -> u64 {
        self.buffers.capacity.n_bytes() + self.staging.as_ref().map_or(0, Buffer::size)
    }
}

/// The buffers kept for a device.
#[derive(Default)]
pub(crate) struct BufferPool(Mutex<Vec<Pooled>>);

impl BufferPool {
    /// Takes buffers of at most so many bytes that hold what is wanted, if there are any.
    pub(crate) fn take(&self, wanted: Capacity, most_bytes: u64) -> Option<Pooled> {
        let mut pool = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let fits = |has: Capacity| has.holds(wanted) && has.n_bytes_at_most() <= most_bytes;
        let index = pool.iter().position(|pooled| fits(pooled.buffers.capacity))?;
        Some(pool.swap_remove(index))
    }

    /// Drops all if they have more than so many bytes.
    pub(crate) fn clear_over(&self, max_bytes: u64) {
        let mut pool = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if pool.iter().map(Pooled::n_bytes).sum::<u64>() > max_bytes {
            pool.clear();
        }
    }

    /// Keeps buffers, and drops the oldest of those that become too many.
    pub(crate) fn keep(&self, pooled: Pooled) {
        let mut pool = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        pool.push(pooled);
        while pool.iter().map(Pooled::n_bytes).sum::<u64>() > MAX_BYTES {
            pool.remove(0);
        }
    }
}

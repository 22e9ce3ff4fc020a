//! Buffers of meshes that are done, kept for the next: a driver spends more time on making new ones, clearing them and
//! touching their pages for the first time than a small mesh takes.

use std::sync::{Mutex, PoisonError};

use wgpu::Buffer;

use super::buffers::{Buffers, Capacity};

/// Most bytes kept between meshes.
const MAX_BYTES: u64 = 256 << 20;

/// Buffers of one band, and the one in which its results came home.
pub(crate) struct Spare {
    pub(crate) buffers: Buffers,
    pub(crate) staging: Option<Buffer>,
}

impl Spare {
    fn n_bytes(&self) -> u64 {
        self.buffers.n_bytes + self.staging.as_ref().map_or(0, Buffer::size)
    }
}

/// The spares of a device.
#[derive(Default)]
pub(crate) struct Spares(Mutex<Vec<Spare>>);

impl Spares {
    /// Takes buffers that hold what is wanted, if there are any.
    pub(crate) fn take(&self, n_facets: u64, wanted: Capacity) -> Option<Spare> {
        let mut spares = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let fits = |spare: &Spare| {
            let has = spare.buffers.capacity;
            spare.buffers.facets.n_facets >= n_facets
                && has.n_rays >= wanted.n_rays
                && has.n_bins >= wanted.n_bins
                && has.holds(wanted.n_pairs, wanted.n_events)
        };
        let place = spares.iter().position(fits)?;
        Some(spares.swap_remove(place))
    }

    /// Drops all if they have more than so many bytes.
    pub(crate) fn clear_over(&self, max_bytes: u64) {
        let mut spares = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if spares.iter().map(Spare::n_bytes).sum::<u64>() > max_bytes {
            spares.clear();
        }
    }

    /// Keeps buffers, and drops the oldest of those that become too many.
    pub(crate) fn keep(&self, spare: Spare) {
        let mut spares = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        spares.push(spare);
        while spares.iter().map(Spare::n_bytes).sum::<u64>() > MAX_BYTES {
            spares.remove(0);
        }
    }
}

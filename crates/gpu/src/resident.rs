//! The runs of a mesh that stay on the device: a piece a band, as these are done, and one buffer of all at the end.

use std::sync::{Mutex, MutexGuard, PoisonError};

use crate::buffers::{Array, Part};
use crate::device::{Opened, USE_CPU};
use crate::readback::Staging;
use crate::runs::DeepRows;
use hexcast_core::base::error::{Error, Result};
use hexcast_core::grid::rays::Rays;

/// What is known of all bands that are done.
#[derive(Default)]
pub(crate) struct Kept {
    /// Runs of each band, and their number.
    pieces: Vec<(Array<u32>, u64)>,
    pub(crate) n_runs: u64,
    pub(crate) odd_rays: u64,
    pub(crate) n_crossings: u64,
}

/// What the kernels before have left of a band.
pub(crate) struct Unordered {
    pub(crate) deep: DeepRows,
    pub(crate) n_places: u64,
    /// Places given to rows that turned out to be deep; crossings that begin no run; and the rays that facets hit, where they are counted.
    pub(crate) n_unused: u32,
    pub(crate) n_lost: u32,
    pub(crate) n_hits: Option<u32>,
}

/// Where the bands of a mesh leave their runs.
pub(crate) struct Resident {
    /// First run of each ray, then the end.
    pub(crate) offsets: Array<u32>,
    /// Most runs that a buffer of the device holds, where a kernel sees all of it.
    most_runs: u64,
    kept: Mutex<Kept>,
}

impl Resident {
    /// Makes room for the offsets.
    ///
    /// # Errors
    /// `memory`: a buffer of the device holds fewer.
    pub(crate) fn new(opened: &Opened, rays: &Rays) -> Result<Resident> {
        let allowed = most_bytes(opened);
        let n_bytes = 4 * (rays.n_rays() + 1);
        if n_bytes > allowed {
            return Err(too_large(&format!("the offsets of {} rays", rays.n_rays()), n_bytes, allowed));
        }
        let offsets = Array::storage(opened, "offsets", rays.n_rays() + 1);
        Ok(Resident { offsets, most_runs: allowed / 4, kept: Mutex::default() })
    }

    /// What is known of the bands so far.
    pub(crate) fn kept(&self) -> MutexGuard<'_, Kept> {
        self.kept.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Refuses more runs in all than a buffer holds.
    ///
    /// # Errors
    /// `memory`.
    pub(crate) fn check(&self, n_runs: u64) -> Result<()> {
        let n_bytes = 4 * n_runs;
        if n_runs > self.most_runs {
            return Err(too_large(&format!("{n_runs} runs, and maybe more,"), n_bytes, 4 * self.most_runs));
        }
        Ok(())
    }

    /// Takes the runs of the next band.
    pub(crate) fn take(&self, runs: Array<u32>, n_runs: u64) {
        let mut kept = self.kept();
        kept.pieces.push((runs, n_runs));
        kept.n_runs += n_runs;
    }

    /// Joins the pieces, and asks the device for the last offset, so that one that is lost or has no room does not go unheard. The offsets,
    /// and all runs.
    ///
    /// # Errors
    /// `device-failed`, `device-wrong`.
    pub(crate) async fn finish(self, opened: &Opened) -> Result<(Array<u32>, Array<u32>, Kept)> {
        let mut kept = self.kept.into_inner().unwrap_or_else(PoisonError::into_inner);
        let runs = Array::storage(opened, "runs", kept.n_runs);
        let mut encoder = opened.encoder();
        let mut at = 0;
        for (piece, n_runs) in kept.pieces.drain(..) {
            encoder.copy_buffer_to_buffer(&piece.buffer, 0, &runs.buffer, 4 * at, 4 * n_runs);
            at += n_runs;
        }
        let n_rays = self.offsets.buffer.size() / 4;
        let last = last_offset(&self.offsets, n_rays);
        let [ends] = Staging::default().read(opened, encoder, [last]).await?;
        if u64::from(ends.iter().copied().max().unwrap_or(0)) != kept.n_runs {
            let message = format!("the offsets end at {ends:?}, where {} runs were written", kept.n_runs);
            return Err(Error::new("device-wrong", message, USE_CPU));
        }
        Ok((self.offsets, runs, kept))
    }
}

/// The last words of a buffer, of which the first that are filled tell the end: what is behind it is zero.
fn last_offset(offsets: &Array<u32>, n_words: u64) -> Part<'_> {
    offsets.part(n_words.saturating_sub(16), n_words.min(16))
}

/// Most bytes of a buffer that a kernel sees at once.
pub(crate) fn most_bytes(opened: &Opened) -> u64 {
    let limits = opened.device.limits();
    // 32 bits count the runs
    limits.max_storage_buffer_binding_size.min(limits.max_buffer_size).min(4 * u64::from(u32::MAX - 1))
}

/// The error of what no buffer of a device holds.
pub(crate) fn too_large(what: &str, n_bytes: u64, allowed: u64) -> Error {
    let message =
        format!("{what} take {n_bytes} bytes; a buffer that a kernel of this device sees has at most {allowed}");
    let hint = "mesh it in windows (window, part), with larger cells, or request a device with larger \
                max_storage_buffer_binding_size and max_buffer_size";
    Error::new("memory", message, hint)
}

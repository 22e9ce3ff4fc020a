//! Bands of the GPU backend: what they begin with and how large they get. The backend allocates by these numbers, and the
//! estimate and the plan count by them.

/// Rays of a bin along both axes across; `BIN` in `shaders/shared/params.wgsl`.
pub(crate) const BIN: u32 = 8;
/// Words of a facet on the device.
pub(crate) const FACET_WORDS: usize = 12;
/// Rays of the first band, before anything is known about the device's speed: fewer where a page waits.
pub(crate) const FIRST_BAND: u64 = if cfg!(target_arch = "wasm32") { 1 << 18 } else { 1 << 20 };
/// Most rays of a band.
pub(crate) const MOST_BAND: u64 = 1 << 22;
/// Bands on the device at once: while one comes home and one runs, the next waits its turn.
pub(crate) const BANDS_IN_FLIGHT: usize = 3;

/// (facet, bin) pairs that the first band has room for.
pub(crate) fn first_pairs(n_bins: u64, n_facets: u64) -> u64 {
    16 * n_bins + 3 * n_facets
}

/// Words of runs that the first band has room for.
pub(crate) fn first_words(n_rays: u64) -> u64 {
    8 * n_rays
}

/// Rounds a number of ray rows down to whole bins, at least one.
pub(crate) fn whole_bins(rows: u64) -> u64 {
    let bin = u64::from(BIN);
    (rows / bin * bin).max(bin)
}

//! Bytes of GPU buffers of a mesh in bands.

use super::Estimate;
use hexcast_core::stages::cast::sizes::{
    self, BANDS_IN_FLIGHT, BandSize, Capacity, FIRST_BAND, MAX_LAYERS, MOST_BAND, deep_bytes, layers, upload_bytes,
    whole_bins,
};

/// How much more crowded some rays are than others.
pub(super) const UNEVEN: f64 = 1.5;
/// Ray rows of a row of bins: no band takes less.
pub(super) const BIN: u64 = sizes::BIN as u64;
/// Bands on the device at once.
pub(super) const IN_FLIGHT: u64 = BANDS_IN_FLIGHT as u64;

impl Estimate {
    /// Places of four runs on a GPU: each ray that has runs begins a new one.
    pub(super) fn places(&self) -> f64 {
        (self.runs + 2 * self.rays.min(self.runs / 2)) as f64 / 4.0
    }

    /// Bytes of GPU buffers in bands of at most so many ray rows: those of the bands in flight.
    ///
    /// A first band gets what `Capacity::first` says. One that needs more tiles or places runs again with an eighth more than it
    /// needs, and the bands after it get as much.
    pub(crate) fn device_bytes_of(&self, most_rows: u64) -> u64 {
        let (rows, n_bands) = self.bands(most_rows);
        let (capacity, events) = self.band(rows);
        n_bands * (capacity.n_bytes() + events)
    }

    /// Bytes that the device must be allowed to hold, so that bands can have as many rows.
    pub(crate) fn device_limit_of(&self, most_rows: u64) -> u64 {
        let (capacity, events) = self.band(self.bands(most_rows).0);
        // a device gives the crossings of deep rows half as much as a band
        sizes::device_bytes((capacity.n_bytes_at_most() + events).max(2 * events))
    }

    /// Bytes on the host of facets on their way to the device in such bands.
    pub(crate) fn upload_bytes_of(&self, most_rows: u64) -> u64 {
        let (rows, n_bands) = self.bands(most_rows);
        let n_facets = self.facets_of(rows);
        upload_bytes(n_bands * n_facets, n_facets)
    }

    /// Rows of the largest band, and bands in flight.
    fn bands(&self, most_rows: u64) -> (u64, u64) {
        let (n_i, n_j) = (self.rays_across(), self.rows());
        let first_rows = whole_bins(FIRST_BAND / n_i).min(most_rows).min(n_j);
        if first_rows == n_j {
            return (n_j, 1);
        }
        let rows = whole_bins(MOST_BAND / n_i).min(most_rows).min(n_j.div_ceil(2)).max(first_rows);
        (rows, IN_FLIGHT.min(n_j.div_ceil(first_rows)))
    }

    /// A part of some number in a band.
    fn share(&self, n: u64, rows: u64) -> u64 {
        let uneven = if rows == self.rows() { 1.0 } else { UNEVEN };
        (n as f64 * rows as f64 / self.rows() as f64 * uneven).min(n as f64) as u64
    }

    /// Facets of a band.
    fn facets_of(&self, rows: u64) -> u64 {
        self.box_facets.min(self.share(self.pairs, rows))
    }

    /// What the buffers of a band hold, and bytes of its crossings if all its rows are deep.
    fn band(&self, rows: u64) -> (Capacity, u64) {
        let n_i = self.rays_across();
        let share = |n: u64| self.share(n, rows);
        let per_ray = self.crossings as f64 / self.rays as f64;
        if self.grading.is_some() {
            // all rows are deep
            let n_facets = self.facets_of(rows);
            let n_centres = self.dims.iter().map(|&n| u64::from(n)).sum();
            let capacity = Capacity { n_facets, n_centres, ..Capacity::default() };
            return (capacity.rounded(), deep_bytes(rows * n_i.div_ceil(BIN), share(self.crossings)));
        }
        let first = Capacity::first(&BandSize {
            n_facets: self.facets_of(rows),
            n_all_facets: self.facets,
            n_crossings: share(self.crossings),
            n_tiles: 0,
            n_rays: rows * n_i,
            n_bins: rows.div_ceil(BIN) * n_i.div_ceil(BIN),
            n_chunks: rows * n_i.div_ceil(BIN),
            n_layers: layers(UNEVEN * per_ray),
        });
        // with more crossings a ray than a few a layer all rows are deep: two words a crossing
        if per_ray > f64::from(4 * MAX_LAYERS) {
            let n_tiles = first.n_tiles.max(share(self.pairs.min(self.crossings)));
            return (Capacity { n_tiles, ..first }.rounded(), 8 * share(self.crossings));
        }
        let n_tiles = share(self.pairs.min(self.crossings)) * 9 / 8;
        let n_places = share(self.places() as u64) * 9 / 8;
        (first.max(Capacity { n_tiles, n_places, ..Capacity::default() }).rounded(), 0)
    }
}

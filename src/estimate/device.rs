//! Bytes of GPU buffers of a mesh in bands.

use super::costs::Estimate;
use crate::cast::sizes::{
    self, BANDS_IN_FLIGHT, BandSize, Capacity, FIRST_BAND, MAX_LAYERS, MOST_BAND, layers, whole_bins,
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
        let (n_i, n_j) = (self.rays_across(), self.rows());
        let first_rows = whole_bins(FIRST_BAND / n_i).min(most_rows).min(n_j);
        if first_rows == n_j {
            return self.band_bytes(n_j);
        }
        let rows = whole_bins(MOST_BAND / n_i).min(most_rows).min(n_j.div_ceil(2)).max(first_rows);
        IN_FLIGHT.min(n_j.div_ceil(first_rows)) * self.band_bytes(rows)
    }

    /// Bytes of the buffers of a band.
    fn band_bytes(&self, rows: u64) -> u64 {
        let (n_i, n_j) = (self.rays_across(), self.rows());
        let uneven = if rows == n_j { 1.0 } else { UNEVEN };
        let share = |n: u64| (n as f64 * rows as f64 / n_j as f64 * uneven).min(n as f64) as u64;
        let per_ray = self.crossings as f64 / self.rays as f64;
        let first = Capacity::first(&BandSize {
            n_facets: self.box_facets.min(share(self.pairs)),
            n_all_facets: self.facets,
            n_crossings: share(self.crossings),
            n_rays: rows * n_i,
            n_bins: rows.div_ceil(BIN) * n_i.div_ceil(BIN),
            n_chunks: rows * n_i.div_ceil(BIN),
            n_layers: layers(UNEVEN * per_ray),
        });
        // with more crossings a ray than a few a layer all rows are deep: two words a crossing
        if per_ray > f64::from(4 * MAX_LAYERS) {
            let n_facets = first.n_facets;
            let n_tiles = first.n_tiles.max(share(self.pairs.min(self.crossings)));
            return Capacity { n_facets, n_tiles, ..first }.rounded().n_bytes() + 8 * share(self.crossings);
        }
        let n_tiles = share(self.pairs.min(self.crossings)) * 9 / 8;
        let n_places = share(self.places() as u64) * 9 / 8;
        first.max(Capacity { n_tiles, n_places, ..Capacity::default() }).rounded().n_bytes()
    }
}

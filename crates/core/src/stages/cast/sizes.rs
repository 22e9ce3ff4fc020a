//! How large the bands of the GPU backend and the buffers of a band are, in u64, before anything is allocated. The backend allocates
//! by these numbers; the estimate and the plan count by them.

/// Rays of a bin along both axes across; `BIN` in `shaders/shared/params.wgsl`.
pub const BIN: u32 = 8;
/// Bins of one item of the walk over the lattice at most; `SEGMENT` in `shaders/shared/items.wgsl`.
pub const SEGMENT: u32 = 16;
/// Most layers of a bin along the rays; `layer_ends` in `shaders/map.wgsl` has as many entries.
pub const MAX_LAYERS: u32 = 128;
/// Most tiles of a bin that `map` goes through; `MAX_TILES` in `shaders/shared/params.wgsl`.
pub const MAX_TILES: u32 = 1 << 13;
/// Most bins of a band: the number of one and a number below [`MAX_TILES`] are one word.
pub const MAX_BINS: u32 = 1 << 19;
/// Words of a facet on the device.
pub const FACET_WORDS: usize = 12;
/// Rays of the first band, before anything is known about the device's speed: fewer where a page waits.
pub const FIRST_BAND: u64 = if cfg!(target_arch = "wasm32") { 1 << 18 } else { 1 << 20 };
/// Most rays of a band.
pub const MOST_BAND: u64 = 1 << 22;
/// Most crossings of a band on a driver that computes on the processor, whose caches hold no more of it; but a row of bins may have more.
pub const MOST_CROSSINGS: u64 = 1 << 23;
/// Bands on the device at once: while one is read back and one runs, the next waits its turn.
pub const BANDS_IN_FLIGHT: usize = 3;

/// So many facets have a place each in every band.
const FEW_FACETS: u64 = 1 << 16;
/// Bytes of a facet: its corners and its first item.
const FACET_BYTES: u64 = 4 * FACET_WORDS as u64 + 4;
/// Bytes on the host of a facet that a band has chosen.
pub const CHOSEN_BYTES: u64 = 32;
/// Bytes of what is small among the buffers of a band: parameters, totals, the rounding of sizes.
const SMALL_BYTES: u64 = 1 << 12;
/// Bytes of a tile.
const TILE_BYTES: u64 = 32;
/// Bytes of what the lattice finds for a tile.
const FOUND_BYTES: u64 = 16;
/// Bytes of a place of four runs.
const PLACE_BYTES: u64 = 16;
/// Bytes of the centre of a cell.
const CENTRE_BYTES: u64 = 4;
/// Bytes of a chunk, a row of rays of one bin.
const CHUNK_BYTES: u64 = 8;
/// Bytes of a counter, one a layer of a bin: its count, and its part in the sums of the scan.
const COUNTER_BYTES: u64 = 5;

/// What is known of a band before it runs.
pub struct BandSize {
    pub n_facets: u64,
    /// Facets of the mesh.
    pub n_all_facets: u64,
    pub n_crossings: u64,
    /// Facets over a bin of which they hit a ray, nearly; 0 where nothing is known of them.
    pub n_tiles: u64,
    pub n_rays: u64,
    pub n_bins: u64,
    pub n_chunks: u64,
    pub n_layers: u32,
}

/// How much the buffers of a band hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Capacity {
    /// Facets that rays of the band may hit.
    pub n_facets: u64,
    /// Centres of cells along all axes, where these differ in size.
    pub n_centres: u64,
    /// Rows of rays of one bin.
    pub n_chunks: u64,
    /// Layers of all bins.
    pub n_counters: u64,
    /// Facets over a bin of which they hit a ray.
    pub n_tiles: u64,
    /// Places of four runs.
    pub n_places: u64,
}

impl Capacity {
    /// The most that buffers of at most so many bytes each can hold, where a band gets `band_bytes` for all.
    pub fn limit(binding_bytes: u64, band_bytes: u64) -> Capacity {
        // counts are u32; a place has 27 bits; validation of bindings of 4 GiB is not everywhere the same
        let bytes = binding_bytes.min(1 << 31);
        let n_facets =
            (bytes / (4 * FACET_WORDS as u64)).min(band_bytes.saturating_sub(SMALL_BYTES) / (2 * FACET_BYTES));
        Capacity {
            n_facets: n_facets.max(1),
            n_centres: bytes / CENTRE_BYTES,
            n_chunks: bytes / CHUNK_BYTES,
            n_counters: bytes / 4 - 1,
            n_tiles: bytes / TILE_BYTES,
            n_places: (bytes / PLACE_BYTES).min((1 << 27) - 1),
        }
    }

    /// What the first try at a band gets, which has nearly `n_crossings`: tiles and places are known only when it has run. As far as can be
    /// it does not depend on what the band holds, so that the next needs no buffers of its own.
    pub fn first(size: &BandSize) -> Capacity {
        let &BandSize { n_facets, n_all_facets, n_crossings, n_tiles, n_rays, n_bins, n_chunks, n_layers } = size;
        // of many facets most hit no ray
        let (n_facets, some_tiles) = if n_all_facets <= FEW_FACETS {
            (n_all_facets, 3 * n_all_facets)
        } else {
            (n_facets, (3 * n_facets).min(n_crossings / 2 * 3))
        };
        Capacity {
            n_facets,
            n_centres: 0,
            n_chunks,
            n_counters: n_bins * u64::from(n_layers),
            n_tiles: 16 * n_bins + some_tiles.max(n_tiles / 4 * 5),
            n_places: (2 * n_rays).max(n_rays + n_crossings / 8 * 3),
        }
    }

    /// A little more, up to a quarter, so that bands that are nearly alike need no buffers of their own.
    pub fn rounded(self) -> Capacity {
        self.with(self, |n, _| n.next_multiple_of((n / 8 + 1).next_power_of_two()))
    }

    /// The larger of both in everything.
    pub fn max(self, other: Capacity) -> Capacity {
        self.with(other, u64::max)
    }

    /// The smaller of both in everything.
    pub fn min(self, other: Capacity) -> Capacity {
        self.with(other, u64::min)
    }

    fn with(self, other: Capacity, choose: impl Fn(u64, u64) -> u64) -> Capacity {
        Capacity {
            n_facets: choose(self.n_facets, other.n_facets),
            n_centres: choose(self.n_centres, other.n_centres),
            n_chunks: choose(self.n_chunks, other.n_chunks),
            n_counters: choose(self.n_counters, other.n_counters),
            n_tiles: choose(self.n_tiles, other.n_tiles),
            n_places: choose(self.n_places, other.n_places),
        }
    }

    /// Whether it holds all of another.
    pub fn holds(self, other: Capacity) -> bool {
        self.max(other) == self
    }

    /// Bytes of its buffers on the device.
    pub fn n_bytes(self) -> u64 {
        FACET_BYTES * self.n_facets
            + CENTRE_BYTES * self.n_centres
            + CHUNK_BYTES * self.n_chunks
            + COUNTER_BYTES * self.n_counters
            + (TILE_BYTES + FOUND_BYTES) * self.n_tiles
            + PLACE_BYTES * self.n_places
    }

    /// Bytes on the device while its facets are on their way, from a buffer of the driver's.
    pub fn n_bytes_at_most(self) -> u64 {
        self.n_bytes() + FACET_BYTES * self.n_facets + SMALL_BYTES
    }
}

/// Bytes of buffers that each of some bands may have where a device may hold so many, and those of the deep rows of a band: only one at a
/// time has buffers for them.
pub fn shares(device_bytes: u64, n_bands: u64) -> [u64; 2] {
    let deep = device_bytes / (2 * BANDS_IN_FLIGHT as u64 + 1);
    [2 * deep * BANDS_IN_FLIGHT as u64 / n_bands, deep]
}

/// Bytes that a device must be allowed to hold for bands of so many bytes.
pub fn device_bytes(band_bytes: u64) -> u64 {
    band_bytes.div_ceil(2) * (2 * BANDS_IN_FLIGHT as u64 + 1)
}

/// Bytes of the buffers of so many deep rows, and their crossings.
pub fn deep_bytes(n_rows: u64, n_events: u64) -> u64 {
    72 * n_rows + 8 * n_events + SMALL_BYTES
}

/// Bytes on the host of the facets of bands in flight, in all and of the largest: chosen, in a buffer of the driver's, and packed for one
/// band.
pub fn upload_bytes(n_in_flight: u64, n_most: u64) -> u64 {
    (CHOSEN_BYTES + FACET_BYTES) * n_in_flight + FACET_BYTES * n_most
}

/// Rounds a number of ray rows down to whole bins, at least one.
pub fn whole_bins(rows: u64) -> u64 {
    let bin = u64::from(BIN);
    (rows / bin * bin).max(bin)
}

/// Layers of a bin for so many crossings a ray where it is most crowded: map keeps eight crossings of a ray at a time, and has to find
/// the next ones in later layers.
pub fn layers(crossings_of_ray: f64) -> u32 {
    if crossings_of_ray <= 8.5 {
        1
    } else {
        ((crossings_of_ray / 2.0).ceil() as u32).next_power_of_two().min(MAX_LAYERS)
    }
}

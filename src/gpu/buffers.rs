//! Every buffer of the GPU backend and every size, computed in u64 before anything is allocated.

use wgpu::{Buffer, BufferDescriptor, BufferUsages, Device, Limits};

use super::layout::{BIN, FACET_WORDS, Params};
use crate::error::{Error, Result};

/// Bytes of a tile, which is what a (facet, bin) pair needs.
const TILE_BYTES: u64 = 32;
/// Bytes of the edges of a (facet, bin) pair.
const EDGES_BYTES: u64 = 32;
/// Bytes of the plane of a (facet, bin) pair.
const PLANE_BYTES: u64 = 48;
/// Elements that one workgroup of a scan covers; `BLOCK` in `shaders/shared/scan.wgsl`.
pub(crate) const SCAN_BLOCK: u64 = 4096;

/// How much a band may hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Capacity {
    pub(crate) n_rays: u64,
    pub(crate) n_bins: u64,
    pub(crate) n_pairs: u64,
    /// Crossings, or runs with what stands between them; a multiple of 4.
    pub(crate) n_events: u64,
}

impl Capacity {
    /// The most that buffers within the limits of a device can hold.
    pub(crate) fn limit(limits: &Limits) -> Capacity {
        let bytes = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
        // counts are u32, and wgpu's validation of 4 GiB bindings is not everywhere the same
        let words = (bytes / 4).min(1 << 29) - 1;
        let n_bins = words / (2 * u64::from(BIN));
        // so many pairs have at most 2^31 crossings, whose places are handed out with a u32
        let n_pairs = (bytes / PLANE_BYTES).min(1 << 25);
        Capacity { n_rays: words, n_bins, n_pairs, n_events: words }
    }

    /// Whether a band with these numbers fits.
    pub(crate) fn holds(&self, n_pairs: u64, n_events: u64) -> bool {
        n_pairs <= self.n_pairs && n_events <= self.n_events
    }
}

/// The facets of a band, and the flags of all.
#[derive(Clone)]
pub(crate) struct Facets {
    /// Facets of the mesh: so many there is room for.
    pub(crate) n_facets: u64,
    pub(crate) corners: Buffer,
    pub(crate) flag_of_rank: Buffer,
}

impl Facets {
    /// Allocates the buffers of `n_facets` facets.
    pub(crate) fn new(device: &Device, n_facets: u64) -> Facets {
        Facets {
            n_facets,
            corners: storage(device, "corners", 4 * FACET_WORDS as u64 * n_facets),
            flag_of_rank: uniform(device, "flag of rank", 256),
        }
    }
}

/// Buffers of one band of a mesh on the device.
pub(crate) struct Buffers {
    pub(crate) capacity: Capacity,
    pub(crate) facets: Facets,
    pub(crate) params: Buffer,
    /// Rows of bins of each facet, scanned in place.
    pub(crate) row_offsets: Buffer,
    /// Facets of each bin, scanned in place.
    pub(crate) bin_offsets: Buffer,
    pub(crate) next_pair: Buffer,
    pub(crate) pairs: Buffer,
    pub(crate) tiles: Buffer,
    pub(crate) runs: Buffer,
    /// Where the runs of each row of a bin are.
    pub(crate) chunks: Buffer,
    /// `Totals` in `shaders/shared/chunks.wgsl`.
    pub(crate) totals: Buffer,
    /// Sums of each level of a scan, and a zero for its top.
    pub(crate) sums: Vec<Buffer>,
    pub(crate) n_bytes: u64,
}

impl Buffers {
    /// Allocates the buffers of a band of the given capacity.
    pub(crate) fn new(device: &Device, facets: Facets, capacity: Capacity) -> Buffers {
        let mut n_bytes = facets.corners.size();
        let mut storage = |label: &str, bytes: u64| {
            let buffer = storage(device, label, bytes);
            n_bytes += buffer.size();
            buffer
        };
        let n_facets = facets.n_facets;
        let mut sums = Vec::new();
        let mut n = (n_facets + 1).max(capacity.n_rays + 1).max(capacity.n_bins + 1);
        while n > 1 {
            n = n.div_ceil(SCAN_BLOCK);
            sums.push(storage("scan sums", 4 * n));
        }
        sums.push(storage("scan zero", 4));
        Buffers {
            capacity,
            row_offsets: storage("row offsets", 4 * (n_facets + 1)),
            bin_offsets: storage("bin offsets", 4 * (capacity.n_bins + 1)),
            next_pair: storage("next pair", 4 * (capacity.n_bins + 1)),
            pairs: storage("pairs", 8 * capacity.n_pairs),
            tiles: storage("tiles", TILE_BYTES * capacity.n_pairs),
            runs: storage("runs", 4 * capacity.n_events),
            chunks: storage("chunks", 8 * u64::from(BIN) * capacity.n_bins),
            totals: storage("totals", 16),
            sums,
            params: uniform(device, "params", size_of::<Params>() as u64),
            facets,
            n_bytes,
        }
    }
}

/// What the exact intersection needs of the (facet, bin) pairs.
pub(crate) struct PairBuffers {
    pub(crate) edges: Buffer,
    pub(crate) planes: Buffer,
}

impl PairBuffers {
    /// Allocates the buffers of so many pairs.
    pub(crate) fn new(device: &Device, n_pairs: u64) -> PairBuffers {
        PairBuffers {
            edges: storage(device, "edges", EDGES_BYTES * n_pairs),
            planes: storage(device, "planes", PLANE_BYTES * n_pairs),
        }
    }

    /// Bytes on the device.
    pub(crate) fn n_bytes(&self) -> u64 {
        self.edges.size() + self.planes.size()
    }
}

/// What lies between the stages when they run one by one.
pub(crate) struct CrossingBuffers {
    pub(crate) pairs: PairBuffers,
    /// Crossings of each ray, scanned in place.
    pub(crate) ray_offsets: Buffer,
    pub(crate) events: Buffer,
    /// Runs of each ray, scanned in place.
    pub(crate) run_offsets: Buffer,
    pub(crate) n_odd: Buffer,
}

impl CrossingBuffers {
    /// Allocates what a band of the given capacity has between its stages.
    pub(crate) fn new(device: &Device, capacity: Capacity) -> CrossingBuffers {
        CrossingBuffers {
            pairs: PairBuffers::new(device, capacity.n_pairs),
            ray_offsets: storage(device, "ray offsets", 4 * (capacity.n_rays + 1)),
            events: storage(device, "events", 4 * capacity.n_events),
            run_offsets: storage(device, "run offsets", 4 * (capacity.n_rays + 1)),
            n_odd: storage(device, "odd rays", 4),
        }
    }
}

fn storage(device: &Device, label: &str, bytes: u64) -> Buffer {
    let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC | BufferUsages::COPY_DST;
    let size = bytes.next_multiple_of(16).max(64);
    device.create_buffer(&BufferDescriptor { label: Some(label), size, usage, mapped_at_creation: false })
}

fn uniform(device: &Device, label: &str, size: u64) -> Buffer {
    let usage = BufferUsages::UNIFORM | BufferUsages::COPY_DST;
    device.create_buffer(&BufferDescriptor { label: Some(label), size, usage, mapped_at_creation: false })
}

/// Checks that the facets fit one binding.
///
/// # Errors
/// `too-many-facets` with the numbers.
pub(crate) fn check_facets(n_facets: u64, limits: &Limits) -> Result<()> {
    let bytes = 4 * FACET_WORDS as u64 * n_facets;
    let limit = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
    if bytes > limit {
        let message = format!("{n_facets} facets need a GPU buffer of {bytes} bytes; this device allows {limit}");
        return Err(Error::new("too-many-facets", message, "use the CPU backend"));
    }
    Ok(())
}

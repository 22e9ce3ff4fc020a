//! The buffers of a band, typed by their elements, and the pool that keeps them between meshes. Their sizes are those of `cast::sizes`.

use std::marker::PhantomData;
use std::sync::{Mutex, PoisonError};

use wgpu::{Buffer, BufferBinding, BufferDescriptor, BufferUsages, Queue};

use crate::device::Opened;
use crate::device_bytes::Share;
use crate::layout::Params;
use hexcast_core::stages::cast::sizes::{Capacity, MAX_LAYERS};

/// Elements that one workgroup of a scan covers; `BLOCK` in `shaders/shared/scan.wgsl`.
pub const SCAN_BLOCK: u64 = 4096;
/// Most bytes that the pool keeps between meshes.
const MAX_POOL_BYTES: u64 = 256 << 20;

/// A buffer of `T`.
#[derive(Debug)]
pub(crate) struct Array<T> {
    pub(crate) buffer: Buffer,
    element: PhantomData<T>,
    _share: Share,
}

/// A part of a buffer, as a kernel binds it or the host reads it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Part<'a> {
    pub(crate) buffer: &'a Buffer,
    /// Words of an element.
    pub(crate) words: u32,
    /// First byte, and bytes.
    pub(crate) bytes: [u64; 2],
}

impl<'a> Part<'a> {
    pub(crate) fn binding(self) -> BufferBinding<'a> {
        BufferBinding { buffer: self.buffer, offset: self.bytes[0], size: std::num::NonZeroU64::new(self.bytes[1]) }
    }
}

impl<T: bytemuck::Pod> Array<T> {
    fn with_usage(opened: &Opened, label: &str, len: u64, usage: BufferUsages) -> Array<T> {
        let size = (size_of::<T>() as u64 * len).next_multiple_of(16).max(64);
        let usage = usage | BufferUsages::COPY_DST;
        let descriptor = BufferDescriptor { label: Some(label), size, usage, mapped_at_creation: false };
        let buffer = opened.device.create_buffer(&descriptor);
        Array { buffer, element: PhantomData, _share: Share::new(&opened.held, size) }
    }

    /// Allocates a buffer that kernels read and write.
    pub(crate) fn storage(opened: &Opened, label: &str, len: u64) -> Array<T> {
        Array::with_usage(opened, label, len, BufferUsages::STORAGE | BufferUsages::COPY_SRC)
    }

    /// Allocates a small buffer that all threads read.
    pub(crate) fn uniform(opened: &Opened, label: &str, len: u64) -> Array<T> {
        Array::with_usage(opened, label, len, BufferUsages::UNIFORM)
    }

    /// Sets the first elements before what is submitted next.
    pub(crate) fn write(&self, queue: &Queue, elements: &[T]) {
        queue.write_buffer(&self.buffer, 0, bytemuck::cast_slice(elements));
    }

    /// Sets elements from an index on before what is submitted next.
    pub(crate) fn write_at(&self, queue: &Queue, index: u64, elements: &[T]) {
        queue.write_buffer(&self.buffer, size_of::<T>() as u64 * index, bytemuck::cast_slice(elements));
    }

    /// All of it.
    pub(crate) fn all(&self) -> Part<'_> {
        Part { buffer: &self.buffer, words: size_of::<T>() as u32 / 4, bytes: [0, self.buffer.size()] }
    }

    /// The first elements.
    pub(crate) fn first(&self, len: u64) -> Part<'_> {
        self.part(0, len)
    }

    /// `len` elements from an index on.
    pub(crate) fn part(&self, start: u64, len: u64) -> Part<'_> {
        let size = size_of::<T>() as u64;
        Part { bytes: [size * start, size * len], ..self.all() }
    }
}

/// Buffers of one band of a mesh on the device.
pub(crate) struct Buffers {
    pub(crate) capacity: Capacity,
    pub(crate) params: Array<Params>,
    pub(crate) layer_ends: Array<[u32; 4]>,
    pub(crate) corners: Array<[i32; 4]>,
    pub(crate) item_offsets: Array<u32>,
    /// Centres of cells that differ in size: of rays, cells along them and rows of rays.
    pub(crate) centres: Array<i32>,
    /// Tiles of each layer of each bin, scanned in place; the total in the last entry.
    pub(crate) bin_offsets: Array<u32>,
    /// What facets hit in bins, in no order; as many as tiles.
    pub(crate) found: Array<[u32; 4]>,
    /// How many these are, and the rays that they hit.
    pub(crate) found_totals: Array<u32>,
    pub(crate) tiles: Array<[u32; 4]>,
    pub(crate) runs: Array<[u32; 4]>,
    pub(crate) chunks: Array<[u32; 2]>,
    /// `Totals` in `shaders/map.wgsl`.
    pub(crate) totals: Array<u32>,
    pub(crate) sums: Sums,
}

impl Buffers {
    /// Allocates the buffers of a band of the given capacity.
    pub(crate) fn new(opened: &Opened, capacity: Capacity) -> Buffers {
        Buffers {
            capacity,
            params: Array::uniform(opened, "params", 1),
            layer_ends: Array::uniform(opened, "layer ends", u64::from(MAX_LAYERS) / 4),
            corners: Array::storage(opened, "corners", 3 * capacity.n_facets),
            item_offsets: Array::storage(opened, "item offsets", capacity.n_facets + 1),
            centres: Array::storage(opened, "centres", capacity.n_centres),
            bin_offsets: Array::storage(opened, "bin offsets", capacity.n_counters + 1),
            found: Array::storage(opened, "found", capacity.n_tiles),
            found_totals: Array::storage(opened, "found totals", 2),
            tiles: Array::storage(opened, "tiles", 2 * capacity.n_tiles),
            runs: Array::storage(opened, "runs", capacity.n_places),
            chunks: Array::storage(opened, "chunks", capacity.n_chunks),
            totals: Array::storage(opened, "totals", 4),
            sums: Sums::new(opened, capacity.n_counters + 1),
        }
    }
}

/// What a scan needs besides its numbers: the sums of the blocks of each level, and for the top what comes before all, zero at first.
#[derive(Debug)]
pub(crate) struct Sums(pub(crate) Vec<Array<u32>>);

impl Sums {
    /// Allocates the sums of scans of up to `n` numbers.
    pub(crate) fn new(opened: &Opened, mut n: u64) -> Sums {
        let mut sums = Vec::new();
        while n > 1 {
            n = n.div_ceil(SCAN_BLOCK);
            sums.push(Array::storage(opened, "scan sums", n));
        }
        sums.push(Array::storage(opened, "scan zero", 1));
        Sums(sums)
    }

    /// Sets what comes before all numbers.
    pub(crate) fn begin_at(&self, queue: &Queue, base: u32) {
        self.0[self.0.len() - 1].write(queue, &[base]);
    }
}

/// Buffers of the deep rows of a band.
#[derive(Debug)]
pub(crate) struct DeepBuffers {
    /// Crossings of each deep row, scanned in place; the total in the last entry.
    pub(crate) event_offsets: Array<u32>,
    pub(crate) next_event: Array<u32>,
    /// Twice as many as there are crossings: the sort goes from one half to the other.
    pub(crate) events: Array<u32>,
    /// Of each deep row: where the runs of each of its rays begin in `events`, and how many there are.
    pub(crate) deep_rows: Array<u32>,
    pub(crate) sums: Sums,
}

impl DeepBuffers {
    /// Allocates for `n_rows` rows, and no crossings yet.
    pub(crate) fn new(opened: &Opened, n_rows: u64) -> DeepBuffers {
        DeepBuffers {
            event_offsets: Array::storage(opened, "event offsets", n_rows + 1),
            next_event: Array::storage(opened, "next event", n_rows + 1),
            events: Array::storage(opened, "events", 0),
            deep_rows: Array::storage(opened, "deep rows", 16 * n_rows),
            sums: Sums::new(opened, n_rows + 1),
        }
    }

    /// Makes room for so many crossings.
    pub(crate) fn with_events(self, opened: &Opened, n_events: u64) -> DeepBuffers {
        DeepBuffers { events: Array::storage(opened, "events", 2 * n_events), ..self }
    }
}

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

/// The pool: buffers of finished meshes, kept for the next mesh of the device. To make new buffers, clear them and touch their pages for the
/// first time takes a driver longer than a small mesh.
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
        while pool.iter().map(Pooled::n_bytes).sum::<u64>() > MAX_POOL_BYTES {
            pool.remove(0);
        }
    }
}

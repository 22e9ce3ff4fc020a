//! The flags of a box of cells in a buffer of a device: only runs are uploaded, and the kernel `expand` makes flags of them.
//!
//! Mesh, a box, a device -> a buffer. The box is expanded slab by slab, so the device holds the runs of one slab at a time.
//! Twin: `crates/core/src/cells/flags.rs`.

use std::sync::Arc;

use wgpu::{Buffer, BufferDescriptor, BufferUsages, Device, ErrorFilter, Queue};

use crate::Gpu;
use crate::buffers::{Array, Part};
use crate::device::{Opened, USE_CPU};
use crate::kernels::{Kernel, Kernels};
use crate::passes::{Passes, square};
use crate::resident::{most_bytes, too_large};
use hexcast_core::base::error::{Error, Result};
use hexcast_core::cells::columns::BoxRuns;
use hexcast_core::cells::flags::{CellBox, slabs_of_box};
use hexcast_derived::mesh::Mesh;

/// Cells that are expanded together; at worst each is a run of its own, which is half of WebGPU's default limit of a binding.
const SLAB_CELLS: usize = 16 << 20;
/// What WebGPU asks offsets of bindings to be multiples of, at most.
const ALIGNMENT: u64 = 256;

/// How cells lie in a buffer. Rows along x follow each other, y before z, and the last word is filled up with 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Cells {
    /// A byte each, the flag: cell (x, y, z) is byte `x + nx * (y + ny * z)`.
    Bytes,
    /// A bit each, 1 where the flag is not 0, as `write::bits` has them: cell (x, y, z) is bit `x % 8` of byte
    /// `x / 8 + row_bytes * (y + ny * z)`, where a row has `nx / 8` bytes, rounded up.
    Bits,
}

impl Cells {
    /// Cells of a byte.
    fn per_byte(self) -> u32 {
        match self {
            Cells::Bytes => 1,
            Cells::Bits => 8,
        }
    }
}

/// The numbers of a slab; `Slab` in `shaders/expand.wgsl`, where each is explained.
#[repr(C)]
#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct Slab {
    n: [u32; 3],
    axis: u32,
    row_bytes: u32,
    skip: u32,
    per_byte: u32,
}

/// Makes buffers of flags on a device of the caller's own. The first makes it compile its kernel: keep it for others.
///
/// The device's handlers stay the caller's. wgpu tells of a lost device by the device's own callback only: the buffer is then as lost.
pub struct Expander {
    pub(super) opened: Opened,
    pub(super) kernels: Arc<Kernels>,
}

impl Expander {
    /// Takes a device and its queue.
    pub fn new(device: &Device, queue: &Queue) -> Expander {
        Expander { opened: Opened::of_caller(device, queue), kernels: Kernels::shared(device, None) }
    }

    /// Expands the flags of a box of cells, end exclusive, to a new buffer with the usages `STORAGE`, `COPY_SRC` and `COPY_DST`. What is
    /// submitted to the queue from then on finds the flags there.
    ///
    /// # Errors
    /// - `job-value`: the box reaches past the mesh, ends before it starts, or has no cell.
    /// - `memory`: it takes more bytes than a buffer of the device has, or than there are.
    /// - `device-failed`: the driver reported an error.
    /// - `io`: the columns are in a store that fails.
    pub async fn flags_buffer(&self, mesh: &Mesh, cells: &CellBox, form: Cells) -> Result<Buffer> {
        flags_buffer(&self.opened, &self.kernels, mesh, cells, form).await
    }
}

impl Gpu {
    /// Expands the flags of a box of cells to a new buffer of this device, as [`Expander::flags_buffer`] does.
    ///
    /// # Errors
    /// Those of [`Expander::flags_buffer`].
    pub async fn flags_buffer(&self, mesh: &Mesh, cells: &CellBox, form: Cells) -> Result<Buffer> {
        flags_buffer(&self.opened, &self.kernels, mesh, cells, form).await
    }
}

async fn flags_buffer(opened: &Opened, kernels: &Kernels, mesh: &Mesh, cells: &CellBox, form: Cells) -> Result<Buffer> {
    let dims = mesh.dims();
    if (0..3).any(|axis| cells[axis].is_empty() || cells[axis].end > dims[axis]) {
        let message =
            format!("box {cells:?} is empty or not inside the mesh of {} x {} x {} cells", dims[0], dims[1], dims[2]);
        return Err(Error::new("job-value", message, "choose ends above starts, and within the mesh"));
    }
    let [nx, ny, nz] = [0, 1, 2].map(|axis| cells[axis].len() as u64);
    let row_bytes = nx.div_ceil(form.per_byte().into());
    let (size, allowed) = ((row_bytes * ny * nz).next_multiple_of(4), opened.device.limits().max_buffer_size);
    if size > allowed {
        let message =
            format!("the flags of {nx} x {ny} x {nz} cells take {size} bytes; a buffer of this device has {allowed}");
        return Err(Error::new("memory", message, "take a smaller box, or one bit per cell"));
    }
    within_scopes(opened, || expanded(opened, kernels, mesh, cells, (form, size))).await
}

/// Expands slab after slab; what goes wrong on the device is told elsewhere.
fn expanded(
    opened: &Opened,
    kernels: &Kernels,
    mesh: &Mesh,
    cells: &CellBox,
    (form, size): (Cells, u64),
) -> Result<Buffer> {
    let Opened { device, queue, .. } = opened;
    let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC | BufferUsages::COPY_DST;
    let label = Some("flags");
    let flags = device.create_buffer(&BufferDescriptor { label, size, usage, mapped_at_creation: false });
    // words of runs and offsets, and bytes of flags, fit their bindings
    let most = (device.limits().max_storage_buffer_binding_size / 4).saturating_sub(ALIGNMENT) as usize;
    for slab in slabs_of_box(cells, most.min(SLAB_CELLS)) {
        let BoxRuns { offsets, runs } = mesh.box_runs(&slab)?;
        let n = [0, 1, 2].map(|axis| slab[axis].len() as u32);
        let row_bytes = n[0].div_ceil(form.per_byte());
        let rows = u64::from(slab[1].start - cells[1].start)
            + cells[1].len() as u64 * u64::from(slab[2].start - cells[2].start);
        let start = rows * u64::from(row_bytes);
        let skip = start % ALIGNMENT;
        let n_words = (skip + u64::from(row_bytes) * u64::from(n[1]) * u64::from(n[2])).div_ceil(4);
        let axis = mesh.columns().rays().axis as u32;
        let slab = Slab { n, axis, row_bytes, skip: skip as u32, per_byte: form.per_byte() };
        let [offsets, runs] = [("offsets", offsets), ("runs", runs)].map(|(label, words)| {
            let array = Array::storage(opened, label, words.len() as u64);
            array.write(queue, &words);
            array
        });
        let part = Part { buffer: &flags, words: 1, bytes: [start - skip, 4 * n_words] };
        expand_slab(opened, kernels, slab, [offsets.all(), runs.all(), part]);
    }
    Ok(flags)
}

/// Runs the kernel on a slab: its offsets and runs, and where its flags go.
fn expand_slab(opened: &Opened, kernels: &Kernels, slab: Slab, [offsets, runs, flags]: [Part; 3]) {
    let params = Array::uniform(opened, "slab", 1);
    params.write(&opened.queue, &[slab]);
    let encoder = opened.encoder();
    let mut passes = Passes { opened, kernels, is_software: false, encoder, profile: None };
    let n_groups = (flags.bytes[1] / 4).div_ceil(64);
    passes.dispatch(Kernel::Expand, &[params.all(), offsets, runs, flags], square(n_groups));
    opened.queue.submit([passes.encoder.finish()]);
}

/// Expands all flags of runs that are on the device.
///
/// # Errors
/// `memory`, `device-failed`.
pub(super) async fn expand_all(
    opened: &Opened,
    kernels: &Kernels,
    (axis, n): (usize, [u32; 3]),
    [offsets, runs]: [Part<'_>; 2],
    form: Cells,
) -> Result<Buffer> {
    let row_bytes = n[0].div_ceil(form.per_byte());
    let size = (u64::from(row_bytes) * u64::from(n[1]) * u64::from(n[2])).next_multiple_of(4);
    let allowed = most_bytes(opened);
    if size > allowed {
        return Err(too_large(&format!("the flags of {} x {} x {} cells", n[0], n[1], n[2]), size, allowed));
    }
    within_scopes(opened, || {
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC | BufferUsages::COPY_DST;
        let label = Some("flags");
        let flags = opened.device.create_buffer(&BufferDescriptor { label, size, usage, mapped_at_creation: false });
        let slab = Slab { n, axis: axis as u32, row_bytes, skip: 0, per_byte: form.per_byte() };
        let part = Part { buffer: &flags, words: 1, bytes: [0, size] };
        expand_slab(opened, kernels, slab, [offsets, runs, part]);
        Ok(flags)
    })
    .await
}

/// Does something with a device, and waits for what it says of it.
///
/// # Errors
/// `memory`, `device-failed`.
pub(super) async fn within_scopes<T>(opened: &Opened, act: impl FnOnce() -> Result<T>) -> Result<T> {
    let filters = [ErrorFilter::Validation, ErrorFilter::OutOfMemory, ErrorFilter::Internal];
    let [first, second, third] = filters.map(|filter| opened.device.push_error_scope(filter));
    let made = act();
    for told in [third.pop(), second.pop(), first.pop()] {
        if let Some(error) = told.await {
            let code = if matches!(error, wgpu::Error::OutOfMemory { .. }) { "memory" } else { "device-failed" };
            return Err(Error::new(code, format!("this cannot be done on the device: {error}"), USE_CPU));
        }
    }
    made
}

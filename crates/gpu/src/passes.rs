//! The passes of a band, in order, as commands: which kernel binds which buffers, over how many threads.
//!
//! No invocation runs more than 2^14 loops: threads are as many as that takes, see the constants.

use wgpu::{BindGroupDescriptor, BindGroupEntry, BindingResource, CommandEncoder};

use crate::buffers::{Buffers, DeepBuffers, Part, SCAN_BLOCK, Sums};
use crate::device::Opened;
use crate::kernels::{Kernel, Kernels};
use crate::layout::Params;
use crate::pace::Instant;

/// Most workgroups along a dimension of a dispatch.
const MAX_GROUPS: u64 = 65_535;
/// Threads that share a list, at least: enough for any GPU.
const THREADS: u64 = 1 << 16;
/// The same where a driver computes on the processor, and a workgroup that finds nothing to do costs it 10 microseconds.
const THREADS_OF_SOFTWARE: u64 = 1 << 12;
/// Most items of the walk over the lattice that a thread takes.
pub const ITEMS_OF_THREAD: u64 = 64;
/// The same in `intersect_deep`, where each may have 64 crossings in each bin.
pub const DEEP_ITEMS_OF_THREAD: u64 = 8;
/// The same in `intersect_graded`, which searches a cell for each of them.
pub const GRADED_ITEMS_OF_THREAD: u64 = 1;
/// Most tiles that a thread of `intersect` takes.
pub const TILES_OF_THREAD: u64 = 1 << 12;

/// Records the commands of one band.
pub(crate) struct Passes<'a> {
    pub(crate) opened: &'a Opened,
    pub(crate) kernels: &'a Kernels,
    /// Whether the driver computes on the processor.
    pub(crate) is_software: bool,
    pub(crate) encoder: CommandEncoder,
    /// Seconds of each kernel; when set, every dispatch is submitted and waited for by itself.
    pub(crate) profile: Option<&'a mut Profile>,
}

/// Seconds spent in each kernel that ran, summed over its dispatches.
pub type Profile = Vec<(Kernel, f64)>;

impl Passes<'_> {
    /// Builds the lattice: from `corners` and `item_offsets` to `bin_offsets` and `found`.
    pub(crate) fn lattice(&mut self, b: &Buffers, params: &Params) {
        let n = params.n_counters() + 1;
        self.encoder.clear_buffer(&b.bin_offsets.buffer, 0, Some(4 * n));
        self.encoder.clear_buffer(&b.found_totals.buffer, 0, None);
        let (items, counts, found) = (b.item_offsets.all(), b.bin_offsets.all(), b.found.all());
        let bindings = [b.params.all(), b.corners.all(), items, counts, found, b.found_totals.all()];
        let threads = self.sharing(params.n_items.into(), ITEMS_OF_THREAD);
        self.dispatch(Kernel::Lattice, &bindings, square(threads));
        self.scan(b.bin_offsets.first(n), &b.sums, 0);
    }

    /// Makes `tiles` of what is found.
    pub(crate) fn intersect(&mut self, b: &Buffers, params: &Params) {
        let threads = self.sharing(params.tile_capacity.into(), TILES_OF_THREAD);
        let (offsets, found, tiles) = (b.bin_offsets.all(), b.found.all(), b.tiles.all());
        let bindings = [b.params.all(), b.corners.all(), offsets, found, tiles, b.found_totals.all()];
        self.dispatch(Kernel::Intersect, &bindings, square(threads));
    }

    /// Casts the rays and maps their crossings, all but the deep rows: from `tiles` to `chunks` and `runs`.
    pub(crate) fn map(&mut self, b: &Buffers, params: &Params) {
        self.encoder.clear_buffer(&b.totals.buffer, 0, None);
        let (tiles, runs, chunks) = (b.tiles.all(), b.runs.all(), b.chunks.all());
        let bindings = [b.params.all(), b.bin_offsets.all(), tiles, runs, chunks, b.totals.all(), b.layer_ends.all()];
        // a workgroup casts the rays of 8 bins of a row
        let kernel = match params {
            Params { n_layers: 1, n_ranks: 1, rule: 0, .. } => Kernel::MapSimple,
            Params { n_layers: 1, .. } => Kernel::MapOneLayer,
            _ => Kernel::Map,
        };
        self.dispatch(kernel, &bindings, [params.n_across.div_ceil(8), params.n_bins / params.n_across]);
    }

    /// Casts the rays of the deep rows against a batch of facets: adds to `event_offsets` how many crossings each row has, or, when
    /// these are scanned, writes `events`.
    pub(crate) fn intersect_deep(&mut self, b: &Buffers, deep: &DeepBuffers, params: &Params) {
        let next = if params.event_capacity == 0 { &deep.event_offsets } else { &deep.next_event };
        let (kernel, last, items_of_thread) = match params.is_graded() {
            false => (Kernel::IntersectDeep, b.chunks.all(), DEEP_ITEMS_OF_THREAD),
            true => (Kernel::IntersectGraded, b.centres.all(), GRADED_ITEMS_OF_THREAD),
        };
        let bindings = [b.params.all(), b.corners.all(), b.item_offsets.all(), next.all(), deep.events.all(), last];
        let threads = self.sharing(params.n_items.into(), items_of_thread);
        self.dispatch(kernel, &bindings, square(threads));
    }

    /// Scans the numbers of crossings of the deep rows.
    pub(crate) fn scan_deep(&mut self, deep: &DeepBuffers, n_rows: u64) {
        self.scan(deep.event_offsets.first(n_rows + 1), &deep.sums, 0);
        let (from, to) = (&deep.event_offsets.buffer, &deep.next_event.buffer);
        self.encoder.copy_buffer_to_buffer(from, 0, to, 0, 4 * (n_rows + 1));
    }

    /// Maps the crossings of the deep rows: from `event_offsets` and `events` to `deep_rows` and runs in `events`.
    pub(crate) fn map_deep(&mut self, b: &Buffers, deep: &DeepBuffers, n_rows: u64) {
        // the kernel asks for the length of its offsets
        let offsets = deep.event_offsets.first(n_rows + 1);
        let bindings = [b.params.all(), offsets, deep.events.all(), deep.deep_rows.all()];
        self.dispatch(Kernel::MapDeep, &bindings, square(n_rows));
    }

    /// Replaces numbers by the sums of all before them; the kernels ask for the length of their arrays.
    pub(crate) fn scan(&mut self, numbers: Part, sums: &Sums, level: usize) {
        let n_blocks = (numbers.bytes[1] / 4).div_ceil(SCAN_BLOCK);
        let bases = if n_blocks == 1 { sums.0[sums.0.len() - 1].first(1) } else { sums.0[level].first(n_blocks) };
        if n_blocks > 1 {
            self.dispatch(Kernel::ScanReduce, &[numbers, bases], square(n_blocks));
            self.scan(bases, sums, level + 1);
        }
        self.dispatch(Kernel::ScanApply, &[numbers, bases], square(n_blocks));
    }

    /// Workgroups of 64 threads that share `n` things, at most `most` each.
    fn sharing(&self, n: u64, most: u64) -> u64 {
        let threads = if self.is_software { THREADS_OF_SOFTWARE } else { THREADS };
        threads.max(n.div_ceil(most)).div_ceil(64)
    }

    /// Records a kernel; `bindings` are in the order of its slots.
    pub(crate) fn dispatch(&mut self, kernel: Kernel, bindings: &[Part], groups: [u32; 2]) {
        debug_assert_eq!(bindings.len(), kernel.slots().len(), "{kernel:?}");
        let mut entries = Vec::with_capacity(bindings.len());
        for (&(binding, name, words), part) in kernel.slots().iter().zip(bindings) {
            debug_assert!(words == 0 || words == part.words, "{kernel:?}: {name} has {words} words an element");
            entries.push(BindGroupEntry { binding, resource: BindingResource::Buffer(part.binding()) });
        }
        let pipeline = self.kernels.get(kernel);
        let layout = pipeline.get_bind_group_layout(0);
        let descriptor = BindGroupDescriptor { label: None, layout: &layout, entries: &entries };
        let group = self.opened.device.create_bind_group(&descriptor);
        let mut pass = self.encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.dispatch_workgroups(groups[0], groups[1], 1);
        drop(pass);
        self.measure(kernel);
    }

    /// When profiling, runs what is recorded so far and adds the time to a kernel's.
    fn measure(&mut self, kernel: Kernel) {
        let Some(profile) = &mut self.profile else { return };
        let recorded = std::mem::replace(&mut self.encoder, self.opened.encoder());
        let start = Instant::now();
        self.opened.queue.submit([recorded.finish()]);
        // a failed wait shows in the mesh that follows; the profile then means nothing anyway
        let _ = self.opened.device.poll(wgpu::PollType::wait_indefinitely());
        let seconds = start.elapsed().as_secs_f64();
        match profile.iter_mut().find(|(known, _)| *known == kernel) {
            Some((_, sum)) => *sum += seconds,
            None => profile.push((kernel, seconds)),
        }
    }
}

/// Spreads workgroups over two dimensions where one would not hold them.
pub(super) fn square(n_groups: u64) -> [u32; 2] {
    let rows = n_groups.div_ceil(MAX_GROUPS).max(1);
    [n_groups.div_ceil(rows).max(1) as u32, rows as u32]
}

//! The passes of a band, in order, as commands: which kernel reads and writes which buffers, and over how many threads.

use web_time::Instant;
use wgpu::{BindGroupDescriptor, BindGroupEntry, BindingResource, Buffer, BufferBinding, CommandEncoder};

use super::buffers::{Buffers, CrossingBuffers, PairBuffers, SCAN_BLOCK};
use super::device::{AdapterKind, Gpu};
use super::kernels::Kernel;
use super::layout::Params;

/// Threads of a workgroup of all kernels but the scan.
const GROUP: u64 = 64;
/// Most workgroups along a dimension of a dispatch.
const MAX_GROUPS: u64 = 65_535;
/// Threads that share a list whose length only the device knows: enough for any GPU.
const SHARING_THREADS: u64 = 1 << 16;
/// The same where a driver computes on the processor, and a workgroup that finds nothing to do costs it 10 microseconds.
const SHARING_THREADS_SOFTWARE: u64 = 1 << 12;

/// Records the commands of one band.
pub(crate) struct Passes<'a> {
    pub(crate) gpu: &'a Gpu,
    pub(crate) buffers: &'a Buffers,
    pub(crate) params: &'a Params,
    pub(crate) encoder: CommandEncoder,
    /// Seconds of each kernel; when set, every dispatch is submitted and waited for by itself.
    pub(crate) profile: Option<&'a mut Profile>,
}

/// Seconds spent in each kernel that ran, summed over its dispatches.
pub type Profile = Vec<(Kernel, f64)>;

impl Passes<'_> {
    /// Builds the lattice: from `corners` to `bin_offsets` and `pairs`.
    pub(crate) fn lattice(&mut self) {
        let b = self.buffers;
        let n_facets = u64::from(self.params.n_facets);
        let n_bins = u64::from(self.params.n_bins);
        self.encoder.clear_buffer(&b.row_offsets, 0, Some(4 * (n_facets + 1)));
        self.encoder.clear_buffer(&b.bin_offsets, 0, Some(4 * (n_bins + 1)));
        self.run(Kernel::LatticeRows, &[(1, &b.facets.corners), (2, &b.row_offsets)], n_facets);
        self.scan(&b.row_offsets, n_facets + 1, 0);
        let walk = [(1, &b.facets.corners), (2, &b.row_offsets), (3, &b.bin_offsets)];
        self.run(Kernel::LatticeCount, &walk, self.sharing_threads());
        self.scan(&b.bin_offsets, n_bins + 1, 0);
        self.encoder.copy_buffer_to_buffer(&b.bin_offsets, 0, &b.next_pair, 0, 4 * (n_bins + 1));
        let fill = [(1, &b.facets.corners), (2, &b.row_offsets), (3, &b.next_pair), (4, &b.pairs)];
        self.run(Kernel::LatticeFill, &fill, self.sharing_threads());
    }

    /// Casts the rays and maps their crossings, all but the deep rows: from `bin_offsets` and `pairs` to `chunks` and `runs`.
    pub(crate) fn columns(&mut self) {
        let b = self.buffers;
        let setup = [(1, &b.facets.corners), (2, &b.bin_offsets), (3, &b.pairs), (4, &b.tiles)];
        self.run(Kernel::ColumnsSetup, &setup, self.sharing_threads());
        self.encoder.clear_buffer(&b.totals, 0, None);
        let kernel = match (self.params.n_ranks, self.params.rule) {
            (1, 0) => Kernel::ColumnsAlternating,
            (1, _) => Kernel::ColumnsOneRank,
            _ => Kernel::Columns,
        };
        let columns = [
            (2, &b.bin_offsets),
            (3, &b.tiles),
            (5, &b.runs),
            (6, &b.chunks),
            (7, &b.totals),
            (8, &b.facets.flag_of_rank),
        ];
        self.dispatch(kernel, &columns, self.groups_of_bins());
    }

    /// Casts the rays of the deep rows and maps their crossings: completes `chunks` and `runs`.
    pub(crate) fn columns_deep(&mut self, pairs: &PairBuffers) {
        self.setup(pairs);
        let b = self.buffers;
        let kernel = if self.params.n_ranks == 1 { Kernel::ColumnsDeepOneRank } else { Kernel::ColumnsDeep };
        let columns = [
            (2, &b.bin_offsets),
            (3, &pairs.edges),
            (4, &pairs.planes),
            (5, &b.runs),
            (6, &b.chunks),
            (7, &b.totals),
            (8, &b.facets.flag_of_rank),
        ];
        self.run(kernel, &columns, self.params.n_chunks());
    }

    /// Prepares the pairs: from `bin_offsets` and `pairs` to `edges` and `planes`.
    fn setup(&mut self, pairs: &PairBuffers) {
        let b = self.buffers;
        let setup = [(1, &b.facets.corners), (2, &b.bin_offsets), (3, &b.pairs), (4, &pairs.edges), (5, &pairs.planes)];
        self.run(Kernel::IntersectSetup, &setup, self.sharing_threads());
    }

    /// Casts the rays: from `bin_offsets` and `pairs` to `ray_offsets` and `events`.
    pub(crate) fn intersect(&mut self, c: &CrossingBuffers) {
        self.setup(&c.pairs);
        let b = self.buffers;
        let n_rays = u64::from(self.params.n_rays());
        self.encoder.clear_buffer(&c.ray_offsets, 0, Some(4 * (n_rays + 1)));
        let groups = self.groups_of_bins();
        let count = [(2, &b.bin_offsets), (3, &c.pairs.edges), (4, &c.ray_offsets)];
        self.dispatch(Kernel::IntersectCount, &count, groups);
        self.scan(&c.ray_offsets, n_rays + 1, 0);
        let emit =
            [(2, &b.bin_offsets), (3, &c.pairs.edges), (4, &c.pairs.planes), (5, &c.events), (6, &c.ray_offsets)];
        self.dispatch(Kernel::IntersectEmit, &emit, groups);
    }

    /// Workgroups of the kernels that cast rays: each those of 8 bins of a row.
    fn groups_of_bins(&self) -> [u32; 2] {
        [self.params.n_across.div_ceil(8), self.params.n_bins / self.params.n_across]
    }

    /// Maps crossings to runs: from `ray_offsets` and `events` to `run_offsets` and `runs`.
    pub(crate) fn map(&mut self, c: &CrossingBuffers) {
        let b = self.buffers;
        let n_rays = u64::from(self.params.n_rays());
        self.encoder.clear_buffer(&c.run_offsets, 0, Some(4 * (n_rays + 1)));
        self.encoder.clear_buffer(&c.n_odd, 0, None);
        let map =
            [(1, &c.ray_offsets), (2, &c.events), (3, &c.run_offsets), (4, &c.n_odd), (8, &b.facets.flag_of_rank)];
        let kernel = if self.params.n_ranks == 1 { Kernel::MapOneRank } else { Kernel::Map };
        self.run(kernel, &map, n_rays);
        self.scan(&c.run_offsets, n_rays + 1, 0);
        let compact = [(1, &c.ray_offsets), (2, &c.run_offsets), (3, &c.events), (4, &b.runs)];
        self.run(Kernel::Compact, &compact, n_rays);
    }

    /// Replaces the first n numbers of a buffer by the sums of all before them.
    fn scan(&mut self, numbers: &Buffer, n: u64, level: usize) {
        let n_blocks = n.div_ceil(SCAN_BLOCK);
        let zero = self.buffers.sums.len() - 1;
        let (bases, n_bases) =
            if n_blocks == 1 { (&self.buffers.sums[zero], 1) } else { (&self.buffers.sums[level], n_blocks) };
        let bindings = [sized(0, numbers, 4 * n), sized(1, bases, 4 * n_bases)];
        let groups = square(n_blocks);
        if n_blocks > 1 {
            self.encode(Kernel::ScanReduce, &bindings, groups);
            self.scan(bases, n_blocks, level + 1);
        }
        self.encode(Kernel::ScanApply, &bindings, groups);
    }

    fn sharing_threads(&self) -> u64 {
        match self.gpu.facts.kind {
            AdapterKind::Software => SHARING_THREADS_SOFTWARE,
            _ => SHARING_THREADS,
        }
    }

    fn run(&mut self, kernel: Kernel, bindings: &[(u32, &Buffer)], n_threads: u64) {
        self.dispatch(kernel, bindings, square(n_threads.div_ceil(GROUP)));
    }

    fn dispatch(&mut self, kernel: Kernel, bindings: &[(u32, &Buffer)], groups: [u32; 2]) {
        let mut entries = vec![BindGroupEntry { binding: 0, resource: self.buffers.params.as_entire_binding() }];
        entries.extend(
            bindings.iter().map(|&(binding, buffer)| BindGroupEntry { binding, resource: buffer.as_entire_binding() }),
        );
        self.encode(kernel, &entries, groups);
    }

    fn encode(&mut self, kernel: Kernel, entries: &[BindGroupEntry], groups: [u32; 2]) {
        let pipeline = self.gpu.kernels.get(kernel);
        let layout = pipeline.get_bind_group_layout(0);
        let group = self.gpu.device.create_bind_group(&BindGroupDescriptor { label: None, layout: &layout, entries });
        let mut pass = self.encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.dispatch_workgroups(groups[0], groups[1], 1);
        drop(pass);
        self.measure(kernel);
    }

    /// When profiling, runs what is recorded so far and books the time to a kernel.
    fn measure(&mut self, kernel: Kernel) {
        let Some(profile) = &mut self.profile else { return };
        let next = self.gpu.device.create_command_encoder(&Default::default());
        let recorded = std::mem::replace(&mut self.encoder, next);
        let start = Instant::now();
        self.gpu.queue.submit([recorded.finish()]);
        // a failed wait shows in the mesh that follows; the profile then means nothing anyway
        let _ = self.gpu.device.poll(wgpu::PollType::wait_indefinitely());
        let seconds = start.elapsed().as_secs_f64();
        match profile.iter_mut().find(|(known, _)| *known == kernel) {
            Some((_, sum)) => *sum += seconds,
            None => profile.push((kernel, seconds)),
        }
    }
}

/// Spreads workgroups over two dimensions where one would not hold them.
fn square(n_groups: u64) -> [u32; 2] {
    let rows = n_groups.div_ceil(MAX_GROUPS).max(1);
    [n_groups.div_ceil(rows).max(1) as u32, rows as u32]
}

/// A binding of exactly the first `size` bytes: the scans ask for the length of their arrays.
fn sized(binding: u32, buffer: &Buffer, size: u64) -> BindGroupEntry<'_> {
    let resource = BindingResource::Buffer(BufferBinding { buffer, offset: 0, size: std::num::NonZeroU64::new(size) });
    BindGroupEntry { binding, resource }
}

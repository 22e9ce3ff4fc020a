//! The paper's gather beside our intersection, on the same device and lattice.
//!
//! Both are held to the same answer: as many crossings a ray, and the same ones where the gather kept them all.

use std::error::Error;
use std::time::Instant;

use hexcast::control::Control;
use hexcast::gpu::{Gpu, Kernel, Options, Params};
use hexcast_core::stages::cast::{BIN, Cast};
use hexcast_core::stages::crossings::{Crossings, crossings_of_window};
use hexcast_core::stages::lattice::{Lattice, lattice};
use serde::Serialize;
use wgpu::util::{BufferInitDescriptor, DeviceExt};
use wgpu::{BindGroupEntry, Buffer, BufferUsages, ComputePipeline};

use crate::line::median;

/// Crossings that the gather keeps a ray; `SLOTS` in the shader.
const SLOTS: usize = 16;

const TEXT: &str = concat!(
    include_str!("../../shaders/shared/params.wgsl"),
    include_str!("../../shaders/shared/wide.wgsl"),
    include_str!("../../shaders/shared/facet.wgsl"),
    include_str!("../../shaders/shared/plane.wgsl"),
    include_str!("naive_gather.wgsl")
);

/// Seconds of both, and what they did.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct Comparison {
    /// Seconds of the gather.
    pub(crate) naive_s: f64,
    /// Seconds of intersection and mapping of the mesh.
    pub(crate) ours_s: f64,
    /// Rays.
    pub(crate) n_rays: u64,
    /// (facet, bin) pairs of the lattice.
    pub(crate) n_pairs: u64,
    /// Crossings.
    pub(crate) n_crossings: u64,
}

/// Times both on the rays of a cast.
pub(crate) fn compare(gpu: &Gpu, cast: &Cast, runs: u32) -> Result<Comparison, Box<dyn Error>> {
    let bin = [BIN; 2];
    let lattice = lattice(cast.frame, cast.rays, bin, 0..Lattice::n_rows(cast.rays, bin));
    let facets: Vec<u32> = (0..cast.frame.facets.len() as u32).collect();
    let [n_i, n_j] = cast.rays.counts;
    let expected = crossings_of_window(cast.frame, cast.rays, &facets, &[0..n_i, 0..n_j], false);
    let gather = Gather::new(gpu, cast, &lattice);
    let mut seconds = Vec::new();
    // in turn, so that whatever else the machine does meets both; the first run compiles
    for _ in 0..=runs {
        seconds.push((gather.run()?, ours(gpu, cast)?));
    }
    check(&gather.read(&gather.counts)?, &gather.read(&gather.events)?, &expected)?;
    Ok(Comparison {
        naive_s: median(seconds.iter().skip(1).map(|both| both.0)),
        ours_s: median(seconds.iter().skip(1).map(|both| both.1)),
        n_rays: cast.rays.n_rays(),
        n_pairs: lattice.facets.len() as u64,
        n_crossings: expected.events.len() as u64,
    })
}

/// Seconds of our intersection within a mesh in four bands; it maps the crossings to runs at the same time.
fn ours(gpu: &Gpu, cast: &Cast) -> Result<f64, Box<dyn Error>> {
    let rows = cast.rays.counts[1].div_ceil(4).next_multiple_of(8);
    let options = Options { rows_per_band: Some(rows), profile: true, ..Options::default() };
    let mut bands = Vec::new();
    let usage = pollster::block_on(gpu.continue_columns(cast, &options, &Control::default(), &mut bands))?;
    if usage.n_bands != cast.rays.counts[1].div_ceil(rows) {
        return Err("a band ran twice: its time would count twice".into());
    }
    let profile = usage.profile.unwrap_or_default();
    let others = [Kernel::Lattice, Kernel::ScanReduce, Kernel::ScanApply];
    Ok(profile.iter().filter(|(kernel, _)| !others.contains(kernel)).map(|(_, seconds)| seconds).sum())
}

/// Returns an error that names the first ray on which the gather and our kernels differ.
fn check(counts: &[u32], events: &[u32], expected: &Crossings) -> Result<(), Box<dyn Error>> {
    if counts.len() + 1 != expected.offsets.len() {
        return Err(format!("{} rays, expected {}", counts.len(), expected.offsets.len() - 1).into());
    }
    for (ray, ends) in expected.offsets.windows(2).enumerate() {
        let mut ours = expected.events[ends[0] as usize..ends[1] as usize].to_vec();
        let n = counts[ray] as usize;
        if n != ours.len() {
            return Err(format!("ray {ray}: the gather found {n} crossings, ours {}", ours.len()).into());
        }
        if n <= SLOTS {
            let mut theirs = events[SLOTS * ray..SLOTS * ray + n].to_vec();
            theirs.sort_unstable();
            ours.sort_unstable();
            if theirs != ours {
                return Err(format!("ray {ray}: the gather found {theirs:?}, ours {ours:?}").into());
            }
        }
    }
    Ok(())
}

/// The gather, compiled, with its buffers.
struct Gather<'a> {
    gpu: &'a Gpu,
    pipeline: ComputePipeline,
    buffers: Vec<Buffer>,
    counts: Buffer,
    events: Buffer,
    n_rays: u32,
}

impl<'a> Gather<'a> {
    fn new(gpu: &'a Gpu, cast: &Cast, lattice: &Lattice) -> Gather<'a> {
        let device = gpu.device();
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("naive_gather"),
            source: wgpu::ShaderSource::Wgsl(TEXT.into()),
        });
        let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some("naive_gather"),
            layout: None,
            module: &module,
            entry_point: Some("naive_gather"),
            compilation_options: Default::default(),
            cache: None,
        });
        let filled =
            |contents: &[u8], usage| device.create_buffer_init(&BufferInitDescriptor { label: None, contents, usage });
        let storage = |words: &[u32]| filled(bytemuck::cast_slice(words), BufferUsages::STORAGE);
        let empty = |n: usize| {
            let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC;
            let descriptor =
                wgpu::BufferDescriptor { label: None, size: 4 * n as u64, usage, mapped_at_creation: false };
            device.create_buffer(&descriptor)
        };
        let n_rays = cast.rays.n_rays() as usize;
        let params = filled(bytemuck::bytes_of(&params(cast, lattice)), BufferUsages::UNIFORM);
        let buffers = vec![params, storage(&corners(cast)), storage(&lattice.offsets), storage(&lattice.facets)];
        let (counts, events) = (empty(n_rays), empty(SLOTS * n_rays));
        Gather { gpu, pipeline, buffers, counts, events, n_rays: n_rays as u32 }
    }

    /// Runs once and waits; returns the seconds.
    fn run(&self) -> Result<f64, Box<dyn Error>> {
        let device = self.gpu.device();
        let buffers = self.buffers.iter().chain([&self.counts, &self.events]).zip(0..);
        let entries: Vec<BindGroupEntry> =
            buffers.map(|(buffer, binding)| BindGroupEntry { binding, resource: buffer.as_entire_binding() }).collect();
        let layout = self.pipeline.get_bind_group_layout(0);
        let group =
            device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout: &layout, entries: &entries });
        let mut encoder = device.create_command_encoder(&Default::default());
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &group, &[]);
        let n_groups = self.n_rays.div_ceil(64);
        let rows = n_groups.div_ceil(65_535);
        pass.dispatch_workgroups(n_groups.div_ceil(rows), rows, 1);
        drop(pass);
        let start = Instant::now();
        self.gpu.queue().submit([encoder.finish()]);
        device.poll(wgpu::PollType::wait_indefinitely())?;
        Ok(start.elapsed().as_secs_f64())
    }

    /// Reads a buffer back.
    fn read(&self, buffer: &Buffer) -> Result<Vec<u32>, Box<dyn Error>> {
        let device = self.gpu.device();
        let staging = device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: buffer.size(),
            usage: BufferUsages::MAP_READ | BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let mut encoder = device.create_command_encoder(&Default::default());
        encoder.copy_buffer_to_buffer(buffer, 0, &staging, 0, buffer.size());
        self.gpu.queue().submit([encoder.finish()]);
        let (sender, receiver) = std::sync::mpsc::channel();
        staging.map_async(wgpu::MapMode::Read, .., move |result| {
            // the receiver waits below
            let _ = sender.send(result);
        });
        device.poll(wgpu::PollType::wait_indefinitely())?;
        receiver.recv()??;
        Ok(bytemuck::pod_collect_to_vec(&staging.get_mapped_range(..)?))
    }
}

/// The numbers of the whole box as one band.
fn params(cast: &Cast, lattice: &Lattice) -> Params {
    Params {
        fraction_bits: cast.frame.fraction_bits,
        axis: cast.rays.axis as u32,
        depth: cast.rays.depth,
        n_i: cast.rays.counts[0],
        end_row: cast.rays.counts[1],
        n_across: lattice.n_across,
        n_bins: lattice.offsets.len() as u32 - 1,
        n_layers: 1,
        n_facets: cast.frame.facets.len() as u32,
        n_ranks: 1,
        ..bytemuck::Zeroable::zeroed()
    }
}

/// Corners of all facets as `shaders/shared/facet.wgsl` reads them.
fn corners(cast: &Cast) -> Vec<u32> {
    let facets = cast.frame.facets.iter().enumerate();
    facets
        .flat_map(|(index, facet)| {
            let rank = cast.frame.rank_of_facet(index);
            let corners = facet.map(|corner| cast.rays.project(corner).map(i32::cast_unsigned));
            let axis = |axis: usize, last: u32| [corners[0][axis], corners[1][axis], corners[2][axis], last];
            [axis(0, u32::from(rank)), axis(1, 0), axis(2, 0)].concat()
        })
        .collect()
}

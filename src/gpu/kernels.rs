//! The kernels: which shader files make each, compiled once. The only place that includes shader text.

use wgpu::{ComputePipeline, Device, ShaderModuleDescriptor, ShaderSource};

const PARAMS: &str = include_str!("../../shaders/shared/params.wgsl");
const WIDE: &str = include_str!("../../shaders/shared/wide.wgsl");
const FACET: &str = include_str!("../../shaders/shared/facet.wgsl");
const BINS: &str = include_str!("../../shaders/shared/bins.wgsl");
const RAYS: &str = include_str!("../../shaders/shared/rays.wgsl");
const SORT: &str = include_str!("../../shaders/shared/sort.wgsl");
const SCAN: &str = include_str!("../../shaders/shared/scan.wgsl");

/// A compute kernel; its entry point is named like its file in `shaders/`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[allow(missing_docs)] // each variant is documented at the head of its shader
pub enum Kernel {
    LatticeRows,
    LatticeCount,
    LatticeFill,
    IntersectSetup,
    IntersectCount,
    IntersectEmit,
    Map,
    MapOneRank,
    Compact,
    ScanReduce,
    ScanApply,
}

struct Source {
    kernel: Kernel,
    name: &'static str,
    parts: &'static [&'static str],
    /// Values of its `override`s.
    constants: &'static [(&'static str, f64)],
}

macro_rules! source {
    ($kernel:ident, $name:literal, $($part:expr),*) => {
        Source {
            kernel: Kernel::$kernel,
            name: $name,
            parts: &[$($part,)* include_str!(concat!("../../shaders/", $name, ".wgsl"))],
            constants: &[],
        }
    };
}

static SOURCES: [Source; 11] = [
    source!(LatticeRows, "lattice_rows", PARAMS, WIDE, FACET),
    source!(LatticeCount, "lattice_count", PARAMS, WIDE, FACET, BINS),
    source!(LatticeFill, "lattice_fill", PARAMS, WIDE, FACET, BINS),
    source!(IntersectSetup, "intersect_setup", PARAMS, WIDE, FACET),
    source!(IntersectCount, "intersect_count", PARAMS, RAYS),
    source!(IntersectEmit, "intersect_emit", PARAMS, WIDE, RAYS),
    source!(Map, "map", PARAMS, SORT),
    Source { kernel: Kernel::MapOneRank, constants: &[("ONE_RANK", 1.0)], ..source!(Map, "map", PARAMS, SORT) },
    source!(Compact, "compact", PARAMS),
    source!(ScanReduce, "scan_reduce", SCAN),
    source!(ScanApply, "scan_apply", SCAN),
];

/// Name and complete WGSL text of every kernel, as it is compiled; one of several pipelines of the same text.
pub fn sources() -> Vec<(&'static str, String)> {
    let distinct = SOURCES.iter().filter(|source| source.constants.is_empty());
    distinct.map(|source| (source.name, source.parts.join("\n"))).collect()
}

/// All kernels, compiled for a device.
pub(crate) struct Kernels(Vec<ComputePipeline>);

impl Kernels {
    /// Compiles all kernels; natively on all cores.
    pub(crate) fn new(device: &Device) -> Kernels {
        #[cfg(not(target_arch = "wasm32"))]
        {
            use rayon::prelude::*;
            Kernels(SOURCES.par_iter().map(|source| compile(device, source)).collect())
        }
        #[cfg(target_arch = "wasm32")]
        Kernels(SOURCES.iter().map(|source| compile(device, source)).collect())
    }

    pub(crate) fn get(&self, kernel: Kernel) -> &ComputePipeline {
        &self.0[kernel as usize]
    }
}

fn compile(device: &Device, source: &Source) -> ComputePipeline {
    debug_assert!(std::ptr::eq(&SOURCES[source.kernel as usize], source), "SOURCES is in the order of Kernel");
    let module = device.create_shader_module(ShaderModuleDescriptor {
        label: Some(source.name),
        source: ShaderSource::Wgsl(source.parts.join("\n").into()),
    });
    device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some(source.name),
        layout: None,
        module: &module,
        entry_point: Some(source.name),
        compilation_options: wgpu::PipelineCompilationOptions { constants: source.constants, ..Default::default() },
        cache: None,
    })
}

//! The kernels: which shader files make each, compiled once. The only place that includes shader text.

use std::sync::OnceLock;

use wgpu::{ComputePipeline, Device, ShaderModuleDescriptor, ShaderSource};

use crate::parallel::*;

const PARAMS: &str = include_str!("../../shaders/shared/params.wgsl");
const WIDE: &str = include_str!("../../shaders/shared/wide.wgsl");
const FACET: &str = include_str!("../../shaders/shared/facet.wgsl");
const BINS: &str = include_str!("../../shaders/shared/bins.wgsl");
const RAYS: &str = include_str!("../../shaders/shared/rays.wgsl");
const BIN_FACET: &str = include_str!("../../shaders/shared/bin_facet.wgsl");
const PLANE: &str = include_str!("../../shaders/shared/plane.wgsl");
const SWEEP: &str = include_str!("../../shaders/shared/sweep.wgsl");
const CHUNKS: &str = include_str!("../../shaders/shared/chunks.wgsl");
const EMIT_ROW: &str = include_str!("../../shaders/shared/emit_row.wgsl");
const MAP_RAY: &str = include_str!("../../shaders/shared/map_ray.wgsl");
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
    ColumnsSetup,
    Columns,
    ColumnsOneRank,
    ColumnsDeep,
    ColumnsDeepOneRank,
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

static SOURCES: [Source; 16] = [
    source!(LatticeRows, "lattice_rows", PARAMS, WIDE, FACET),
    source!(LatticeCount, "lattice_count", PARAMS, WIDE, FACET, BINS),
    source!(LatticeFill, "lattice_fill", PARAMS, WIDE, FACET, BINS),
    source!(IntersectSetup, "intersect_setup", PARAMS, WIDE, FACET, BIN_FACET),
    source!(ColumnsSetup, "columns_setup", PARAMS, WIDE, FACET, BIN_FACET),
    source!(Columns, "columns", PARAMS, RAYS, SWEEP, CHUNKS),
    one_rank(source!(ColumnsOneRank, "columns", PARAMS, RAYS, SWEEP, CHUNKS)),
    source!(ColumnsDeep, "columns_deep", PARAMS, WIDE, RAYS, PLANE, EMIT_ROW, SORT, SWEEP, MAP_RAY, CHUNKS),
    one_rank(source!(
        ColumnsDeepOneRank,
        "columns_deep",
        PARAMS,
        WIDE,
        RAYS,
        PLANE,
        EMIT_ROW,
        SORT,
        SWEEP,
        MAP_RAY,
        CHUNKS
    )),
    source!(IntersectCount, "intersect_count", PARAMS, RAYS),
    source!(IntersectEmit, "intersect_emit", PARAMS, WIDE, RAYS, PLANE, EMIT_ROW),
    source!(Map, "map", PARAMS, SORT, SWEEP, MAP_RAY),
    one_rank(source!(MapOneRank, "map", PARAMS, SORT, SWEEP, MAP_RAY)),
    source!(Compact, "compact", PARAMS),
    source!(ScanReduce, "scan_reduce", SCAN),
    source!(ScanApply, "scan_apply", SCAN),
];

/// The kernel for a single geometry.
const fn one_rank(source: Source) -> Source {
    Source { constants: &[("ONE_RANK", 1.0)], ..source }
}

/// Name and complete WGSL text of every kernel, as it is compiled; one of several pipelines of the same text.
pub fn sources() -> Vec<(&'static str, String)> {
    let distinct = SOURCES.iter().filter(|source| source.constants.is_empty());
    distinct.map(|source| (source.name, source.parts.join("\n"))).collect()
}

/// Kernels that every mesh of one geometry needs.
const COMMON: [Kernel; 7] = [
    Kernel::LatticeRows,
    Kernel::LatticeCount,
    Kernel::LatticeFill,
    Kernel::ColumnsSetup,
    Kernel::ColumnsOneRank,
    Kernel::ScanReduce,
    Kernel::ScanApply,
];

/// All kernels, compiled for a device: the common ones when it is opened, the others when they are first used.
pub(crate) struct Kernels {
    device: Device,
    compiled: Vec<OnceLock<ComputePipeline>>,
}

impl Kernels {
    /// Compiles the common kernels; natively on all cores.
    pub(crate) fn new(device: &Device) -> Kernels {
        let compiled = SOURCES.iter().map(|_| OnceLock::new()).collect();
        let kernels = Kernels { device: device.clone(), compiled };
        COMMON.into_par_iter().for_each(|kernel| {
            kernels.get(kernel);
        });
        kernels
    }

    pub(crate) fn get(&self, kernel: Kernel) -> &ComputePipeline {
        self.compiled[kernel as usize].get_or_init(|| compile(&self.device, kernel))
    }
}

fn compile(device: &Device, kernel: Kernel) -> ComputePipeline {
    let source = &SOURCES[kernel as usize];
    debug_assert_eq!(source.kernel, kernel, "SOURCES is in the order of Kernel");
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

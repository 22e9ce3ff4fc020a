//! The kernels: which shader files make each, compiled once. The only place that includes shader text.
//!
//! Comments and indentation, half of the text, stay at home; line breaks do not, so that lines keep their numbers.

use std::sync::OnceLock;

use wgpu::{ComputePipeline, Device, ShaderModuleDescriptor, ShaderSource};

use crate::parallel::*;

/// The text of a file in `shaders/`, stripped.
macro_rules! wgsl {
    ($name:expr) => {{
        const TEXT: &[u8] = include_bytes!(concat!("../../shaders/", $name, ".wgsl"));
        const STRIPPED: [u8; strip(TEXT, &mut [])] = {
            let mut stripped = [0; strip(TEXT, &mut [])];
            strip(TEXT, &mut stripped);
            stripped
        };
        match str::from_utf8(&STRIPPED) {
            Ok(text) => text,
            Err(_) => panic!("a shader is not UTF-8"),
        }
    }};
}

/// Copies WGSL without `//` comments and the white space around lines to the front of `out`, as far as it goes; returns
/// the length of all. There are no strings in WGSL, and we write no `/*`.
const fn strip(text: &[u8], out: &mut [u8]) -> usize {
    let (mut at, mut len) = (0, 0);
    // white space is copied once something follows on its line
    let (mut blank_from, mut is_line_start) = (0, true);
    while at < text.len() {
        let byte = text[at];
        if byte == b'/' && at + 1 < text.len() && text[at + 1] == b'/' {
            while at < text.len() && text[at] != b'\n' {
                at += 1;
            }
            continue;
        }
        if byte != b' ' {
            let mut from = if is_line_start || byte == b'\n' { at } else { blank_from };
            while from <= at {
                if len < out.len() {
                    out[len] = text[from];
                }
                len += 1;
                from += 1;
            }
            is_line_start = byte == b'\n';
            blank_from = at + 1;
        }
        at += 1;
    }
    len
}

const PARAMS: &str = wgsl!("shared/params");
const WIDE: &str = wgsl!("shared/wide");
const FACET: &str = wgsl!("shared/facet");
const BINS: &str = wgsl!("shared/bins");
const RAYS: &str = wgsl!("shared/rays");
const BIN_FACET: &str = wgsl!("shared/bin_facet");
const PLANE: &str = wgsl!("shared/plane");
const SWEEP: &str = wgsl!("shared/sweep");
const CHUNKS: &str = wgsl!("shared/chunks");
const EMIT_ROW: &str = wgsl!("shared/emit_row");
const MAP_RAY: &str = wgsl!("shared/map_ray");
const SORT: &str = wgsl!("shared/sort");
const SCAN: &str = wgsl!("shared/scan");

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
    ColumnsAlternating,
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
            parts: const { &[$($part,)* wgsl!($name)] },
            constants: &[],
        }
    };
}

static SOURCES: [Source; 17] = [
    source!(LatticeRows, "lattice_rows", PARAMS, WIDE, FACET),
    source!(LatticeCount, "lattice_count", PARAMS, WIDE, FACET, BINS),
    source!(LatticeFill, "lattice_fill", PARAMS, WIDE, FACET, BINS),
    source!(IntersectSetup, "intersect_setup", PARAMS, WIDE, FACET, BIN_FACET),
    source!(ColumnsSetup, "columns_setup", PARAMS, WIDE, FACET, BIN_FACET),
    source!(Columns, "columns", PARAMS, RAYS, SWEEP, CHUNKS),
    one_rank(source!(ColumnsOneRank, "columns", PARAMS, RAYS, SWEEP, CHUNKS)),
    alternating(source!(ColumnsAlternating, "columns", PARAMS, RAYS, SWEEP, CHUNKS)),
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

/// The kernel for a single geometry under the rule parity.
const fn alternating(source: Source) -> Source {
    Source { constants: &[("ONE_RANK", 1.0), ("ALTERNATES", 1.0)], ..source }
}

/// Name and complete WGSL text of every kernel, as it is compiled; one of several pipelines of the same text.
pub fn sources() -> Vec<(&'static str, String)> {
    let distinct = SOURCES.iter().filter(|source| source.constants.is_empty());
    distinct.map(|source| (source.name, source.parts.join("\n"))).collect()
}

/// Kernels that every mesh of one geometry under the rule parity needs.
const COMMON: [Kernel; 7] = [
    Kernel::LatticeRows,
    Kernel::LatticeCount,
    Kernel::LatticeFill,
    Kernel::ColumnsSetup,
    Kernel::ColumnsAlternating,
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stripped_text_keeps_its_tokens_and_lines() {
        let text = b"// head\n\nfn f() {  // why\n    let a = 1u / 2u;\n}\n// end";
        let expected = b"\n\nfn f() {\nlet a = 1u / 2u;\n}\n";
        let mut out = [b'#'; 64];
        let len = strip(text, &mut out);
        assert_eq!(str::from_utf8(&out[..len]), str::from_utf8(expected));
        assert!(out[len..].iter().all(|&byte| byte == b'#'));
        assert_eq!(strip(text, &mut []), len);
        for (name, text) in sources() {
            assert!(!text.contains("//") && !text.contains("\n ") && text.contains(&format!("fn {name}(")), "{name}");
        }
    }
}

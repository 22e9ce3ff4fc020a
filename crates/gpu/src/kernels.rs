//! The kernels: which shader files make each, what each binds, compiled once. The only place that includes shader text.
//!
//! Comments and indentation, half of the text, are left out; line breaks stay, so that lines keep their numbers. A test holds names, slots,
//! strides and workgroup sizes of the table to what naga reads from the text.

use std::sync::{Arc, OnceLock};

use wgpu::{ComputePipeline, Device, ShaderModuleDescriptor, ShaderSource};

use hexcast_core::base::parallel::bound::*;

/// The text of a file in `shaders/`, stripped.
macro_rules! wgsl {
    ($name:expr) => {{
        const TEXT: &[u8] = include_bytes!(concat!("../shaders/", $name, ".wgsl"));
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
const ITEMS: &str = wgsl!("shared/items");
const WALK: &str = wgsl!("shared/walk");
const GRADED: &str = wgsl!("shared/graded");
const PLANE: &str = wgsl!("shared/plane");
const EVENTS: &str = wgsl!("shared/events");
const CHUNKS: &str = wgsl!("shared/chunks");
const SWEEP: &str = wgsl!("shared/sweep");
const SCAN: &str = wgsl!("shared/scan");

/// A compute kernel; its entry point is named like its file in `shaders/`, whose head says what it does.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[allow(missing_docs)]
pub enum Kernel {
    Lattice,
    Intersect,
    Map,
    /// `Map` where bins have one layer.
    MapOneLayer,
    /// `MapOneLayer` for one geometry under the rule `parity`.
    MapSimple,
    IntersectDeep,
    /// `IntersectDeep` where cells differ in size.
    IntersectGraded,
    MapDeep,
    ScanReduce,
    ScanApply,
    Probe,
    /// On devices of callers too.
    Expand,
    /// For runs that stay on the device.
    Order,
}

/// A buffer that a kernel binds: its slot, its name in the shader, and the words of an element, 0 where it is a struct.
pub type Slot = (u32, &'static str, u32);

struct Source {
    kernel: Kernel,
    name: &'static str,
    parts: &'static [&'static str],
    /// Threads of a workgroup.
    group: u32,
    slots: &'static [Slot],
    /// Values of `override` constants where they are not those of the text.
    constants: &'static [(&'static str, f64)],
}

macro_rules! source {
    ($kernel:ident, $name:literal, [$($part:expr),*], $group:literal, $slots:expr) => {
        Source {
            kernel: Kernel::$kernel,
            name: $name,
            parts: const { &[$($part,)* wgsl!($name)] },
            group: $group,
            slots: $slots,
            constants: &[],
        }
    };
}

const PARAMS_SLOT: Slot = (0, "params", 0);
const CORNERS: Slot = (1, "corners", 4);
const ITEM_OFFSETS: Slot = (2, "item_offsets", 1);
const BIN_OFFSETS: Slot = (2, "bin_offsets", 1);
const NEXT_EVENT: Slot = (3, "next_event", 1);
const EVENTS_SLOT: Slot = (4, "events", 1);
const CHUNKS_SLOT: Slot = (6, "chunks", 2);

#[rustfmt::skip]
const MAP: Source = source!(Map, "map", [PARAMS, CHUNKS, SWEEP], 64,
    &[PARAMS_SLOT, BIN_OFFSETS, (3, "tiles", 4), (5, "runs", 4), CHUNKS_SLOT, (7, "totals", 0), (8, "layer_ends", 4)]);

#[rustfmt::skip]
static SOURCES: [Source; 13] = [
    source!(Lattice, "lattice", [PARAMS, WIDE, FACET, ITEMS, WALK], 64,
        &[PARAMS_SLOT, CORNERS, ITEM_OFFSETS, (3, "bin_counts", 1), (4, "found", 4), (5, "found_totals", 0)]),
    source!(Intersect, "intersect", [PARAMS, WIDE, FACET, PLANE], 64,
        &[PARAMS_SLOT, CORNERS, BIN_OFFSETS, (3, "found", 4), (4, "tiles", 4), (5, "found_totals", 1)]),
    MAP,
    Source { kernel: Kernel::MapOneLayer, constants: &[("HAS_LAYERS", 0.0)], ..MAP },
    Source { kernel: Kernel::MapSimple, constants: &[("HAS_LAYERS", 0.0), ("ALTERNATES", 1.0)], ..MAP },
    source!(IntersectDeep, "intersect_deep", [PARAMS, WIDE, FACET, ITEMS, WALK, PLANE, CHUNKS, EVENTS], 64,
        &[PARAMS_SLOT, CORNERS, ITEM_OFFSETS, NEXT_EVENT, EVENTS_SLOT, CHUNKS_SLOT]),
    source!(IntersectGraded, "intersect_graded", [PARAMS, WIDE, FACET, ITEMS, GRADED, PLANE, EVENTS], 64,
        &[PARAMS_SLOT, CORNERS, ITEM_OFFSETS, NEXT_EVENT, EVENTS_SLOT, (5, "centres", 1)]),
    source!(MapDeep, "map_deep", [PARAMS], 64,
        &[PARAMS_SLOT, (2, "event_offsets", 1), EVENTS_SLOT, (5, "deep_rows", 1)]),
    source!(ScanReduce, "scan_reduce", [SCAN], 256, &[(0, "numbers", 1), (1, "sums", 1)]),
    source!(ScanApply, "scan_apply", [SCAN], 256, &[(0, "numbers", 1), (1, "bases", 1)]),
    source!(Probe, "probe", [], 64,
        &[(0, "answers", 0), (1, "buffer_1", 1), (2, "buffer_2", 1), (3, "buffer_3", 1), (4, "buffer_4", 1),
          (5, "buffer_5", 1), (6, "buffer_6", 1), (7, "buffer_7", 1)]),
    source!(Expand, "expand", [], 64, &[(0, "slab", 0), (1, "offsets", 1), (2, "runs", 1), (3, "flags", 1)]),
    source!(Order, "order", [PARAMS, CHUNKS], 64,
        &[PARAMS_SLOT, (1, "sources", 0), (2, "deep_rows", 1), (3, "offsets", 1), EVENTS_SLOT, (5, "runs", 4),
          CHUNKS_SLOT, (7, "ordered", 1), (8, "found", 0)]),
];

/// A kernel as it is compiled.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct KernelText {
    /// Name of its file and entry point.
    pub name: &'static str,
    /// Its complete WGSL.
    pub text: String,
    /// Threads of a workgroup.
    pub group: u32,
    /// What it binds, in the order in which the passes give it.
    pub slots: &'static [Slot],
}

/// All kernels, each once.
pub fn kernel_texts() -> Vec<KernelText> {
    let text_of = |source: &Source| KernelText {
        name: source.name,
        text: source.parts.join("\n"),
        group: source.group,
        slots: source.slots,
    };
    SOURCES.iter().filter(|source| source.constants.is_empty()).map(text_of).collect()
}

/// The kernel that expands flags, which needs nothing else of this library.
pub fn expand_text() -> &'static str {
    Kernel::Expand.source().parts[0]
}

/// Changes the text of a kernel, given its name, before it is compiled: for tests of what a broken driver would do.
pub type Edit = Arc<dyn Fn(&str, String) -> String + Send + Sync>;

/// Kernels that nearly every mesh needs.
const COMMON: [Kernel; 5] =
    [Kernel::Lattice, Kernel::Intersect, Kernel::MapSimple, Kernel::ScanReduce, Kernel::ScanApply];

/// All kernels, compiled for a device: the common ones when it is opened, the others when they are first used.
pub(crate) struct Kernels {
    device: Device,
    edit: Option<Edit>,
    compiled: Vec<OnceLock<ComputePipeline>>,
}

impl Kernels {
    /// Takes kernels for a device, which meshes on it share; none is compiled yet.
    // in wasm there is one thread, and nothing of wgpu goes to another
    #[cfg_attr(target_arch = "wasm32", allow(clippy::arc_with_non_send_sync))]
    pub(crate) fn shared(device: &Device, edit: Option<Edit>) -> Arc<Kernels> {
        let compiled = SOURCES.iter().map(|_| OnceLock::new()).collect();
        Arc::new(Kernels { device: device.clone(), edit, compiled })
    }

    /// Compiles the common kernels; natively on all cores, but for a device of the caller's, whose errors are told to the thread they are of.
    pub(crate) fn compile_common(&self, is_callers: bool) {
        if is_callers {
            COMMON.into_iter().for_each(|kernel| {
                self.get(kernel);
            });
            return;
        }
        COMMON.into_par_iter().for_each(|kernel| {
            self.get(kernel);
        });
    }

    pub(crate) fn get(&self, kernel: Kernel) -> &ComputePipeline {
        self.compiled[kernel as usize].get_or_init(|| self.compile(kernel))
    }

    fn compile(&self, kernel: Kernel) -> ComputePipeline {
        let source = kernel.source();
        let text = source.parts.join("\n");
        let text = self.edit.as_ref().map_or(text.clone(), |edit| edit(source.name, text));
        let module = self.device.create_shader_module(ShaderModuleDescriptor {
            label: Some(source.name),
            source: ShaderSource::Wgsl(text.into()),
        });
        self.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(source.name),
            layout: None,
            module: &module,
            entry_point: Some(source.name),
            compilation_options: wgpu::PipelineCompilationOptions { constants: source.constants, ..Default::default() },
            cache: None,
        })
    }
}

impl Kernel {
    fn source(self) -> &'static Source {
        let source = &SOURCES[self as usize];
        debug_assert_eq!(source.kernel, self, "SOURCES is in the order of Kernel");
        source
    }

    /// What it binds.
    pub(crate) fn slots(self) -> &'static [Slot] {
        self.source().slots
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    mod picture;

    #[test]
    fn stripped_text_keeps_its_tokens_and_lines() {
        let text = b"// head\n\nfn f() {  // why\n    let a = 1u / 2u;\n}\n// end";
        let expected = b"\n\nfn f() {\nlet a = 1u / 2u;\n}\n";
        let mut out = [b'#'; 64];
        let len = strip(text, &mut out);
        assert_eq!(str::from_utf8(&out[..len]), str::from_utf8(expected));
        assert!(out[len..].iter().all(|&byte| byte == b'#'));
        assert_eq!(strip(text, &mut []), len);
        for KernelText { name, text, .. } in kernel_texts() {
            assert!(!text.contains("//") && !text.contains("\n ") && text.contains(&format!("fn {name}(")), "{name}");
        }
    }
}

//! The shader texts as naga reads them: valid, and laid out, bound and counted as the Rust code says. This is what stands in place of
//! "keep in sync".

use std::collections::BTreeMap;

use hexcast::gpu::{
    DEEP, DEEP_ITEMS_OF_THREAD, GRADED_ITEMS_OF_THREAD, ITEMS_OF_THREAD, KernelText, LEFT, LINKED, MOST_LOOPS, Params,
    SCAN_BLOCK, TILES_OF_THREAD, kernel_texts,
};
use naga::valid::{Capabilities, ValidationFlags, Validator};
use naga::{Expression, Literal, Module, TypeInner};

fn parse(name: &str, text: &str) -> Module {
    naga::front::wgsl::parse_str(text).unwrap_or_else(|error| panic!("{name}: {}", error.emit_to_string(text)))
}

fn modules() -> Vec<(KernelText, Module)> {
    kernel_texts().into_iter().map(|kernel| (kernel.clone(), parse(kernel.name, &kernel.text))).collect()
}

/// The values of all u32 constants of all kernels; a name that has two values fails.
fn constants() -> BTreeMap<String, u32> {
    let mut found = BTreeMap::new();
    for (kernel, module) in modules() {
        for (_, constant) in module.constants.iter() {
            let Expression::Literal(Literal::U32(value)) = module.global_expressions[constant.init] else { continue };
            let Some(name) = constant.name.clone() else { continue };
            let before = found.insert(name.clone(), value);
            assert!(before.is_none_or(|before| before == value), "{}: {name} is {value} and {before:?}", kernel.name);
        }
    }
    found
}

#[test]
fn every_kernel_is_valid_and_its_entry_point_is_named_like_its_file() {
    for (kernel, module) in modules() {
        let mut validator = Validator::new(ValidationFlags::all(), Capabilities::empty());
        let valid = validator.validate(&module);
        valid.unwrap_or_else(|error| panic!("{}: {}", kernel.name, error.emit_to_string(&kernel.text)));
        let [entry] = &module.entry_points[..] else { panic!("{}: one entry point", kernel.name) };
        assert_eq!((entry.name.as_str(), entry.workgroup_size), (kernel.name, [kernel.group, 1, 1]));
    }
}

#[test]
fn every_shader_file_is_part_of_a_kernel() {
    let kernels = kernel_texts();
    for folder in ["shaders", "shaders/shared"] {
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_file() {
                let text = std::fs::read_to_string(&path).unwrap();
                // as the kernels have it: without comments and indentation, line for line
                let lines = text.lines().map(|line| line.split("//").next().unwrap_or_default().trim());
                let text = lines.collect::<Vec<_>>().join("\n");
                assert!(kernels.iter().any(|kernel| kernel.text.contains(&text)), "{} is in no kernel", path.display());
            }
        }
    }
}

#[test]
fn kernels_bind_what_the_table_says() {
    for (kernel, module) in modules() {
        let mut found = Vec::new();
        for (_, variable) in module.global_variables.iter() {
            let Some(binding) = &variable.binding else { continue };
            let name = variable.name.clone().expect("bindings have names");
            let stride = match module.types[variable.ty].inner {
                TypeInner::Array { stride, .. } => stride / 4,
                _ => 0,
            };
            found.push((binding.binding, name, stride));
        }
        found.sort();
        let expected: Vec<_> =
            kernel.slots.iter().map(|&(slot, name, words)| (slot, name.to_string(), words)).collect();
        assert_eq!(found, expected, "{}", kernel.name);
        let n_storage = found.iter().filter(|(_, name, _)| name != "params" && name != "layer_ends").count();
        assert!(n_storage <= 8, "{} binds {n_storage} storage buffers", kernel.name);
    }
}

#[test]
fn params_are_laid_out_like_their_twin() {
    // a field of the Rust struct, by name, and its first byte
    macro_rules! offsets {
        ($($field:ident)*) => { [$((stringify!($field), std::mem::offset_of!(Params, $field))),*] };
    }
    let twin = offsets!(
        fraction_bits axis depth n_i first_row end_row n_across n_bins n_layers n_facets n_items tile_capacity
        place_capacity event_capacity rule n_ranks all_deep with_facets first_facet
    );
    assert_eq!(4 * twin.len(), size_of::<Params>(), "all fields are listed");
    let mut n_checked = 0;
    for (kernel, module) in modules() {
        for (_, kind) in module.types.iter().filter(|(_, kind)| kind.name.as_deref() == Some("Params")) {
            let TypeInner::Struct { members, .. } = &kind.inner else { panic!("{}: Params is no struct", kernel.name) };
            let found: Vec<_> = members.iter().map(|m| (m.name.as_deref().unwrap(), m.offset as usize)).collect();
            assert_eq!(found, twin, "{}", kernel.name);
            n_checked += 1;
        }
    }
    let n_with_params = kernel_texts().iter().filter(|kernel| kernel.slots[0].1 == "params").count();
    assert_eq!(n_checked, n_with_params);
}

#[test]
fn constants_are_those_of_the_host() {
    let shaders = constants();
    let host = [
        ("BIN", hexcast_core::stages::cast::BIN),
        ("SEGMENT", hexcast_core::stages::cast::SEGMENT),
        ("MAX_TILES", hexcast_core::stages::cast::MAX_TILES),
        ("RANK_BITS", hexcast_core::stages::cast::MAX_TILES.ilog2()),
        ("BLOCK", SCAN_BLOCK as u32),
        ("DEEP", DEEP),
        ("LEFT", LEFT),
        ("LINKED", LINKED),
        ("LOOPS", MOST_LOOPS),
    ];
    for (name, value) in host {
        assert_eq!(shaders.get(name), Some(&value), "{name}");
    }
}

/// The most loops of an invocation of each kernel, counted from the constants of the shaders and of the passes: no more than the probe
/// has seen the driver do.
#[test]
fn no_invocation_runs_more_loops_than_the_probe_asks_for() {
    let c = constants();
    let (bin, segment) = (u64::from(c["BIN"]), u64::from(c["SEGMENT"]));
    // finding the facet; the item; each bin of it, and the rows of the bin
    let item = 32 + 1 + segment * (1 + bin);
    // and in a bin of a deep row its rows again, and a crossing for each ray
    let deep_item = item + segment * (bin + bin * bin);
    // its rays once, and again in each row; then the rows, and a search for each ray
    let search = u64::from(c["SEARCH_LOOPS"]);
    let graded_item = 32 + 1 + 4 * search + segment * (1 + bin + bin * (1 + bin) + bin + bin * bin * (1 + search));
    let threads = u64::from(c["THREADS"]);
    let layers = 128;
    // passes for 3 bits of a ray and 18 of a cell, and one to make them even
    let sort = 6 * (2 * u64::from(c["MAX_EVENTS"]).div_ceil(threads) + 3 * u64::from(c["DIGITS"]) + 6);
    let loops = [
        ("lattice", 32 + ITEMS_OF_THREAD * item),
        ("intersect", TILES_OF_THREAD),
        // two tiles at a time; a sweep of eight rays, with four loops for what stays, and its segment of eight
        ("map", u64::from(c["MAX_TILES"]) / 2 + layers * (1 + 1 + 8 * (1 + 4) + 8)),
        ("intersect_deep", 32 + DEEP_ITEMS_OF_THREAD * deep_item),
        ("intersect_graded", 32 + GRADED_ITEMS_OF_THREAD * graded_item),
        // the counters, two searches, the sweep
        ("map_deep", sort + 2048 / threads + 2 * 16 + u64::from(c["MAX_OF_RAY"])),
        ("scan_reduce", 16 + 8),
        ("scan_apply", 2 * 16 + 8),
        ("probe", u64::from(c["LOOPS"]) - 32 + 2048 / 64),
        // four bytes of eight cells
        ("expand", 4 * (1 + 8 * (1 + u64::from(c["SEARCH_STEPS"])))),
        // segments of a ray, or a deep one
        ("order", (u64::from(c["MAX_SEGMENTS"]) * (1 + 8 + 8)).max(c["MAX_DEEP_RUNS"].into())),
    ];
    for (name, loops) in loops {
        assert!(loops <= u64::from(MOST_LOOPS), "{name} may run {loops} loops");
    }
    let names: Vec<&str> = loops.iter().map(|(name, _)| *name).collect();
    assert_eq!(names, kernel_texts().iter().map(|kernel| kernel.name).collect::<Vec<_>>());
}

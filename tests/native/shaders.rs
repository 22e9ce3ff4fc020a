//! The shader texts as naga reads them: valid, and laid out like their Rust twins.

use hexcast::gpu::{Params, sources};
use naga::valid::{Capabilities, ValidationFlags, Validator};
use naga::{Module, TypeInner};

fn parse(name: &str, text: &str) -> Module {
    naga::front::wgsl::parse_str(text).unwrap_or_else(|error| panic!("{name}: {}", error.emit_to_string(text)))
}

#[test]
fn every_kernel_is_valid_and_its_entry_point_is_named_like_its_file() {
    for (name, text) in sources() {
        let module = parse(name, &text);
        let mut validator = Validator::new(ValidationFlags::all(), Capabilities::empty());
        validator.validate(&module).unwrap_or_else(|error| panic!("{name}: {}", error.emit_to_string(&text)));
        let entry_points: Vec<&str> = module.entry_points.iter().map(|entry| entry.name.as_str()).collect();
        assert_eq!(entry_points, [name]);
    }
}

#[test]
fn every_shader_file_is_part_of_a_kernel() {
    let texts: Vec<String> = sources().into_iter().map(|(_, text)| text).collect();
    for folder in ["shaders", "shaders/shared"] {
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_file() {
                let text = std::fs::read_to_string(&path).unwrap();
                // as the kernels have it: without comments and indentation, line for line
                let lines = text.lines().map(|line| line.split("//").next().unwrap_or_default().trim());
                let text = lines.collect::<Vec<_>>().join("\n");
                assert!(texts.iter().any(|kernel| kernel.contains(&text)), "{} is in no kernel", path.display());
            }
        }
    }
}

#[test]
fn params_are_laid_out_like_their_twin() {
    // the names in the order of the Rust struct, which is repr(C) and all u32
    let twin = Params {
        fraction_bits: 0,
        axis: 1,
        depth: 2,
        n_i: 3,
        n_j: 4,
        first_row: 5,
        end_row: 6,
        n_across: 7,
        n_bins: 8,
        n_facets: 9,
        pair_capacity: 10,
        event_capacity: 11,
        rule: 12,
        n_ranks: 13,
        unused: [14, 15],
    };
    let debug = format!("{twin:?}");
    let mut checked = 0;
    for (name, text) in sources() {
        let module = parse(name, &text);
        for (_, kind) in module.types.iter().filter(|(_, kind)| kind.name.as_deref() == Some("Params")) {
            let TypeInner::Struct { members, span } = &kind.inner else { panic!("{name}: Params is no struct") };
            assert_eq!(*span as usize, size_of::<Params>(), "{name}");
            for member in members {
                let field = member.name.as_deref().unwrap();
                let place = member.offset / 4;
                if !field.starts_with("unused") {
                    assert!(
                        debug.contains(&format!("{field}: {place},")),
                        "{name}: {field} at word {place}, not in {debug}"
                    );
                }
            }
            checked += 1;
        }
    }
    assert_eq!(checked, 11, "kernels that take the parameters of a band");
}

//! What people type: numbers with signs, exponents and units, lists with spaces, standard input and output, odd names.

use std::io::Write;
use std::process::{Command, Stdio};

use serde_json::Value;

use super::cli::{Folder, SPOT, done, hexcast, json};

const CPU: [&str; 4] = ["--cells", "16", "--backend", "cpu"];

/// Exit code and standard error.
fn failed(arguments: &[&str]) -> (Option<i32>, String) {
    let output = hexcast(arguments);
    (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
}

/// Runs hexcast with bytes as standard input; returns standard output.
fn piped(arguments: &[&str], input: &[u8]) -> Vec<u8> {
    let mut command = Command::new(env!("CARGO_BIN_EXE_hexcast"));
    command.current_dir(env!("CARGO_MANIFEST_DIR")).args(arguments);
    let streams = command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = streams.spawn().expect("hexcast starts");
    child.stdin.take().expect("a pipe").write_all(input).expect("hexcast reads all of it");
    let output = child.wait_with_output().expect("hexcast ends");
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    output.stdout
}

#[test]
fn wrong_numbers_are_named_with_what_is_allowed() {
    let table = [
        (&["--cells", "-5"][..], "\"-5\" is not a whole number from 0 to 4294967295"),
        (&["--cells", "5000000000"], "\"5000000000\" is too large: a whole number from 0 to 4294967295 is needed"),
        (&["--cells", "0"], "cells is 0; allowed: at least 1"),
        (&["--cells", "2.5"], "\"2.5\" is not a whole number"),
        (&["--cell-size", "0.1mm"], "Write 0.1, and --unit mm if the files are in mm"),
        (&["--cell-size", "-1"], "cell_size is -1; allowed: a positive number"),
        (&["--domain", "-1", "-1", "-1", "1", "1"], "6 numbers separated by commas are needed, and 5 were given"),
        (&["--domain", "-1"], "and 1 was given"),
        (&["--domain", "-1 -1 -1 1 1"], "and 5 were given"),
        (&["--window", "-1,0,0,5,5,5"], "\"-1\" is not a whole number"),
        (&["--dims", "-1,2,3"], "\"-1\" is not a whole number"),
        (&["--gap-flag", "0"], "at least 1 is needed"),
        (&["--fluid", "300"], "\"300\" is too large: a whole number from 0 to 255 is needed"),
        (&["--max-memory", "0"], "\"0\" is no memory: at least 1 byte is needed"),
        (&["--unit", " "], "unit is empty"),
    ];
    for (arguments, expected) in table {
        let (code, said) = failed(&[&["mesh", SPOT][..], arguments].concat());
        assert!(matches!(code, Some(2 | 4)) && said.contains(expected), "{arguments:?}: {code:?} {said}");
        assert!(!said.contains("tip:"), "{said}");
    }
}

#[test]
fn numbers_may_have_exponents_and_lists_may_have_spaces() {
    let cells =
        |arguments: &[&str]| json(&[&["mesh", SPOT, "--backend", "cpu", "--json"], arguments].concat())["dims"].clone();
    assert_eq!(cells(&["--cells", "2e1"]), cells(&["--cells", "20"]));
    let with_commas = cells(&["--domain=-1,-1,-1,1,1,1", "--dims", "3,4,5"]);
    assert_eq!(with_commas, serde_json::json!([3, 4, 5]));
    assert_eq!(cells(&["--domain", "-1", "-1", "-1", "1", "1", "1", "--dims", "3", "4", "5"]), with_commas);
    assert_eq!(cells(&["--domain", "-1 -1 -1 1 1 1", "--dims", "3, 4, 5"]), with_commas);
}

#[test]
fn a_level_of_compression_may_stand_alone() {
    let folder = Folder::new();
    let [joined, alone] = ["joined.vti", "alone.vti"].map(|name| folder.path(name));
    done(&[&["mesh", SPOT, "--compress=9", "-o", &joined][..], &CPU].concat());
    done(&[&["mesh", SPOT, "--compress", "9", "-o", &alone][..], &CPU].concat());
    assert!(folder.bytes("joined.vti") == folder.bytes("alone.vti"));
    let (code, said) = failed(&["mesh", "--compress", SPOT, "-o", &alone]);
    assert!(code == Some(2) && said.contains("1 to 9 or none is needed"), "{said}");
}

#[test]
fn standard_input_and_output_take_the_place_of_files() {
    let folder = Folder::new();
    let [npy, hxc, raw] = ["a.npy", "a.hxc", "a.raw"].map(|name| folder.path(name));
    done(&[&["mesh", SPOT, "-o", &npy, "-o", &hxc, "-o", &raw][..], &CPU].concat());
    let stl = std::fs::read(SPOT).expect("the fixture");
    let flags = piped(&[&["mesh", "-", "-o", "-", "--format", "npy"][..], &CPU].concat(), &stl);
    assert!(flags == folder.bytes("a.npy"));
    // no sidecar, nor any other file, is left
    assert!(piped(&["convert", "-", "-", "--format", "raw"], &folder.bytes("a.hxc")) == folder.bytes("a.raw"));
    assert_eq!(folder.names(), ["a.hxc", "a.npy", "a.raw", "a.raw.json"]);

    let job = format!("cells = 16\nbackend = \"cpu\"\n[[geometries]]\nfile = \"{SPOT}\"\n");
    assert!(piped(&["mesh", "--job", "-", "-o", "-", "--format", "npy"], job.as_bytes()) == flags);
    let job = format!("{{\"cells\": 16, \"backend\": \"cpu\", \"geometries\": [{{\"file\": \"{SPOT}\"}}]}}");
    let report = piped(&["mesh", "--job", "-", "--report", "-"], job.as_bytes());
    let report: Value = serde_json::from_slice(&report).expect("only the report is printed");
    assert_eq!(report["dims"][1], 16);

    let info: Value = serde_json::from_slice(&piped(&["info", "-", "--json"], &stl)).expect("JSON");
    assert_eq!(info[0]["facets"], 5856);
    let columns = folder.bytes("a.hxc");
    let info: Value = serde_json::from_slice(&piped(&["info", "-", "--json"], &columns)).expect("JSON");
    assert_eq!((&info[0]["cells"], &info[0]["bytes"]), (&report["cells"], &Value::Null));
    let picture = folder.path("a.png");
    for command in ["slice", "view"] {
        done(&[command, &hxc, "-q", "-o", &picture]);
        assert!(piped(&[command, "-", "-o", "-"], &columns) == folder.bytes("a.png"), "{command}");
    }
    std::fs::remove_file(&picture).expect("removed");
    let same = String::from_utf8(piped(&["diff", "-", &hxc], &columns)).expect("UTF-8");
    assert!(same.contains("have the same flags"), "{same}");
    let conflicts = [
        (&["mesh", SPOT, "-o", "-"][..], 2, "add --format"),
        (&["mesh", SPOT, "-o", "-", "--format", "xyz"], 2, "--format xyz: there is no such format"),
        (&["mesh", SPOT, "-o", &npy, "--format", "npy"], 4, "--format is given without -o -"),
        (&["mesh", SPOT, "--report", "-", "--json"], 4, "both are standard output"),
        (&["mesh", SPOT, "-o", "-", "--report", "-", "--format", "npy"], 4, "is written twice"),
        (&["mesh", "-", "-"], 4, "standard input can be read once"),
        (&["diff", "-", "-"], 4, "standard input can be read once"),
        (&["info", "-", "-"], 4, "standard input can be read once"),
        (&["mesh", SPOT, "-o", "-", "--format", "npy", "--resume"], 4, "--resume is given"),
    ];
    for (arguments, expected, text) in conflicts {
        let (code, said) = failed(arguments);
        assert!(code == Some(expected) && said.contains(text), "{arguments:?}: {code:?} {said}");
    }
}

#[test]
fn outputs_without_a_format_or_a_name_are_wrong_use() {
    for (name, expected) in [
        ("out.xyz", "no format has the extension \"xyz\""),
        ("out", "out: the name has no extension"),
        (".vti", "there is no name before the extension"),
    ] {
        let (code, said) = failed(&["mesh", SPOT, "-o", name]);
        assert!(code == Some(2) && said.contains(expected) && said.contains("hint: "), "{name}: {code:?} {said}");
    }
}

#[test]
fn a_file_may_be_named_like_settings() {
    let folder = Folder::new();
    let odd = folder.path("run:flag=3.stl");
    std::fs::copy(SPOT, &odd).expect("a copy");
    let report = json(&[&["mesh", &odd, "--json"][..], &CPU].concat());
    assert_eq!(
        (report["flags"][0]["flag"].as_u64(), report["flags"][0]["name"].as_str()),
        (Some(1), Some("run:flag=3"))
    );
    let report = json(&[&["mesh", &format!("{odd}:flag=9"), "--json"][..], &CPU].concat());
    assert_eq!(report["flags"][0]["flag"], 9);
}

#[test]
#[cfg(unix)]
fn names_that_are_not_utf8_are_written_and_of_inputs_explained() {
    use std::ffi::OsStr;
    use std::os::unix::ffi::OsStrExt;
    let folder = Folder::new();
    let odd = std::path::Path::new(&folder.path("")).join(OsStr::from_bytes(b"b\xffd.vti"));
    let mut command = Command::new(env!("CARGO_BIN_EXE_hexcast"));
    let command = command.current_dir(env!("CARGO_MANIFEST_DIR")).args(["mesh", SPOT]).args(CPU);
    assert!(command.arg("-o").arg(&odd).output().expect("hexcast starts").status.success());
    assert!(odd.is_file());
    let output = Command::new(env!("CARGO_BIN_EXE_hexcast")).arg("mesh").arg(&odd).output().expect("hexcast starts");
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.code() == Some(2) && said.contains("rename the file, or pipe it"), "{said}");
}

#[test]
fn options_that_nothing_uses_are_refused() {
    let (code, said) = failed(&["mesh", SPOT, "--backend", "cpu", "--adapter", "llvmpipe"]);
    assert!(code == Some(4) && said.contains("--adapter is given with the backend cpu"), "{said}");
}

#[test]
fn info_goes_on_after_an_error() {
    let output = hexcast(&["info", "nowhere.stl", SPOT, "src/lib.rs"]);
    let [said, shown] = [&output.stderr, &output.stdout].map(|bytes| String::from_utf8_lossy(bytes).into_owned());
    assert_eq!(output.status.code(), Some(7), "{said}");
    assert!(shown.contains("5,856"), "{shown}");
    let places = ["nowhere.stl: there is no such file", "src/lib.rs: "].map(|text| said.find(text));
    assert!(places[0].is_some() && places[0] < places[1], "{said}");
    let output = hexcast(&["info", "--json", "nowhere.stl", SPOT]);
    let list: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!((list[0]["error"]["code"].as_str(), list[1]["facets"].as_u64()), (Some("io"), Some(5856)));
    assert_eq!(output.status.code(), Some(7));
}

#[test]
fn resuming_something_else_names_the_file_and_the_difference() {
    let folder = Folder::new();
    let [output, kept] = ["a.npy", "a.hxc"].map(|name| folder.path(name));
    // a kept file is a column file with an identity in its head; without one it is of something else
    done(&[&["mesh", SPOT, "-o", &kept][..], &CPU].concat());
    std::fs::rename(&kept, folder.path("a.npy.partial")).expect("renamed");
    let (code, said) = failed(&["mesh", SPOT, "--cells", "8", "--backend", "cpu", "--resume", "-o", &output]);
    assert_eq!(code, Some(4), "{said}");
    assert!(said.contains("a.npy.partial: it holds the finished columns of something else: "), "{said}");
    assert!(said.contains("x 16 x 16 cells, where") && said.contains("x 8 x 8 are asked for"), "{said}");
    assert_eq!(folder.names(), ["a.npy.partial"]);
}

#[test]
fn too_little_memory_gets_one_way_out_where_another_is_none() {
    let (code, said) = failed(&["mesh", SPOT, "--cells", "16", "--backend", "cpu", "--max-memory", "1MB"]);
    assert_eq!(code, Some(5));
    let hint = said.lines().find(|line| line.starts_with("hint: ")).expect("a hint");
    let sizes: Vec<&str> = hint.split("MB").collect();
    assert!(sizes.len() < 3 || sizes[0].split(' ').nth_back(1) != sizes[1].split(' ').nth_back(1), "{hint}");
}

#[test]
fn lists_of_lines_that_are_wrong_are_explained_in_words() {
    let folder = Folder::new();
    let lines = folder.path("lines.json");
    for (text, says) in [
        ("{\"x\": [0, 1]}", "lines.json: line 1, column 13: there is no key `y`"),
        ("[1, 2]", "lines.json: it is a list, not an object of three lists"),
        ("{\"x\": [0, 1],\n\"y\": 3}", "lines.json: y: line 2, column 6: it is 3; give a list"),
        (
            "{\"x\": [0, 1],\n\"y\": [0, \"b\"]}",
            "lines.json: y[1]: line 2, column 12: it is the text \"b\"; give a number",
        ),
        ("x = [0, 1]", "lines.json: it is not valid JSON: "),
    ] {
        std::fs::write(&lines, text).expect("written");
        let (code, said) = failed(&["mesh", SPOT, "--lines", &lines]);
        assert!(
            code == Some(4) && said.contains(says) && said.contains("hint: write three lists of numbers"),
            "{text}: {said}"
        );
    }
    let (code, said) = failed(&["verify-store", &lines]);
    assert!(code == Some(7) && said.contains("is not a Zarr store of flags"), "{said}");
}

#[test]
fn a_surface_in_place_of_a_column_file_is_named_as_such() {
    let folder = Folder::new();
    let [png, npy] = ["a.png", "a.npy"].map(|name| folder.path(name));
    let cases: [&[&str]; 4] =
        [&["convert", SPOT, &npy], &["slice", SPOT, "-o", &png], &["view", SPOT, "-o", &png], &["diff", SPOT, SPOT]];
    for arguments in cases {
        let (code, said) = failed(arguments);
        assert!(code == Some(3) && said.contains("is not a column file") && said.contains("mesh it first"), "{said}");
    }
}

#[test]
fn volumes_have_digits() {
    let shown = done(&[&["mesh", SPOT][..], &CPU].concat());
    assert!(shown.contains(", of the surface 0.7182588, "), "{shown}");
    assert!(!shown.contains("e-1"), "{shown}");
    let shown = done(&[&["mesh", SPOT, "--unit", "mm"][..], &CPU].concat());
    assert!(shown.contains(" mm^3, of the surface 0.7182588, "), "{shown}");
    let shown = done(&["info", SPOT]);
    assert!(shown.contains("volume      0.7182588\narea        5.709519\n"), "{shown}");
}

#[test]
fn a_box_and_every_nth_cell_of_a_mesh_are_converted() {
    let folder = Folder::new();
    let [hxc, raw, cut] = ["a.hxc", "a.raw", "cut.raw"].map(|name| folder.path(name));
    done(&["mesh", SPOT, "--cells", "40", "--backend", "cpu", "-o", &hxc, "-o", &raw]);
    let dims =
        |name: &str| serde_json::from_value::<[usize; 3]>(folder.json(name)["dims"].clone()).expect("three numbers");
    let shown = done(&["convert", &hxc, &cut, "--window", "1,2,3,20,38,37", "--stride", "2", "3", "4"]);
    assert!(shown.contains("1, 0 and 2 cells at the end of x, y and z"), "{shown}");
    let ([nz, ny, nx], whole, found) = ([8, 12, 9], folder.bytes("a.raw"), folder.bytes("cut.raw"));
    assert_eq!((dims("cut.raw.json"), found.len()), ([nx, ny, nz], nz * ny * nx));
    let [mx, my, _] = dims("a.raw.json");
    let middle = |k: usize, j: usize, i: usize| (((3 + 4 * k + 2) * my) + 2 + 3 * j + 1) * mx + 1 + 2 * i + 1;
    for (index, flag) in found.iter().enumerate() {
        assert_eq!(*flag, whole[middle(index / nx / ny, index / nx % ny, index % nx)], "cell {index}");
    }
    let (code, said) = failed(&["convert", &hxc, &cut, "--window", "0,0,0,1,1,999"]);
    assert!(code == Some(4) && said.contains("the box has cells 0 to 999 along z"), "{said}");
}

#[test]
fn flags_of_the_fluid_that_are_wrong_or_that_nothing_has_are_said() {
    let folder = Folder::new();
    let links = folder.path("a.links");
    let mesh = ["mesh", SPOT, "--cells", "12", "--backend", "cpu", "--links", &links, "--fluid"];
    for (fluid, words) in
        [("300", "\"300\" is too large: a whole number from 0 to 255 is needed"), ("", "is not a number")]
    {
        let (_, error) = failed(&[&mesh[..], &[fluid]].concat());
        assert!(error.contains(words), "{error}");
    }
    let warned = |fluid: &str| json(&[&mesh[..], &[fluid, "--json"]].concat())["warnings"].to_string();
    let words = "no geometry has flag 5, which links.fluid (--fluid) names: no link begins there";
    assert!(warned("5,0,7").contains(words), "{}", warned("5,0,7"));
    assert!(!warned("0,1").contains("no geometry has flag"));
    let closed = json(&[&mesh[..], &["2", "--json", "--close-gaps", "3"]].concat());
    assert!(!closed["warnings"].to_string().contains("no geometry has flag"));
}

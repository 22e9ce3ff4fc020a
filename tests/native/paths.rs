//! No command writes over what it reads, nor two outputs to one place, by whatever name the file is given.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::{Command, Stdio};

use super::cli::{Folder, SPOT, hexcast};

const LINES: &str = r#"{"x": [-1, 0, 1], "y": [-1, 0, 1], "z": [-1, 0, 1]}"#;

/// A folder of inputs, each with other names: a symbolic link, a hard link, and one through a link to the folder.
fn inputs() -> Folder {
    let folder = Folder::new();
    let at = |name: &str| folder.path(name);
    std::fs::create_dir(at("out")).expect("a folder");
    let cube = hexcast(&["mesh", SPOT, "--cells", "8", "--backend", "cpu", "-o", &at("m.hxc"), "-q"]);
    assert!(cube.status.success(), "{cube:?}");
    std::fs::copy(SPOT, at("in.stl")).expect("a model");
    std::fs::copy(SPOT, at("in.svg")).expect("a model");
    std::fs::copy(SPOT, at("in.png")).expect("a model");
    std::fs::copy(SPOT, at("in.npz")).expect("a model");
    std::fs::copy(SPOT, at("in.vtp")).expect("a model");
    std::fs::copy(at("m.hxc"), at("m.png")).expect("a mesh");
    std::fs::copy(at("m.hxc"), at("m.vtp")).expect("a mesh");
    std::fs::write(at("L.json"), LINES).expect("lines");
    std::fs::write(at("j.json"), r#"{"geometries": [{"file": "in.stl"}], "cells": 8}"#).expect("a job");
    for part in ["1", "2"] {
        let made = hexcast(&[
            "mesh",
            SPOT,
            "--cells",
            "8",
            "--backend",
            "cpu",
            "--part",
            &format!("{part}/2"),
            "--report",
            &at(&format!("p{part}.json")),
            "-q",
        ]);
        assert!(made.status.success(), "{made:?}");
    }
    #[cfg(unix)]
    std::os::unix::fs::symlink(at(""), at("here")).expect("a link");
    folder
}

/// All bytes of a folder, by name.
fn bytes(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let entries = std::fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path());
    let files = entries.filter(|path| path.is_file());
    files.map(|path| (path.display().to_string(), std::fs::read(&path).expect("a file"))).collect()
}

/// Words of a command; `IN` is an input, and `OUT` an output by another name of it.
const CASES: &[(&str, &str)] = &[
    ("in.stl", "mesh IN --dump-job OUT"),
    ("in.stl", "mesh IN --report OUT"),
    ("in.npz", "mesh IN -o OUT"),
    ("in.npz", "mesh IN --doubt OUT"),
    ("in.npz", "mesh IN --links OUT"),
    ("in.npz", "mesh IN --fractions OUT"),
    ("in.npz", "mesh IN --staggered OUT"),
    ("in.png", "mesh IN --slice OUT"),
    ("in.png", "mesh IN --view OUT"),
    ("L.json", "mesh in.stl --lines IN --report OUT"),
    ("L.json", "mesh in.stl --lines IN --dump-job OUT"),
    ("j.json", "mesh --job IN --dump-job OUT"),
    ("j.json", "mesh --job IN --report OUT"),
    ("in.stl", "mesh --job j.json --report OUT"),
    ("in.stl", "mesh --job j.json --dump-job OUT"),
    ("in.svg", "estimate IN -o OUT"),
    ("in.svg", "converge IN --sizes 4 -o OUT"),
    ("in.npz", "refine IN --levels 1 -o OUT"),
    ("m.hxc", "convert IN OUT"),
    ("m.hxc", "diff m.hxc IN -o OUT"),
    ("m.hxc", "diff IN m.vtp -o OUT"),
    ("m.png", "slice IN -o OUT"),
    ("m.png", "view IN -o OUT"),
    ("m.vtp", "leak IN --from 0,0,0 --to 0.1,0,0 -o OUT"),
    ("in.vtp", "leak m.hxc --from 0,0,0 --to 0.1,0,0 --surface IN -o OUT"),
    ("p1.json", "merge IN p2.json -o OUT"),
    ("p2.json", "merge p1.json IN -o OUT"),
];

#[test]
fn no_command_writes_over_what_it_reads() {
    let folder = inputs();
    let before = bytes(Path::new(&folder.path("")));
    for (input, words) in CASES {
        let ending = input.rsplit('.').next().expect("an ending");
        let (soft, hard) = (format!("soft.{ending}"), format!("hard.{ending}"));
        #[cfg(unix)]
        std::os::unix::fs::symlink(folder.path(input), folder.path(&soft)).expect("a link");
        std::fs::hard_link(folder.path(input), folder.path(&hard)).expect("a link");
        let others: &[&str] = if cfg!(unix) { &[&soft, &hard, &format!("here/{input}")] } else { &[] };
        for other in [*input, &format!("out/../{input}")].iter().chain(others) {
            let arguments = words.split(' ').map(|word| match word {
                "IN" => folder.path(input),
                "OUT" => folder.path(other),
                name if name.contains('.') && !name.contains(',') => folder.path(name),
                word => word.into(),
            });
            let arguments: Vec<String> = arguments.collect();
            let output = hexcast(&arguments.iter().map(String::as_str).collect::<Vec<_>>());
            let said = String::from_utf8_lossy(&output.stderr);
            assert_eq!(output.status.code(), Some(4), "{words} with {other}: {said}");
            assert!(said.contains("is an input too"), "{words} with {other}: {said}");
        }
        for name in [&soft, &hard] {
            let _ = std::fs::remove_file(folder.path(name));
        }
        assert!(bytes(Path::new(&folder.path(""))) == before, "{words}");
    }
}

#[test]
fn two_outputs_have_two_places() {
    let folder = inputs();
    let at = |name: &str| folder.path(name);
    let cases: &[&[&str]] = &[
        &["--report", &at("a.json"), "--dump-job", &at("a.json")],
        &["-o", &at("a.raw"), "--report", &at("a.raw.json")],
        &["-o", &at("a.npy"), "-o", &at("out/../a.npy")],
        &["--slice", &at("a.png"), "--view", &at("a.png")],
        &["--links", &at("a.npz"), "-o", &at("a.npz")],
        &["-o", &at("a.hxc"), "--report", &at("a.hxc.partial"), "--resume"],
    ];
    for case in cases {
        let output = hexcast(&[&["mesh", &at("in.stl"), "--backend", "cpu", "--cells", "4"], *case].concat());
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.code() == Some(4) && said.contains("is written twice"), "{case:?}: {said}");
    }
    assert!(!folder.names().iter().any(|name| name.starts_with("a.")), "{:?}", folder.names());
}

#[test]
fn an_input_in_a_folder_that_is_replaced_is_kept() {
    let folder = inputs();
    let (store, model) = (folder.path("old.zarr"), folder.path("old.zarr/in.stl"));
    let mesh = |model: &str| hexcast(&["mesh", model, "--cells", "8", "--backend", "cpu", "-o", &store, "-q"]);
    assert!(mesh(&folder.path("in.stl")).status.success());
    std::fs::copy(SPOT, &model).expect("a model");
    let refused = mesh(&model);
    let said = String::from_utf8_lossy(&refused.stderr);
    assert!(refused.status.code() == Some(4) && said.contains("a folder that is replaced"), "{said}");
    assert!(std::fs::read(&model).expect("it is there") == std::fs::read(SPOT).expect("the fixture"));
}

#[cfg(unix)]
#[test]
fn standard_input_and_output_are_known_by_their_files() {
    let folder = inputs();
    let (model, mesh) = (folder.path("in.stl"), folder.path("m.hxc"));
    let run = |arguments: &[&str], input: &str, output: Option<&str>| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_hexcast"));
        command.args(arguments).stdin(std::fs::File::open(input).expect("an input")).stderr(Stdio::piped());
        command.stdout(output.map_or_else(Stdio::null, |path| {
            std::fs::File::options().append(true).open(path).expect("an output").into()
        }));
        let output = command.output().expect("it runs");
        (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    let before = bytes(Path::new(&folder.path("")));
    let (code, said) = run(&["mesh", "-", "--cells", "8", "--backend", "cpu", "--report", &model], &model, None);
    assert!(code == Some(4) && said.contains("is an input too"), "{said}");
    let (code, said) = run(&["convert", "-", &mesh], &mesh, None);
    assert!(code == Some(4) && said.contains("is an input too"), "{said}");
    let (code, said) = run(&["convert", &mesh, "-", "--format", "npy"], &model, Some(&mesh));
    assert!(code == Some(4) && said.contains("is an input too"), "{said}");
    assert!(bytes(Path::new(&folder.path(""))) == before);
}

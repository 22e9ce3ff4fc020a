//! Reports of the command line: real ones of all kinds of meshes are held to the schema in `docs/`, their job makes the same mesh again,
//! and masks of doubtful cells are those of the boxes.

use jsonschema::Validator;
use serde_json::Value;

use super::cli::{Folder, MANY_RAYS, SPOT, done, hexcast, json};

fn schema() -> Value {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/report.schema.json");
    serde_json::from_str(&std::fs::read_to_string(file).expect("the schema")).expect("JSON")
}

fn assert_valid(validator: &Validator, report: &Value, what: &str) {
    let errors: Vec<String> =
        validator.iter_errors(report).map(|error| format!("{}: {error}", error.instance_path())).collect();
    assert!(errors.is_empty(), "{what}: {}", errors.join("\n"));
}

/// An ASCII STL file of four facets: the sides of a pyramid, without its floor.
fn pyramid_without_a_floor() -> String {
    let corners = ["0 0 0", "1 0 0", "1 1 0", "0 1 0", "0.2 0.3 1"];
    let side = |side: [usize; 3]| {
        let corners = side.map(|corner| corners[corner]).join("\nvertex ");
        format!("facet normal 0 0 1\nouter loop\nvertex {corners}\nendloop\nendfacet\n")
    };
    format!("solid\n{}endsolid\n", [[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]].map(side).concat())
}

#[test]
fn reports_of_all_kinds_keep_to_the_schema() {
    let validator = jsonschema::draft202012::new(&schema()).expect("a schema of draft 2020-12");
    let folder = Folder::new();
    std::fs::write(folder.path("open.stl"), pyramid_without_a_floor()).unwrap();
    let open = folder.path("open.stl");
    let shell = format!("{SPOT}:fill=conservative,shell=true,translate=0.1/0/0");
    let moved = format!("{SPOT}:scale=0.5,open=vote");
    let kinds: [(&str, Vec<&str>); 8] = [
        ("closed", vec![SPOT, "--cells", "16"]),
        (
            "closed, all that can be asked for",
            vec![
                SPOT,
                "--max-cell-size",
                "0.1",
                "--hash",
                "sha256",
                "--flags-in-memory",
                "--unit",
                "mm",
                "--padding-cells",
                "1,2,3",
            ],
        ),
        ("open", vec![&open, "--cells", "9"]),
        (
            "open and closed, inverted",
            vec![&open, SPOT, "--dims", "9,8,7", "--invert", "--rule", "nonzero", "--padding-length", "0.2"],
        ),
        ("certified, with gaps closed", vec![SPOT, &moved, &shell, "--cells", "20", "--certify", "--close-gaps", "3"]),
        (
            "certified, one geometry beside another",
            vec![SPOT, &moved, "--cells", "30", "--certify", "--thin-cells", "4"],
        ),
        ("on a GPU", vec![SPOT, "--cells", "16", "--backend", "gpu"]),
        (
            "open, with max_memory in the job",
            vec![&open, "--cell-size", "0.2,0.1,0.3", "--max-memory", "2GB", "--open", "parity"],
        ),
    ];
    let mut filled = std::collections::BTreeSet::new();
    for (what, arguments) in kinds {
        let backend: &[&str] = if arguments.contains(&"gpu") { &[] } else { &["--backend", "cpu"] };
        let report = json(&[&["mesh", "--json"], backend, &arguments[..]].concat());
        assert_valid(&validator, &report, what);
        for key in ["open", "filled", "gaps", "certificate", "device_check", "flags_sha256", "warnings"] {
            let value = &report[key];
            if !value.is_null() && value != &serde_json::json!([]) {
                filled.insert(key);
            }
        }
        // a key without a schema, and one that is missing
        let mut more = report.clone();
        more["geometries"][0]["colour"] = "red".into();
        assert!(!validator.is_valid(&more), "{what}");
        let mut less = report;
        less.as_object_mut().unwrap().remove("dims");
        assert!(!validator.is_valid(&less), "{what}");
    }
    assert_eq!(filled.len(), 7, "{filled:?}");
    let spill = ["--max-memory", "100MB", "--spill", &folder.path("")];
    let spilled = json(&[&MANY_RAYS[..], &spill].concat());
    assert!(spilled["peak_bytes"]["spilled"].as_u64().is_some_and(|bytes| bytes > 0));
    assert_valid(&validator, &spilled, "spilled");
}

#[test]
fn the_job_of_a_report_makes_the_same_mesh_again() {
    let folder = Folder::new();
    let two = "solid one\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 9 0 0\nvertex 0 9 1\nendloop\nendfacet\nendsolid\n";
    std::fs::write(folder.path("two.stl"), format!("{two}{}", two.replace("one", "two").replace("9", "7"))).unwrap();
    let two = format!("{}:split=true,fill=separating", folder.path("two.stl"));
    let body = format!("{SPOT}:flag=9,rotate=10/20/30,invert=true");
    let cases: [&[&str]; 4] = [
        &[SPOT],
        &[
            SPOT,
            "--max-cell-size",
            "0.05",
            "--padding-cells",
            "1,2,3",
            "--certify",
            "--unit",
            "mm",
            "--rule",
            "nonzero",
        ],
        &[&body, "--dims", "20,30,25", "--padding-length", "0.1", "--close-gaps", "3", "--open", "vote"],
        &[&two, SPOT, &body, "--cell-size", "0.5,0.6,0.7", "--domain", "-1,-2,-3,10,11,12.5"],
    ];
    for arguments in cases {
        let report = json(&[&["mesh", "--backend", "cpu", "--json"], arguments].concat());
        let job = folder.path("job.json");
        // names of files are those that were given, relative to the folder of the job file
        let here = std::env::current_dir().unwrap();
        let mut placed = report["job"].clone();
        for geometry in placed["geometries"].as_array_mut().unwrap() {
            geometry["file"] = here.join(geometry["file"].as_str().unwrap()).to_string_lossy().into();
        }
        std::fs::write(&job, placed.to_string()).unwrap();
        let again = json(&["mesh", "--json", "--job", &job]);
        assert_eq!(again["flags_hash"], report["flags_hash"], "{arguments:?}");
        assert!(report["flags_hash"].is_string() && report["job"].get("max_memory").is_none(), "{report}");
        // nothing is left open that could be filled in again
        assert_eq!(again["job"], placed, "{arguments:?}");
        for (index, geometry) in report["job"]["geometries"].as_array().unwrap().iter().enumerate() {
            assert!(["file", "flag", "open", "fill"].iter().all(|key| !geometry[key].is_null()), "{index}: {geometry}");
        }
    }
}

#[test]
fn masks_of_doubtful_cells_are_those_of_the_boxes_in_every_format() {
    let folder = Folder::new();
    let open = folder.path("open.stl");
    std::fs::write(&open, pyramid_without_a_floor()).unwrap();
    let whole = format!("{SPOT}:flag=3");
    let mut all = Vec::new();
    for (axis, backend) in [("x", "cpu"), ("y", "cpu"), ("z", "cpu"), ("z", "gpu")] {
        let (mask, flags) = (folder.path("doubt.raw"), folder.path("flags.raw"));
        let size = ["mesh", &open, &whole, "--dims", "20,23,26", "--axis", axis, "--backend", backend];
        let report = json(&[&size[..], &["--json", "--doubt", &mask, "-o", &flags, "--hash", "sha256"]].concat());
        let mask = folder.bytes("doubt.raw");
        let doubtful = &report["doubtful"];
        assert_eq!(doubtful["cells"], mask.iter().filter(|cell| **cell == 1).count());
        assert_eq!((&doubtful["are_all"], &doubtful["cells_in_boxes"]), (&true.into(), &doubtful["cells"]));
        assert_eq!(doubtful["cells"], report["open"][0]["doubtful_cells"]);
        let mut expected = vec![0u8; mask.len()];
        let number = |corner: &Value, axis: usize| corner[axis].as_u64().unwrap() as usize;
        for corners in doubtful["boxes"].as_array().unwrap() {
            let [xs, ys, zs] = [0, 1, 2].map(|axis| number(&corners[0], axis)..number(&corners[1], axis));
            for z in zs {
                for y in ys.clone() {
                    xs.clone().for_each(|x| expected[x + 20 * (y + 23 * z)] += 1);
                }
            }
        }
        assert!(expected == mask, "{axis}, {backend}");
        let sidecar = folder.json("doubt.raw.json");
        assert_eq!(sidecar["flags"][0]["name"], "doubtful");
        // the hash of the report is that of the flags
        assert_eq!(report["flags_sha256"], folder.json("flags.raw.json")["sha256"]);
        assert_ne!(report["flags_sha256"], sidecar["sha256"]);
        all.push((mask, doubtful.clone()));
    }
    assert!(all.windows(2).all(|two| two[0] == two[1]) && all[0].0.contains(&1));
    for name in ["doubt.vti", "doubt.npy", "doubt.hxc"] {
        let mask = folder.path(name);
        done(&["mesh", &open, &whole, "--dims", "20,23,26", "--backend", "cpu", "--doubt", &mask, "-q"]);
        assert!(folder.bytes(name).len() > 100);
    }
    assert_eq!(folder.bytes("doubt.npy")[128..], all[0].0);
    done(&["convert", &folder.path("doubt.hxc"), &folder.path("again.raw"), "-q"]);
    assert_eq!(folder.bytes("again.raw"), all[0].0);
    // nothing is doubtful of what is closed
    let mask = folder.path("none.raw");
    let report = json(&["mesh", SPOT, "--cells", "9", "--backend", "cpu", "--doubt", &mask, "--json"]);
    assert_eq!(report["doubtful"], serde_json::json!({"cells": 0, "boxes": [], "cells_in_boxes": 0, "are_all": true}));
    assert!(folder.bytes("none.raw").iter().all(|cell| *cell == 0));
    let refused = hexcast(&["mesh", SPOT, "--cells", "9", "--doubt", &folder.path("a.zarr")]);
    assert_eq!(refused.status.code(), Some(4), "{}", String::from_utf8_lossy(&refused.stderr));
}

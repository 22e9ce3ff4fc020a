//! Reports of parts merge into the report of the whole, but for times and memory.

use serde_json::Value;

use super::cli::{Folder, SPOT, done, hexcast, json};

const OPEN: &str = "tests/fixtures/featuretype.stl";

/// A report without what depends on the run: times, memory.
fn lasting(mut report: Value) -> Value {
    let object = report.as_object_mut().expect("an object");
    ["seconds", "peak_bytes", "cells_per_second"].iter().for_each(|key| drop(object.remove(*key)));
    report
}

#[test]
fn parts_have_the_report_of_the_whole_together() {
    let moved = format!("{SPOT}:scale=0.5,name=small,flag=9");
    let walls = format!("{SPOT}:fill=conservative");
    let cases: [(&[&str], &str, &str); 5] = [
        (&[SPOT, "--padding-cells", "1"], "4", "x"),
        (&[SPOT, &moved, "--unit", "mm"], "3x2x1", "z"),
        (&[OPEN], "5", "y"),
        (&[&walls, OPEN, "--rule", "nonzero"], "1x2x2", "x"),
        (&[OPEN, "--open", "parity", "--domain", "-1,-1,-1,9,9,9"], "1", "z"),
    ];
    for (job, of, axis) in cases {
        let folder = Folder::new();
        let arguments = [&["mesh", "--cells", "30", "--backend", "cpu", "--json", "--axis", axis], job].concat();
        let expected = lasting(json(&arguments));
        let n: usize = of.split('x').map(|n| n.parse::<usize>().unwrap()).product();
        let names: Vec<String> = (1..=n).rev().map(|k| folder.path(&format!("{k}.json"))).collect();
        for (name, k) in names.iter().zip((1..=n).rev()) {
            done(&[&arguments[..], &["--part", &format!("{k}/{of}"), "--report", name]].concat());
        }
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let merged = json(&[&["merge"], &names[..]].concat());
        assert!(merged["seconds"]["total"].as_f64().unwrap() > 0.0);
        let merged = lasting(merged);
        for (key, value) in expected.as_object().expect("an object") {
            assert_eq!(&merged[key], value, "{job:?} in {of}: {key}");
        }
        assert_eq!(merged, expected);
    }
}

#[test]
fn reports_that_are_not_of_all_parts_of_one_mesh_are_refused() {
    let folder = Folder::new();
    let report = |name: &str, arguments: &[&str]| {
        let path = folder.path(name);
        done(&[&["mesh", SPOT, "--backend", "cpu", "-q", "--report", &path], arguments].concat());
        path
    };
    let [one, two] = ["1/2", "2/2"].map(|part| report(&part.replace('/', "-"), &["--cells", "20", "--part", part]));
    let other = report("other", &["--cells", "20", "--unit", "m", "--part", "2/2"]);
    let whole = report("whole", &["--cells", "20"]);
    let halo = report("halo", &["--cells", "20", "--part", "2/2", "--halo", "1"]);
    let along = ["1/2", "2/2"]
        .map(|part| report(&format!("z{}", &part[..1]), &["--cells", "20", "--part", part, "--axis", "z"]));
    std::fs::write(folder.path("text"), "{").unwrap();
    for (reports, words) in [
        (vec![&one], "do not divide"),
        (vec![&one, &two, &two], "do not divide"),
        (vec![&one, &other], "they differ in unit"),
        (vec![&one, &whole], "report 2 is of a whole mesh"),
        (vec![&one, &halo], "with a halo of 1 cells"),
        (vec![&along[0], &along[1]], "cut along z"),
        (vec![&folder.path("text")], "is not the report of a mesh"),
    ] {
        let reports: Vec<&str> = reports.into_iter().map(String::as_str).collect();
        let output = hexcast(&[&["merge"], &reports[..]].concat());
        let error = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.code() == Some(4) && error.contains(words), "{words}: {error}");
    }
    let merged = folder.path("merged.json");
    done(&["merge", &two, &one, "-o", &merged]);
    assert_eq!(folder.json("merged.json")["flags_hash"], folder.json("whole")["flags_hash"]);
}

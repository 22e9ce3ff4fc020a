//! Reports of parts merge into the report of the whole, but for times and memory.

use serde_json::Value;

use super::cli::{Folder, SPOT, done, hexcast, json};
use super::models;

const OPEN: &str = "tests/fixtures/featuretype.stl";

/// A report without what depends on the run: times, memory.
fn lasting(mut report: Value) -> Value {
    let object = report.as_object_mut().expect("an object");
    ["seconds", "peak_bytes", "cells_per_second"].iter().for_each(|key| drop(object.remove(*key)));
    report
}

/// Files of bodies that have what a certificate and warnings speak of: walls of less than a cell, a gap of a cell, shells in one another,
/// and a body that no centre of a cell is in.
fn folder_of_plates() -> Folder {
    let folder = Folder::new();
    let write = |name: &str, facets: Vec<hexcast::geometry::Facet>| {
        let corners = facets.as_flattened().as_flattened().chunks(9);
        let facet = |facet: &[f32]| {
            [&[0u8; 12][..], &facet.iter().flat_map(|c| c.to_le_bytes()).collect::<Vec<u8>>(), &[0; 2]].concat()
        };
        let head = [&[0u8; 80][..], &(facets.len() as u32).to_le_bytes()].concat();
        std::fs::write(folder.path(name), [head, corners.flat_map(facet).collect()].concat()).expect("a file");
    };
    write(
        "thin.stl",
        models::joined([
            models::cuboid([0.0, 0.0, 3.1], [8.0, 8.0, 3.2]),
            models::cuboid([0.0, 0.0, 5.1], [4.0, 8.0, 6.2]),
        ]),
    );
    write("near.stl", models::cuboid([0.0, 0.0, 3.5], [8.0, 7.0, 4.0]));
    write(
        "inner.stl",
        models::joined([
            models::cuboid([0.5, 0.0, 0.0], [7.0, 7.0, 7.0]),
            models::cuboid([1.0, 1.0, 1.0], [6.0, 8.0, 5.5]),
        ]),
    );
    write("covered.stl", models::cuboid([6.1, 1.0, 1.0], [6.9, 5.0, 5.0]));
    write("lost.stl", models::cuboid([4.0, 4.0, 8.02], [8.0, 8.0, 8.04]));
    folder
}

#[test]
fn parts_have_the_report_of_the_whole_together() {
    let moved = format!("{SPOT}:scale=0.5,name=small,flag=9");
    let walls = format!("{SPOT}:fill=conservative");
    let plate = folder_of_plates();
    let [thin, near, inner, lost] = ["thin", "near", "inner", "lost"].map(|name| plate.path(&format!("{name}.stl")));
    let hidden = format!("{}:priority=-1", plate.path("covered.stl"));
    let plates = [&thin[..], &near, &inner, "--certify", "--thin-cells", "5", "--domain", "-1,-1,-1,9,9,9"];
    let shells = [&inner[..], &lost, &hidden, SPOT, "--domain", "-1,-1,-1,9,9,9"];
    let cases: [(&[&str], &str, &str); 14] = [
        // parts that cut their rays
        (&[SPOT], "3", "z"),
        (&[SPOT, &moved, "--certify"], "2x2x3", "y"),
        (&[OPEN, SPOT, "--certify", "--rule", "nonzero"], "3x2x2", "x"),
        (&[&walls, &moved, OPEN, "--certify"], "4", "z"),
        (&[&walls, &moved, "--invert"], "2x3x1", "x"),
        (&plates, "2x3x4", "z"),
        (&plates, "1x1x17", "y"),
        (&plates, "30x1x2", "x"),
        (&shells, "2x2x2", "x"),
        (&[SPOT, "--padding-cells", "1"], "4", "x"),
        (&[SPOT, &moved, "--unit", "mm"], "3x2x1", "z"),
        (&[OPEN], "5", "y"),
        (&[&walls, OPEN, "--rule", "nonzero"], "1x2x2", "x"),
        (&[OPEN, "--open", "parity", "--domain", "-1,-1,-1,9,9,9"], "1", "z"),
    ];
    let mut seen = [0; 6];
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
        let lists =
            ["thin_walls", "overlaps", "gaps"].map(|key| expected["certificate"][key].as_array().map_or(0, Vec::len));
        let says = |words: &str| expected["warnings"].to_string().matches(words).count();
        let said = ["shells of geometry", "got no cell: its cells are those of", "got no cell: it is"].map(says);
        seen.iter_mut().zip(lists.into_iter().chain(said)).for_each(|(seen, n)| *seen += n);
    }
    assert!(seen.iter().all(|n| *n > 0), "what is to be merged is there: {seen:?}");
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
    done(&["merge", &halo, &one, "-o", &folder.path("halos.json")]);
    // a report that does not say what its cells have without the halo
    let mut bare = folder.json("halo");
    bare["window"]["without_halo"] = Value::Null;
    std::fs::write(folder.path("halo"), bare.to_string()).unwrap();
    let whole_of = json(&["mesh", SPOT, "--cells", "20", "--backend", "cpu", "--json"]);
    let [nx, ny, nz] = [0, 1, 2].map(|axis| whole_of["dims"][axis].as_u64().expect("a number"));
    let along = [0, 5].map(|z| {
        let window = format!("0,0,{z},{nx},{ny},{}", if z == 0 { 5 } else { nz });
        report(&format!("z{z}"), &["--cells", "20", "--window", &window, "--axis", "z"])
    });
    std::fs::write(folder.path("text"), "{").unwrap();
    for (reports, words) in [
        (vec![&one], "do not divide"),
        (vec![&one, &two, &two], "do not divide"),
        (vec![&one, &other], "they differ in unit"),
        (vec![&one, &whole], "report 2 is of a whole mesh"),
        (vec![&one, &halo], "report 2 is of a window with a halo of 1 cells, which other reports count, too"),
        (vec![&along[0], &along[1]], "cut rays along z"),
        (vec![&folder.path("text")], "is not the report of a mesh"),
    ] {
        let reports: Vec<&str> = reports.into_iter().map(String::as_str).collect();
        let output = hexcast(&[&["merge"], &reports[..]].concat());
        let error = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.code() == Some(4) && error.contains(words), "{words}: {error}");
    }
    let merged = folder.path("merged.json");
    done(&["merge", &two, &one, "-o", &merged]);
    assert_eq!(lasting(folder.json("halos.json")), lasting(folder.json("merged.json")));
    assert_eq!(folder.json("merged.json")["flags_hash"], folder.json("whole")["flags_hash"]);
}

#[test]
fn points_of_a_staggered_grid_are_those_of_the_whole_together() {
    let folder = Folder::new();
    let npz = folder.path("points.npz");
    // a surface without inside, which is faces alone, on borders of parts, too
    let shell = format!("{SPOT}:scale=0.7,fill=separating,shell=true,priority=1");
    let mut n_faces = 0;
    for (of, n, more) in
        [("2x3x2", 12, "--axis=x"), ("4", 4, "--axis=y"), ("3x1x1", 3, "--padding-cells=2"), ("1", 1, "--axis=z")]
    {
        let mesh = ["mesh", SPOT, &shell, "--cells", "20", "--backend", "cpu", "--json", "--staggered", &npz, more];
        let expected = json(&mesh);
        n_faces += expected["staggered"]["sheet_faces"].as_u64().unwrap();
        let reports: Vec<Value> =
            (1..=n).map(|k| json(&[&mesh[..], &["--part", &format!("{k}/{of}")]].concat())).collect();
        let shared = |key: &str| reports.iter().map(|report| report["staggered"][key].as_u64().unwrap()).sum::<u64>();
        assert!(n == 1 || shared("sheet_faces") > expected["staggered"]["sheet_faces"].as_u64().unwrap());
        let names: Vec<String> = (1..=n).map(|k| folder.path(&format!("{k}.json"))).collect();
        names.iter().zip(&reports).for_each(|(name, report)| std::fs::write(name, report.to_string()).unwrap());
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let merged = json(&[&["merge"], &names[..]].concat());
        assert_eq!(merged["staggered"], expected["staggered"], "{of}");
    }
    assert!(n_faces > 500, "{n_faces}");
}

#[test]
fn findings_of_parts_are_one_where_they_say_the_same_in_other_words() {
    let plate = folder_of_plates();
    let [thin, lost] = ["thin", "lost"].map(|name| plate.path(&format!("{name}.stl")));
    // nobody gave the second the flag that both have, and the first lies between centres
    let flagged = format!("{lost}:flag=2");
    let of_part = |part: &str| {
        json(&[
            "mesh",
            "--json",
            "--backend",
            "cpu",
            &flagged,
            &thin,
            "--domain",
            "-1,-1,-1,9,9,9",
            "--cells",
            "20",
            "--part",
            part,
        ])
    };
    let mut parts = [of_part("1/2"), of_part("2/2")];
    let found = |report: &Value, code: &str| -> Vec<Value> {
        report["findings"].as_array().expect("a list").iter().filter(|of| of["code"] == code).cloned().collect()
    };
    assert!(parts.iter().all(|part| found(part, "flag-shared").len() == 1));
    for (part, word) in parts.iter_mut().zip(["one", "two"]) {
        for finding in part["findings"].as_array_mut().expect("a list") {
            finding["sentence"] = word.into();
        }
        part["warnings"] = serde_json::json!([word]);
    }
    let merged = hexcast::pipeline::merge(&parts).expect("a report");
    let shared = found(&merged, "flag-shared");
    assert_eq!(shared.len(), 1, "{shared:#?}");
    assert_eq!(shared[0]["sentence"], "one");
    assert!(shared[0]["remedies"][0]["option"].as_str().is_some_and(|option| option.ends_with("thin.stl:flag=1")));
    // other data is another finding
    let values = &mut parts[1]["findings"].as_array_mut().expect("a list");
    let of_flag = values.iter_mut().find(|finding| finding["code"] == "flag-shared").expect("the finding");
    of_flag["values"]["free_flag"] = 9.into();
    assert_eq!(found(&hexcast::pipeline::merge(&parts).expect("a report"), "flag-shared").len(), 2);
    // a code that this version does not know is refused
    parts[1]["findings"][0]["code"] = "flag-lost".into();
    let refused = hexcast::pipeline::merge(&parts).unwrap_err();
    assert!(refused.to_string().contains("\"flag-lost\" is no code of a finding"), "{refused}");
}

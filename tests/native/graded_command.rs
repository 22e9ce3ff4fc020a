//! Cells that differ in size as a user of the command line meets them: lists from a file, generated lines, files, refusals.

use serde_json::{Value, json};

use super::cli::{Folder, SPOT, done, hexcast, json as report_of};

/// Three lists around the model, which reaches from about -0.5 to 0.95.
fn lists() -> Value {
    let graded = |n: i32| -> Vec<f64> {
        (0..=n).map(|k| f64::from(k) / f64::from(n)).map(|share| -1.2 + 2.6 * share.powf(1.2)).collect()
    };
    json!({ "x": graded(40), "y": graded(50), "z": graded(45) })
}

/// Standard error of a command that must fail.
#[track_caller]
fn refused(arguments: &[&str]) -> String {
    let output = hexcast(arguments);
    assert!(!output.status.success(), "{arguments:?} succeeds");
    String::from_utf8_lossy(&output.stderr).into_owned()
}

#[test]
fn lines_from_a_file_are_those_of_every_output() {
    let folder = Folder::new();
    let [lines, mesh, store, raw, again] =
        ["lines.json", "spot.hxc", "spot.zarr", "spot.raw", "again.vtr"].map(|name| folder.path(name));
    std::fs::write(&lines, lists().to_string()).unwrap();
    let vtr = folder.path("spot.vtr");
    let report = report_of(&[
        "mesh",
        SPOT,
        "--lines",
        &lines,
        "--backend",
        "cpu",
        "--json",
        "-o",
        &mesh,
        "-o",
        &store,
        "-o",
        &raw,
        "-o",
        &vtr,
    ]);
    assert_eq!((&report["dims"], &report["spacing"]), (&json!([40, 50, 45]), &Value::Null));
    for axis in ["x", "y", "z"] {
        assert_eq!(report["grading"][axis], lists()[axis]);
        assert_eq!(folder.json("spot.raw.json")["lines"][axis], lists()[axis]);
        let meta: Value = serde_json::from_slice(&folder.bytes("spot.zarr/flag/zarr.json")).unwrap();
        assert_eq!(meta["attributes"]["lines"][axis], lists()[axis]);
    }
    done(&["convert", &mesh, &again]);
    assert!(folder.bytes("again.vtr") == folder.bytes("spot.vtr"));
    let info = report_of(&["info", &mesh, "--json"]);
    let info = if info.is_array() { info[0].clone() } else { info };
    assert_eq!(info["grading"]["y"], lists()["y"]);
    assert_eq!(info["flags"][0]["volume"], report["flags"][0]["volume"]);
    let text = done(&["info", &mesh]);
    assert!(text.contains(" to "), "{text}");
    let estimate = report_of(&["estimate", SPOT, "--lines", &lines, "--json"]);
    assert_eq!(estimate["grading"]["z"], lists()["z"]);
    let error = refused(&["convert", &mesh, &folder.path("spot.vti")]);
    assert!(error.contains("cells differ in size") && error.contains(".vtr"), "{error}");
    // the checker finds them right, and not those of another job
    done(&["verify", &mesh, SPOT, "--lines", &lines]);
    refused(&["verify", &mesh, SPOT, "--cells", "50"]);
}

#[test]
fn a_job_and_the_command_line_generate_the_same_lines() {
    let folder = Folder::new();
    let job = folder.path("job.toml");
    let file = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join(SPOT);
    let text = format!(
        "graded = {{ max_size = 0.2, min_size = 0.01, growth = 1.2, absorbing = 3 }}\n\
         [[geometries]]\nfile = \"{}\"\nmax_size = 0.05\nmin_cells = 30\n",
        file.display()
    );
    std::fs::write(&job, text).unwrap();
    let of_job = report_of(&["mesh", "--job", &job, "--backend", "cpu", "--json"]);
    let entry = format!("{SPOT}:max_size=0.05,min_cells=30");
    let of_arguments = report_of(&[
        "mesh",
        &entry,
        "--graded",
        "0.2",
        "--min-size",
        "0.01",
        "--growth",
        "1.2",
        "--absorbing",
        "3",
        "--backend",
        "cpu",
        "--json",
    ]);
    assert_eq!(of_job["dims"], of_arguments["dims"]);
    assert_eq!(of_job["flags_hash"], of_arguments["flags_hash"]);
    assert_eq!(of_job["grading"], of_arguments["grading"]);
    // a size on the command line takes the place of what the job says
    let uniform = report_of(&["mesh", "--job", &job, "--cells", "16", "--backend", "cpu", "--json"]);
    assert!(uniform["grading"].is_null() && uniform["spacing"].is_array());
}

#[test]
fn wrong_lists_and_contradictions_are_sentences() {
    let folder = Folder::new();
    let lines = folder.path("lines.json");
    for (text, part) in [
        ("{\"x\": [0, 1], \"y\": [0, 1]}", "lines.json: line 1, column 26: there is no key `z`"),
        ("[[0, 1], [0, 1], [0, 1]]", "not an object of three lists"),
        (
            "{\"x\": [0, \"a\"], \"y\": [0, 1], \"z\": [0, 1]}",
            "x[1]: line 1, column 13: it is the text \"a\"; give a number",
        ),
        ("{\"x\": [1, 2", "EOF"),
        ("{\"x\": [0, 1, 1], \"y\": [0, 1], \"z\": [0, 1]}", "lines.x[2] is 1.0"),
        ("{\"x\": [0], \"y\": [0, 1], \"z\": [0, 1]}", "lines.x has 1 lines"),
    ] {
        std::fs::write(&lines, text).unwrap();
        let error = refused(&["mesh", SPOT, "--lines", &lines]);
        assert!(error.contains(part), "{part} is not in {error}");
    }
    std::fs::write(&lines, lists().to_string()).unwrap();
    for arguments in [
        ["--lines", &lines, "--cells", "3"],
        ["--lines", &lines, "--domain", "0,0,0,1,1,1"],
        ["--lines", &lines, "--padding-cells", "2"],
        ["--graded", "1", "--padding-cells", "2"],
        ["--growth", "2", "--cells", "3"],
        ["--graded", "1", "--growth", "0.5"],
        ["--graded", "1", "--min-size", "2"],
    ] {
        let output = hexcast(&[&["mesh", SPOT], &arguments[..]].concat());
        assert!(matches!(output.status.code(), Some(2 | 4)), "{arguments:?}: {output:?}");
    }
}

#[test]
fn a_gpu_meshes_graded_lines_as_the_cpu_does() {
    let folder = Folder::new();
    let lines = folder.path("lines.json");
    std::fs::write(&lines, lists().to_string()).unwrap();
    let made = |backend: &str| report_of(&["mesh", SPOT, "--lines", &lines, "--backend", backend, "--json"]);
    let [cpu, gpu] = ["cpu", "gpu"].map(made);
    assert_eq!((&gpu["backend"], &cpu["adapter"]), (&json!("gpu"), &Value::Null));
    assert!(gpu["adapter"].is_string() && gpu["device_check"]["rays"].as_u64() > Some(0), "{gpu}");
    assert_eq!(gpu["device_check"]["differing"], json!(0));
    assert_eq!((&gpu["flags_hash"], &gpu["warnings"]), (&cpu["flags_hash"], &cpu["warnings"]));
}

/// A box as an ASCII solid, by name in a folder.
fn cuboid(folder: &Folder, name: &str, low: [f32; 3], high: [f32; 3]) -> String {
    let corner = |of: [f32; 3]| of.map(|at| at.to_string()).join(" ");
    let facets = super::models::cuboid(low, high).into_iter().map(|facet| {
        format!("facet normal 0 0 0\nouter loop\nvertex {}\nendloop\nendfacet\n", facet.map(corner).join("\nvertex "))
    });
    std::fs::write(folder.path(name), format!("solid\n{}endsolid\n", facets.collect::<String>())).unwrap();
    folder.path(name)
}

#[test]
fn what_no_line_can_meet_is_said_with_its_cause() {
    let folder = Folder::new();
    let body = cuboid(&folder, "body.stl", [0.0; 3], [10.0, 4.0, 1.0]);
    let error = refused(&["mesh", &format!("{body}:min_cells=100000"), "--graded", "2"]);
    let cause = "geometry \"body\" wants cells of at most 0.0001 along x, from 0 to 10: the smallest is 0.002";
    assert!(error.contains(cause) && error.contains("fewer min_cells"), "{error}");
    let error = refused(&["mesh", &format!("{body}:max_size=0.001"), "--graded", "2", "--min-size", "0.01"]);
    assert!(error.contains("wants cells of at most 0.001 along x, from 0 to 10: the smallest is 0.01"), "{error}");
    let help = done(&["mesh", "--help"]);
    assert!(["max_size", "min_cells", "metal", "eps_r"].iter().all(|key| help.contains(key)), "{help}");
}

#[test]
fn an_estimate_draws_lines_and_says_which_ends_have_none() {
    let folder = Folder::new();
    let body = cuboid(&folder, "body.stl", [0.0; 3], [10.0, 4.0, 1.0]);
    let near = cuboid(&folder, "near.stl", [3.0005, 1.0, 1.0], [6.0, 3.0, 2.5]);
    let plate = cuboid(&folder, "plate.stl", [3.0, 1.0, 0.5], [5.0, 2.5, 0.5]);
    let (mesh, svg) = ([&body, &format!("{near}:name=<near>"), &plate, "--graded", "1"], folder.path("lines.svg"));
    let estimate = report_of(&[&["estimate"], &mesh[..], &["--json", "-o", &svg]].concat());
    let meshed = report_of(&[&["mesh", "--backend", "cpu", "--json"], &mesh[..]].concat());
    assert_eq!(estimate["grading"], meshed["grading"]);
    let notice = "the end of \"<near>\" at x = 3.000499963760376 has no line of its own";
    for warnings in [&estimate["warnings"], &meshed["warnings"]] {
        assert!(warnings[0].as_str().is_some_and(|of| of.starts_with(notice)), "{warnings}");
    }
    let output = hexcast(&[&["estimate"], &mesh[..]].concat());
    let [text, said] = [output.stdout, output.stderr].map(|bytes| String::from_utf8_lossy(&bytes).into_owned());
    assert!(text.contains(".vtr about") && !text.contains(".vti"), "{text}");
    assert!(said.contains(notice), "{said}");
    // the drawing: a line for each of the mesh in two views, and a box for each geometry in three
    let drawn = String::from_utf8(folder.bytes("lines.svg")).unwrap();
    let n_lines = |axis: &str| estimate["grading"][axis].as_array().unwrap().len();
    let all = 2 * (n_lines("x") + n_lines("y") + n_lines("z"));
    let strokes: Vec<&str> = drawn.lines().filter(|line| line.contains("fill=\"none\"")).collect();
    assert_eq!((strokes.len(), strokes.concat().matches('M').count()), (3, all));
    assert_eq!(drawn.matches("fill-opacity").count(), 9);
    assert!(drawn.contains("2 &lt;near&gt;</text>") && !drawn.contains("<near>"), "{drawn}");
    // in the world's proportions: a unit is as long on both axes of the first view
    let ends = |stroke: &str, letter: char| {
        let places = stroke.split('M').skip(1).filter(|line| line.contains(letter));
        let along = |line: &str| {
            line.split(['V', 'H', '"', ' ']).map(|at| at.parse::<f64>().unwrap_or(0.0)).collect::<Vec<f64>>()
        };
        let all: Vec<f64> = places.map(|line| along(line)[usize::from(letter == 'H')]).collect();
        (all[0] - all[all.len() - 1]).abs()
    };
    assert!((ends(strokes[0], 'V') / ends(strokes[0], 'H') - 10.0 / 4.0).abs() < 1e-3, "{}", strokes[0]);
    for (arguments, words) in [
        (["estimate", &body, "--cells", "20", "-o", "lines.png"], "lines are drawn as .svg"),
        (["estimate", &body, "--cells", "10000", "-o", &svg], "10000 cells along x: lines are drawn of at most 9999"),
    ] {
        let error = refused(&arguments);
        assert!(error.contains(words), "{error}");
    }
}

#[test]
fn padding_goes_around_a_given_domain() {
    let folder = Folder::new();
    let body = cuboid(&folder, "body.stl", [0.0; 3], [10.0, 4.0, 1.0]);
    let mesh = |more: &[&str]| report_of(&[&["mesh", &body, "--backend", "cpu", "--json"], more].concat());
    let domain = ["--domain", "-1,0,0,9,5,2"];
    let by_cells = mesh(&[&domain[..], &["--cell-size", "0.5", "--padding-cells", "8,0,2"]].concat());
    assert_eq!((&by_cells["dims"], &by_cells["origin"]), (&json!([36, 10, 8]), &json!([-5.0, 0.0, -1.0])));
    let by_length = mesh(&[&domain[..], &["--cell-size", "0.5", "--padding-length", "1"]].concat());
    assert_eq!((&by_length["dims"], &by_length["origin"]), (&json!([24, 14, 8]), &json!([-2.0, -1.0, -1.0])));
    let graded = mesh(&[&domain[..], &["--graded", "0.7", "--padding-length", "3", "--absorbing", "2"]].concat());
    let lines = graded["grading"]["y"].as_array().unwrap();
    let ends = [&lines[2], &lines[lines.len() - 3]].map(|line| line.as_f64().unwrap());
    assert_eq!(ends, [-3.0, 8.0]);
    // a domain on the command line takes the place of the job's box, with its padding
    let job = folder.path("job.json");
    let of_job = json!({ "geometries": [{ "file": "body.stl" }], "cell_size": 0.5, "padding": { "cells": 3 }, "backend": "cpu" });
    std::fs::write(&job, of_job.to_string()).unwrap();
    let dims = |more: &[&str]| report_of(&[&["mesh", "--job", &job, "--json"], more].concat())["dims"].clone();
    assert_eq!(dims(&[]), json!([26, 14, 8]));
    assert_eq!(dims(&domain), json!([20, 10, 4]));
    assert_eq!(dims(&[&domain[..], &["--padding-cells", "1"]].concat()), json!([22, 12, 6]));
    let columns = folder.path("body.hxc");
    let job = [&body[..], "--cell-size", "0.5", "--domain", "-1,0,0,9,5,2", "--padding-length", "1,0,0.5"];
    done(&[&["mesh", "--backend", "cpu", "-q", "-o", &columns], &job[..]].concat());
    done(&[&["verify", &columns], &job[..]].concat());
}

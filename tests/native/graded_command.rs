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
    let error = refused(&["verify", &mesh, SPOT, "--lines", &lines]);
    assert!(error.contains("lines"), "{error}");
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
        ("{\"x\": [0, 1], \"y\": [0, 1]}", "there is no key `z`"),
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

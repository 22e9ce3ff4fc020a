//! `hexcast leak` as a user meets it: sentences, JSON, the VTK file, exit codes.

use hexcast::geometry::Facet;
use serde_json::Value;

use super::cli::{Folder, done, hexcast};
use super::findings::stl;
use super::models::{cuboid, flipped, joined};

/// Writes a binary STL.
fn write_stl(path: &str, facets: &[Facet]) {
    std::fs::write(path, stl(facets)).expect("the folder is there");
}

/// A casing of 10^3 cells of 1 mm, walls of 1 cell, in a box with 2 cells around it; with a hole of 2 x 1 cells in the wall
/// of high z, if asked for.
fn casing(folder: &Folder, has_hole: bool) -> [String; 2] {
    let [stl, hole, mesh] = ["case.stl", "hole.stl", "case.hxc"].map(|name| folder.path(name));
    write_stl(&stl, &joined([cuboid([0.0; 3], [10.0; 3]), flipped(cuboid([1.0; 3], [9.0; 3]))]));
    let mut arguments = vec!["mesh", &stl];
    let drilled = format!("{hole}:flag=2");
    if has_hole {
        write_stl(&hole, &cuboid([4.0, 6.0, 8.5], [6.0, 7.0, 10.0]));
        arguments.push(&drilled);
    }
    arguments.extend([
        "--cell-size",
        "1",
        "--padding-cells",
        "2",
        "--unit",
        "mm",
        "--backend",
        "cpu",
        "-q",
        "-o",
        &mesh,
    ]);
    done(&arguments);
    [mesh, stl]
}

/// Runs `hexcast leak` with a code that it must have, and returns what it printed.
#[track_caller]
fn leak(code: i32, arguments: &[&str]) -> String {
    let output = hexcast(&[&["leak"], arguments].concat());
    let error = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{arguments:?}: {error}");
    if code == 0 || code == 9 {
        assert_eq!(error, "", "{arguments:?}");
        return String::from_utf8(output.stdout).expect("UTF-8");
    }
    error.into()
}

const ENDS: [&str; 4] = ["--from", "5,5,5", "--to", "-1,-1,-1"];

#[test]
fn a_tight_casing_is_said_to_be_tight() {
    let folder = Folder::new();
    let [mesh, stl] = casing(&folder, false);
    let path = folder.path("path.vtp");
    let text = leak(0, &[&[&*mesh, "--surface", &stl, "-o", &path], &ENDS[..]].concat());
    assert!(
        text.starts_with("tight       no path through flag 0 leads from cell (7, 7, 7) to cell (1, 1, 1)\n"),
        "{text}"
    );
    assert!(text.contains("reached     512 cells from the start, 1,744 from the end\n"), "{text}");
    // a file without lines, so that none of an earlier run stays
    let written = String::from_utf8(folder.bytes("path.vtp")).unwrap();
    assert!(written.contains("NumberOfPoints=\"0\" NumberOfVerts=\"0\" NumberOfLines=\"0\""), "{written}");
    let json: Value = serde_json::from_str(&leak(0, &[&[&*mesh, "--json"], &ENDS[..]].concat())).unwrap();
    assert_eq!((&json["is_tight"], &json["path"], &json["facets"]), (&true.into(), &Value::Null, &Value::Null));
}

#[test]
fn a_hole_is_found_with_its_facets() {
    let folder = Folder::new();
    let [mesh, stl] = casing(&folder, true);
    let arguments = [&[&*mesh, "--flags", "0,2"], &ENDS[..]].concat();
    let text = leak(9, &arguments);
    for part in [
        "leak        a path through flags 0, 2 leads from cell (7, 7, 7) to cell (1, 1, 1)\n",
        "shortest    30 steps from cell to cell, length 30 mm\n",
        "reached     2,258 cells from both\n",
        "widest      a cube of 1 cell passes, 1 mm wide; none of 2 cells does\n",
    ] {
        assert!(text.contains(part), "{part}\n{text}");
    }
    // the wall is one cell thick, and the hole two cells wide along x
    let is_there = |x: f64| text.contains(&format!("narrowest   at ({x}, 6.5, 9.5) mm: cells"));
    assert!(is_there(4.5) || is_there(5.5), "{text}");
    let hole = folder.path("hole.stl");
    let surface = [&arguments[..], &["--surface", &stl, "--surface", &hole, "--json"]].concat();
    let json: Value = serde_json::from_str(&leak(9, &surface)).unwrap();
    assert_eq!((&json["unit"], &json["narrowest"]["width"]), (&"mm".into(), &1.into()));
    let facets = json["facets"].as_array().unwrap();
    // of the casing the two facets of the top, outside and inside, or the one of each that is near
    let near = |name: &str| {
        facets
            .iter()
            .filter(|near| near["geometry"] == name)
            .map(|near| near["facet"].as_u64().unwrap())
            .collect::<Vec<u64>>()
    };
    let of_case = near("case");
    assert!(!of_case.is_empty() && of_case.iter().all(|facet| [10, 11, 22, 23].contains(facet)), "{json}");
    assert!(near("hole").len() >= 8, "{json}");
    // without the flag of the hole the casing is tight
    leak(0, &[&[&*mesh], &ENDS[..]].concat());
}

#[test]
fn the_vtk_file_has_the_paths_as_lines() {
    let folder = Folder::new();
    let [mesh, _] = casing(&folder, true);
    let path = folder.path("path.vtp");
    let text = leak(9, &[&[&*mesh, "--flags", "0,2", "-o", &path], &ENDS[..]].concat());
    assert!(text.contains("path.vtp ("), "{text}");
    let written = String::from_utf8(folder.bytes("path.vtp")).unwrap();
    let numbers = |name: &str| -> Vec<Vec<f64>> {
        let arrays = written.split("<DataArray ").skip(1).filter(|array| array.contains(&format!("Name=\"{name}\"")));
        let list = |array: &str| {
            let (_, rest) = array.split_once('>').unwrap();
            let (list, _) = rest.split_once('<').unwrap();
            list.split_whitespace().map(|number| number.parse().unwrap()).collect()
        };
        arrays.map(list).collect()
    };
    assert_eq!(numbers("part"), [[0.0, 1.0, 2.0]]);
    let points = numbers("points").concat();
    let n_points = points.len() / 3;
    let [vertices, lines] = [&numbers("connectivity")[0], &numbers("connectivity")[1]];
    assert_eq!(*vertices, [0.0]);
    assert_eq!(*lines, (1..n_points).map(|point| point as f64).collect::<Vec<f64>>());
    let ends = &numbers("offsets")[1];
    assert_eq!((ends.len(), ends[1] as usize), (2, n_points - 1));
    let point = |index: usize| points[3 * index..3 * index + 3].to_vec();
    assert_eq!([point(1), point(ends[0] as usize)], [[5.5; 3], [-0.5; 3]]);
    assert!(
        written.contains(&format!("NumberOfPoints=\"{n_points}\" NumberOfVerts=\"1\" NumberOfLines=\"2\"")),
        "{written}"
    );
}

#[test]
fn wrong_questions_say_what_to_do() {
    let folder = Folder::new();
    let [mesh, stl] = casing(&folder, false);
    let vtk = folder.path("path.vtk");
    let (from, job) = (&ENDS[..2], folder.path("no.toml"));
    let cases: &[(&[&str], i32, &str)] = &[
        (&[&mesh, "--to", "0,0,13"], 4, "the end (0, 0, 13) lies outside of the mesh, which reaches from (-2, -2, -2)"),
        (&[&mesh, "--to", "0.5,5,5"], 4, "is in cell (2, 7, 7) of flag 1"),
        (&[&mesh, "--to", "1,1"], 2, "3 numbers"),
        (&[&mesh], 2, "--to"),
        (&[&mesh, "--to", "1,1,1", "--flags", "256"], 2, "256"),
        (&[&mesh, "--to", "1,1,1", "-o", &vtk], 4, "paths are written to .vtp only"),
        (&[&mesh, "--to", "1,1,1", "--job", &job], 7, "there is no such file"),
        (&[&mesh, "--to", "1,1,1", "--job", &job, "--surface", &stl], 2, "cannot be used with"),
        (&[&mesh, "--to", "1,1,1", "--max-memory", "1000"], 5, "bytes"),
        (&["no-such.hxc", "--to", "1,1,1"], 7, "there is no such file"),
        (&[&stl, "--to", "1,1,1"], 3, "case.stl is not a column file\nhint: mesh it first"),
    ];
    for (arguments, code, part) in cases {
        let error = leak(*code, &[arguments, from].concat());
        assert!(error.contains(part), "{arguments:?}: {error}");
        assert!(*code == 2 || error.contains("\nhint: "), "{arguments:?}: {error}");
    }
    assert_eq!(folder.names(), ["case.hxc", "case.stl"]);
}

/// A casing with a hole of 3 x 2 cells in the wall of high z, cut with the flag 9.
fn casing_to_close(folder: &Folder) -> [String; 2] {
    let [stl, outside] = ["case.stl", "outside.stl"].map(|name| folder.path(name));
    // the wall of high z in four parts around the hole
    let parts = [
        cuboid([0.0, 0.0, 9.0], [4.0, 10.0, 10.0]),
        cuboid([7.0, 0.0, 9.0], [10.0, 10.0, 10.0]),
        cuboid([4.0, 0.0, 9.0], [7.0, 6.0, 10.0]),
        cuboid([4.0, 8.0, 9.0], [7.0, 10.0, 10.0]),
    ];
    let tub = joined([cuboid([0.0; 3], [10.0, 10.0, 9.0]), flipped(cuboid([1.0; 3], [9.0, 9.0, 9.0]))]);
    write_stl(&stl, &tub);
    write_stl(&outside, &parts.concat());
    [stl, outside]
}

#[test]
fn cpu_and_gpu_close_the_same_gaps_along_any_axis() {
    let folder = Folder::new();
    let [case, lid] = casing_to_close(&folder);
    let mesh = folder.path("case.hxc");
    let common = ["mesh", &case, &lid, "--cell-size", "1", "--padding-cells", "2", "-o", &mesh, "--json"];
    let made = |options: &[&str]| -> Value { serde_json::from_str(&done(&[&common[..], options].concat())).unwrap() };
    let leaks = || hexcast(&["leak", &mesh, ENDS[0], ENDS[1], ENDS[2], ENDS[3]]).status.code();
    let plain = made(&["--backend", "cpu"]);
    assert_eq!((&plain["gaps"], leaks()), (&Value::Null, Some(9)));
    // the hole is two cells wide
    let kept = made(&["--backend", "cpu", "--close-gaps", "2"]);
    assert_eq!((&kept["gaps"]["cells"], &kept["flags_hash"]), (&0.into(), &plain["flags_hash"]));
    let of = |axis: &str, backend: &str| made(&["--backend", backend, "--axis", axis, "--close-gaps", "3"]);
    let closed = of("x", "cpu");
    assert_eq!(leaks(), Some(0));
    let gap = serde_json::json!({"cells": 6, "bounds": [[4.0, 6.0, 9.0], [7.0, 8.0, 10.0]]});
    let gaps = serde_json::json!({"width": 3, "flag": 3, "cells": 6, "gaps": 1, "largest": [gap]});
    assert_eq!(closed["gaps"], gaps);
    assert_eq!((&closed["flags"][2]["name"], &closed["flags"][2]["cells"]), (&"closed gaps".into(), &6.into()));
    for (axis, backend) in [("y", "cpu"), ("z", "cpu"), ("z", "gpu")] {
        let other = of(axis, backend);
        assert_eq!((&other["flags_hash"], &other["gaps"]), (&closed["flags_hash"], &gaps), "{axis}, {backend}");
    }
    let joined = made(&["--backend", "cpu", "--close-gaps", "3", "--gap-flag", "2"]);
    assert_eq!((&joined["gaps"]["flag"], joined["flags"].as_array().unwrap().len()), (&2.into(), 2));
    let text = done(&[
        "mesh",
        &case,
        &lid,
        "--cell-size",
        "1",
        "--padding-cells",
        "2",
        "--backend",
        "cpu",
        "--close-gaps",
        "3",
    ]);
    for part in [
        "flag        1 \"case\"",
        "            3 \"closed gaps\": 6 cells, volume 6\n",
        "gaps        1 narrower than 3 cells closed, 6 cells got flag 3\n            6 cells from (4, 6, 9) to (7, 8, 10)\n",
    ] {
        assert!(text.contains(part), "{part}\n{text}");
    }
}

#[test]
fn wrong_widths_and_flags_of_gaps_are_errors() {
    let folder = Folder::new();
    let [case, _] = casing_to_close(&folder);
    let raw = folder.path("case.raw");
    let cases: &[(&[&str], &str)] = &[
        (&["--close-gaps", "1"], "close_gaps is 1; allowed: at least 2"),
        (&["--gap-flag", "3"], "gap_flag is given without close_gaps"),
        (&["--close-gaps", "3", "--bits", "-o", &raw], "closed gaps get a flag of their own\nhint: add --gap-flag 1"),
    ];
    for (options, part) in cases {
        let output = hexcast(&[&["mesh", &case, "--backend", "cpu"], *options].concat());
        let error = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(4), "{options:?}: {error}");
        assert!(error.contains(part), "{options:?}: {error}");
    }
    let output = hexcast(&["mesh", &case, "--close-gaps", "3", "--gap-flag", "0"]);
    let error = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{error}");
    assert!(error.contains("'--gap-flag <F>': it is 0, and at least 1 is needed"), "{error}");
}

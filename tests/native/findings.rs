//! Findings as data: every code is documented and known to the types, remedies help, and the option of each does what its patch does.

use hexcast::finding::CODES;
use hexcast::geometry::Facet;
use serde_json::{Value, json};

use super::cli::{Folder, done, hexcast};
use super::models::{cuboid, joined, moved, tetrahedron};

fn read(name: &str) -> String {
    let path = format!("{}/{name}", env!("CARGO_MANIFEST_DIR"));
    std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{path}: {error}"))
}

#[test]
fn every_code_is_listed_once_documented_and_known_to_the_types_and_no_other_is() {
    let of_rust: Vec<&str> = CODES.iter().map(|(code, ..)| *code).collect();
    for (index, code) in of_rust.iter().enumerate() {
        assert!(!of_rust[..index].contains(code), "{code} is listed twice");
    }
    let types = read("www/types/report.d.ts");
    let union = types.split("export type FindingCode =").nth(1).and_then(|rest| rest.split(';').next());
    let of_types: Vec<&str> = union.expect("the type").split('\'').skip(1).step_by(2).collect();
    assert_eq!(of_types, of_rust);
    let document = read("docs/findings.md");
    let table = document.split("## Codes").nth(1).expect("the table");
    let rows: Vec<Vec<&str>> =
        table.lines().filter(|line| line.starts_with("| `")).map(|row| row.split('|').collect()).collect();
    let documented: Vec<(&str, &str)> =
        rows.iter().map(|cells| (cells[1].trim().trim_matches('`'), cells[2].trim())).collect();
    let expected: Vec<(&str, &str)> = CODES.iter().map(|(code, _, meaning)| (*code, *meaning)).collect();
    assert_eq!(documented, expected);
}

/// A binary STL.
pub(super) fn stl(facets: &[Facet]) -> Vec<u8> {
    let mut bytes = vec![0; 80];
    bytes.extend((facets.len() as u32).to_le_bytes());
    for facet in facets {
        bytes.extend([0; 12]);
        facet.as_flattened().iter().for_each(|number| bytes.extend(number.to_le_bytes()));
        bytes.extend([0; 2]);
    }
    bytes
}

/// Files of bodies in a room of 8 x 8 x 8 that have what findings speak of.
fn folder() -> Folder {
    let folder = Folder::new();
    let corner = |x: f32, y: f32| [x, y, 3.0];
    let sheet = vec![
        [corner(1.0, 1.0), corner(7.0, 1.0), corner(7.0, 7.0)],
        [corner(1.0, 1.0), corner(7.0, 7.0), corner(1.0, 7.0)],
    ];
    let mut open = cuboid([0.0; 3], [4.0; 3]);
    open.pop();
    let files = [
        ("room.stl", cuboid([0.0; 3], [8.0; 3])),
        ("plate.stl", cuboid([1.0, 1.0, 2.75], [7.0, 7.0, 3.25])),
        ("sheet.stl", sheet),
        // holds the box around a centre, and not the centre
        ("corner.stl", moved(&tetrahedron([[0.0; 3], [0.2, 0.0, 0.0], [0.0, 0.2, 0.0], [0.0, 0.0, 0.2]]), [3.4; 3])),
        ("block.stl", cuboid([1.0; 3], [5.0; 3])),
        ("two.stl", joined([cuboid([1.0; 3], [5.0; 3]), cuboid([2.0; 3], [7.0; 3])])),
        ("open.stl", open),
        ("odd.stl", cuboid([2.37, 0.0, 0.0], [8.0; 3])),
        // of the second there is no cell where a cell is 1 long, and one in every second of half of that
        ("parts.stl", joined([cuboid([1.0; 3], [3.0; 3]), cuboid([4.6, 4.0, 4.0], [4.9, 6.0, 6.0])])),
        ("near.stl", cuboid([0.0; 3], [7.9, 3.0, 3.0])),
    ];
    files.iter().for_each(|(name, facets)| std::fs::write(folder.path(name), stl(facets)).expect("a file"));
    folder
}

/// Changes a job as the documentation says.
fn patched(mut job: Value, patch: &Value) -> Value {
    for (key, change) in patch.as_object().expect("a patch") {
        match (key.as_str(), change) {
            ("geometries", Value::Object(entries)) => {
                for (index, settings) in entries {
                    let index: usize = index.parse().expect("an index");
                    let settings = settings.as_object().expect("settings").iter();
                    settings.for_each(|(key, value)| job["geometries"][index][key] = value.clone());
                }
            }
            (_, Value::Object(keys)) => keys.iter().for_each(|(inner, value)| job[key][inner] = value.clone()),
            _ => job[key] = change.clone(),
        }
    }
    job
}

/// Meshes, and returns the report and what was printed to standard error.
#[track_caller]
fn meshed(arguments: &[String]) -> (Value, String) {
    let fixed = ["mesh", "--json", "--backend", "cpu"].map(String::from);
    let all: Vec<&str> = fixed.iter().chain(arguments).map(String::as_str).collect();
    let output = hexcast(&all);
    let error = String::from_utf8(output.stderr).expect("UTF-8");
    assert!(output.status.success(), "{all:?}: {error}");
    (serde_json::from_slice(&output.stdout).expect("JSON"), error)
}

/// The finding of a code, of which there must be one.
#[track_caller]
fn only<'a>(report: &'a Value, code: &str) -> &'a Value {
    let findings = report["findings"].as_array().expect("a list");
    let of_code: Vec<&Value> = findings.iter().filter(|finding| finding["code"] == code).collect();
    let [found] = of_code[..] else { panic!("{code}: {findings:#?}") };
    found
}

/// The code, the arguments, the index of the geometry, and the option that helps, with names of files without their folder.
const CASES: &[(&str, &[&str], Option<u64>, &str)] = &[
    ("no-cell-thin", &["room.stl", "plate.stl"], Some(1), "plate.stl:fill=separating"),
    // what comes later would have its cells
    ("no-cell-thin", &["plate.stl", "room.stl"], Some(0), "plate.stl:fill=separating,priority=1"),
    ("no-cell-thin", &["room.stl", "plate.stl:fill=centre"], Some(1), "plate.stl:fill=separating"),
    ("no-cell-flat", &["room.stl", "sheet.stl"], Some(1), "sheet.stl:fill=separating"),
    ("no-cell-small", &["room.stl", "corner.stl"], Some(1), "corner.stl:fill=separating"),
    (
        "no-cell-covered",
        &["plate.stl:flag=3,fill=separating", "block.stl", "room.stl"],
        Some(1),
        "block.stl:priority=1",
    ),
    ("plate-covered", &["sheet.stl", "room.stl"], Some(0), "sheet.stl:priority=1"),
    ("shell-lost", &["room.stl", "parts.stl"], Some(1), "--dims 16,16,16"),
    ("flag-shared", &["room.stl:flag=2", "block.stl"], Some(1), "block.stl:flag=1"),
    ("shells-overlap", &["room.stl", "two.stl"], Some(1), "--rule nonzero"),
    ("surface-open-parity", &["open.stl", "--open", "parity"], Some(0), "--open winding"),
    ("surface-open-parity", &["open.stl:open=parity"], Some(0), "open.stl:open=winding"),
    ("wall-thin", &["room.stl", "plate.stl", "--certify", "--thin-cells", "1"], Some(1), "plate.stl:fill=separating"),
    ("end-without-line", &["near.stl:max_size=2", "--graded", "2", "--min-size", "0.5"], Some(0), "--min-size 0.0999"),
];

#[test]
fn a_remedy_helps_and_its_option_does_what_its_patch_does() {
    let folder = folder();
    let in_folder =
        |argument: &str| if argument.contains(".stl") { folder.path(argument) } else { argument.to_string() };
    for (code, arguments, geometry, option) in CASES {
        let is_graded = arguments.contains(&"--graded");
        let mut given: Vec<String> = arguments.iter().map(|argument| in_folder(argument)).collect();
        given.extend(["--domain", "0,0,0,8,8,8"].map(String::from));
        given.extend(if is_graded { vec![] } else { ["--dims", "8,8,8"].map(String::from).to_vec() });
        let (report, printed) = meshed(&given);
        let found = only(&report, code);
        assert_eq!(found["geometry"]["index"].as_u64(), *geometry, "{found:#}");
        let name = found["geometry"]["index"].as_u64().map(|index| &report["geometries"][index as usize]["name"]);
        assert_eq!(name, geometry.map(|_| &found["geometry"]["name"]));
        assert!(printed.contains(&format!("warning: {}", found["sentence"].as_str().expect("text"))), "{printed}");
        let remedy = &found["remedies"][0];
        let wanted = in_folder(option);
        assert!(remedy["option"].as_str().is_some_and(|option| option.starts_with(&wanted)), "{remedy:#}");
        let wanted = remedy["option"].as_str().expect("an option").to_string();
        assert!(printed.contains(&format!(" with {wanted}\n")), "{printed}");
        // the option on the command line: a file with settings stands in place of that file
        let mut changed = given.clone();
        match wanted.split_once(' ') {
            Some((option, value)) => {
                let old = changed.iter().position(|argument| argument == option);
                old.into_iter().for_each(|at| drop(changed.drain(at..at + 2)));
                changed.extend([option.to_string(), value.to_string()]);
            }
            None => {
                let file = wanted.split(".stl").next().expect("a file");
                let at = changed.iter().position(|argument| argument.starts_with(file)).expect("the file");
                changed[at] = wanted.clone();
            }
        }
        let (by_option, _) = meshed(&changed);
        assert_helped(&by_option, found);
        // the patch, of the job as it was given and as the report has it
        let job_file = folder.path("job.json");
        let dump = ["mesh", "--backend", "cpu", "--dump-job", &job_file];
        done(&[&dump[..], &given.iter().map(String::as_str).collect::<Vec<_>>()[..]].concat());
        for job in [folder.json("job.json"), report["job"].clone()] {
            std::fs::write(&job_file, patched(job, &remedy["patch"]).to_string()).expect("a file");
            let (by_patch, _) = meshed(&["--job".into(), job_file.clone()]);
            assert_helped(&by_patch, found);
            assert_eq!(by_patch["flags_hash"], by_option["flags_hash"], "{code} {wanted}");
        }
    }
}

/// No geometry has the finding of another report any more.
#[track_caller]
fn assert_helped(report: &Value, found: &Value) {
    let findings = report["findings"].as_array().expect("a list");
    let has_no_cell = |code: &Value| code.as_str().is_some_and(|code| code.starts_with("no-cell"));
    let is_same = |code: &Value| *code == found["code"] || has_no_cell(code) && has_no_cell(&found["code"]);
    let is_left = findings.iter().any(|other| is_same(&other["code"]) && other["geometry"] == found["geometry"]);
    // a filled wall is as thin as it was, and is kept
    let is_left = is_left && found["code"] != "wall-thin";
    assert!(!is_left, "{findings:#?}");
}

#[test]
fn findings_have_places_and_values_and_warnings_are_their_sentences() {
    let folder = folder();
    let path = |name: &str| folder.path(name);
    let size = ["--domain", "0,0,0,8,8,8", "--dims", "8,8,8"].map(String::from);
    let (report, _) = meshed(&[&[path("room.stl"), path("plate.stl"), path("open.stl")], &size[..]].concat());
    let thin = only(&report, "no-cell-thin");
    assert_eq!(thin["flag"], 2);
    assert_eq!(thin["axis"], "z");
    assert_eq!(thin["boxes"], json!([[[1.0, 1.0, 2.75], [7.0, 7.0, 3.25]]]));
    assert_eq!(thin["values"], json!({ "thickness": 0.5, "cell_size": 1.0 }));
    let open = only(&report, "surface-open");
    assert_eq!((&open["values"]["open_edges"], &open["values"]["cells"]), (&json!(3), &json!(512)));
    assert_eq!(open["points"], json!([report["open"][0]["longest_at"]]));
    let sentences: Vec<&Value> = report["findings"].as_array().unwrap().iter().map(|of| &of["sentence"]).collect();
    assert_eq!(report["warnings"].as_array().unwrap().iter().collect::<Vec<_>>(), sentences);
    // who has the cells of another
    let (report, _) = meshed(&[&[path("block.stl"), path("room.stl")], &size[..]].concat());
    assert_eq!(only(&report, "no-cell-covered")["other"], json!({ "index": 1, "name": "room" }));
}

#[test]
fn a_file_in_another_unit_is_scaled_by_the_remedy() {
    let scene = "tests/fixtures/scene.glb";
    let arguments = [scene, "--unit", "mm", "--cells", "16", "--quick"].map(String::from);
    let (report, _) = meshed(&arguments);
    let remedy = &only(&report, "unit-differs")["remedies"][0];
    assert_eq!(remedy["option"], "tests/fixtures/scene.glb:scale=1000.0");
    assert_eq!(remedy["patch"], json!({ "geometries": { "0": { "scale": 1000.0 } } }));
    let scaled =
        ["tests/fixtures/scene.glb:scale=1000.0", "--unit", "mm", "--cells", "16", "--quick"].map(String::from);
    let (report, _) = meshed(&scaled);
    assert_eq!(report["findings"], json!([]));
}

#[test]
fn a_larger_tolerance_helps_against_fine_cells() {
    let folder = folder();
    let files = ["room.stl", "odd.stl"].map(|name| folder.path(name));
    let given = [&files[..], &["--max-cell-size", "1", "--tolerance", "0.01"].map(String::from)].concat();
    let (report, _) = meshed(&given);
    let fine: Vec<&Value> =
        report["findings"].as_array().unwrap().iter().filter(|of| of["code"] == "cells-fine").collect();
    assert!(!fine.is_empty() && fine.iter().all(|of| of["values"]["max_cell_size"] == 1.0), "{fine:#?}");
    let (found, remedy) = fine.iter().find_map(|of| Some((of, of["remedies"].get(0)?))).expect("a remedy");
    let option: Vec<&str> = remedy["option"].as_str().unwrap().split(' ').collect();
    assert_eq!((option[0], &remedy["patch"]), ("--tolerance", &json!({ "tolerance": found["values"]["tolerance"] })));
    let (report, _) = meshed(&[&given[..4], &option.iter().map(|of| of.to_string()).collect::<Vec<_>>()[..]].concat());
    let axis = ["x", "y", "z"].iter().position(|axis| found["axis"] == *axis).unwrap();
    let (size, cheaper) = (&report["spacing"][axis], &found["values"]["cheaper_cell_size"]);
    assert!((size.as_f64().unwrap() - cheaper.as_f64().unwrap()).abs() < 1e-9, "{size} {cheaper}");
}

#[test]
fn a_file_with_a_name_that_a_shell_would_split_is_quoted() {
    let folder = folder();
    let name = folder.path("a plate.stl");
    std::fs::copy(folder.path("plate.stl"), &name).expect("a copy");
    let size = ["--domain", "0,0,0,8,8,8", "--dims", "8,8,8"].map(String::from);
    let (report, _) = meshed(&[&[folder.path("room.stl"), format!("{name}:fill=centre")], &size[..]].concat());
    assert_eq!(only(&report, "no-cell-thin")["remedies"][0]["option"], format!("'{name}:fill=separating'"));
}

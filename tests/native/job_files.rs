//! The job file with the options of the command line, and the file that `--dump-job` writes.

use serde_json::Value;

use super::cli::{Folder, SPOT, done, hexcast, json};

fn spot() -> String {
    std::path::absolute(SPOT).expect("a path").to_str().expect("UTF-8").to_string()
}

#[test]
fn outputs_and_report_of_a_job_file_are_beside_it_and_options_override_them() {
    let folder = Folder::new();
    std::fs::create_dir(folder.path("jobs")).expect("a folder");
    let text = format!(
        "output = [\"a.npy\", \"a.raw\"]\nreport = \"a.json\"\ncompress = \"none\"\nquiet = true\nthreads = 2\n\
         cells = 12\nbackend = \"cpu\"\n[[geometries]]\nfile = '{}'\n",
        spot()
    );
    let job = folder.path("jobs/job.toml");
    std::fs::write(&job, text).expect("written");
    assert_eq!(done(&["mesh", "--job", &job]), "");
    let report: Value = folder.json("jobs/a.json");
    let other = folder.path("other.npy");
    done(&["mesh", "--job", &job, "-o", &other, "--report", &folder.path("other.json")]);
    assert!(folder.bytes("other.npy") == folder.bytes("jobs/a.npy"));
    assert_eq!(folder.names(), ["jobs", "other.json", "other.npy"]);
    assert_eq!(folder.json("other.json")["flags_hash"], report["flags_hash"]);
    // a command that writes nothing takes the same file
    assert_eq!(json(&["estimate", "--job", &job, "--json"])["dims"], report["dims"]);
}

#[test]
fn what_is_dumped_makes_the_same_bytes() {
    let folder = Folder::new();
    let [first, toml, json, second] = ["first.npy", "job.toml", "job.json", "second.npy"].map(|name| folder.path(name));
    let file = format!("{SPOT}:flag=7,rotate=0/0/30,fill=separating,name=cow");
    let arguments = [
        "mesh",
        &file,
        "--cells",
        "14",
        "--backend",
        "cpu",
        "--padding-cells",
        "2",
        "--unit",
        "mm",
        "--axis",
        "z",
        "-q",
        "--bits",
    ];
    done(&[&arguments[..], &["-o", &first]].concat());
    for dumped in [&toml, &json] {
        // nothing is meshed
        done(&[&arguments[..], &["-o", &second, "--dump-job", dumped]].concat());
        assert!(!std::path::Path::new(&second).exists());
        done(&["mesh", "--job", dumped]);
        assert!(folder.bytes("second.npy") == folder.bytes("first.npy"), "{dumped}");
        std::fs::remove_file(&second).expect("removed");
        let again = folder.path("again.toml");
        done(&["mesh", "--job", dumped, "--dump-job", &again]);
        done(&["mesh", "--job", &toml, "--dump-job", &folder.path("once.toml")]);
        assert!(folder.bytes("again.toml") == folder.bytes("once.toml"), "{dumped}");
    }
    let printed = done(&["mesh", SPOT, "--cells", "8", "--dump-job", "-"]);
    assert!(printed.contains("cells = 8") && !printed.contains("max_memory"), "{printed}");
}

#[test]
fn padding_of_the_command_line_goes_around_the_domain_of_a_job() {
    let folder = Folder::new();
    let job = folder.path("job.toml");
    let spot = std::path::absolute(super::cli::SPOT).expect("a path");
    let geometry = format!("[[geometries]]\nfile = '{}'\n", spot.display());
    let mesh = ["mesh", "--job", &job, "--backend", "cpu", "-q", "-o"];
    for (key, option) in [
        ("padding = { cells = 2 }", ["--padding-cells", "2"]),
        ("padding = { length = 0.5 }", ["--padding-length", "0.5"]),
    ] {
        let [one, other] = ["one.hxc", "other.hxc"].map(|name| folder.path(name));
        std::fs::write(&job, format!("cells = 8\ndomain = [-1, -1, -1, 7, 5, 3]\n{key}\n{geometry}")).expect("written");
        done(&[&mesh[..], &[&one]].concat());
        std::fs::write(&job, format!("cells = 8\ndomain = [-1, -1, -1, 7, 5, 3]\n{geometry}")).expect("written");
        done(&[&mesh[..], &[&other], &option[..]].concat());
        assert!(folder.bytes("one.hxc") == folder.bytes("other.hxc"), "{key}");
    }
}

#[test]
fn an_option_overrides_a_bad_value_and_errors_are_in_words() {
    let folder = Folder::new();
    let job = folder.path("job.toml");
    let write =
        |line: &str| std::fs::write(&job, format!("{line}\n[[geometries]]\nfile = '{}'\n", spot())).expect("written");
    write("cells = 0");
    let mesh = ["mesh", "--job", &job, "--backend", "cpu"];
    assert_eq!(hexcast(&mesh).status.code(), Some(4));
    done(&[&mesh[..], &["--cells", "8"]].concat());
    // also one of another kind, or a word that there is not
    let overridden: [(&str, &[&str]); 9] = [
        ("cells = \"many\"", &["--cells", "8"]),
        ("cells = -5", &["--dims", "3,4,5"]),
        ("dims = [1, 2]\ntolerance = \"x\"", &["--cells", "8"]),
        ("cells = 8\nrule = \"odd\"", &["--rule", "parity"]),
        ("cells = 8\npadding = 3", &["--padding-cells", "2"]),
        ("cells = 8\nmax_memory = \"much\"", &["--max-memory", "1GB"]),
        ("cells = 8\nthreads = 5000", &["--threads", "2"]),
        ("cells = 8\nreport = 3", &["--report", "-"]),
        ("cells = 8\nslice = { output = \"a.png\", axis = \"w\" }", &["--slice", &folder.path("b.png")]),
    ];
    for (line, options) in overridden {
        write(line);
        let refused = hexcast(&mesh).status.code();
        assert!(matches!(refused, Some(2 | 4)), "{line}: {refused:?}");
        done(&[&mesh[..], options].concat());
    }
    for (line, expected) in [
        ("padding = 3", "padding: "),
        ("padding = 3", "give { cells = N } or { length = L }"),
        ("report = 3", "report: "),
        ("compress = true", "1 to 9 or \"none\" is needed"),
        ("compress = 11", "1 to 9 or none is needed"),
        ("threads = 5000", "1 to 1024 is needed"),
        ("cels = 3", "there is no key `cels`; keys are `geometries`"),
        ("otput = 3", ", `background`, `output`, `format`, `report`"),
    ] {
        write(line);
        let output = hexcast(&mesh);
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(matches!(output.status.code(), Some(2 | 4)) && said.contains(expected), "{line}: {said}");
    }
}

#[test]
fn an_option_leaves_keys_of_the_file_that_it_does_not_replace() {
    let folder = Folder::new();
    let [job, lines] = ["job.toml", "lines.json"].map(|name| folder.path(name));
    let write =
        |text: &str| std::fs::write(&job, format!("{text}\n[[geometries]]\nfile = '{}'\n", spot())).expect("written");
    // of another name than the key, it asks for what the key gives
    write("cells = 96\nzarr = { chunks = [8, 8, 8], shards = [16, 16, 16] }");
    let parts = done(&["parts", "--job", &job, "--zarr", "--n", "3"]);
    assert_eq!(parts, done(&["parts", "--job", &job, "--n", "3"]));
    // shards of their own are larger than the mesh
    write("cells = 96");
    assert!(!hexcast(&["parts", "--job", &job, "--zarr", "--n", "3"]).status.success());
    // lines are the domain, so that they replace that of the file, and its padding
    std::fs::write(&lines, r#"{"x": [-1, 0, 1], "y": [-1, 0, 2], "z": [-1, 0.5, 1]}"#).expect("written");
    write("cells = 8\ndomain = [-1, -1, -1, 7, 5, 3]\npadding = { cells = 2 }");
    let report = json(&["mesh", "--job", &job, "--lines", &lines, "--backend", "cpu", "--json"]);
    assert_eq!(report["dims"], serde_json::json!([2, 2, 2]));
}

#[test]
fn the_example_and_the_schema_are_printed() {
    let example = done(&["job", "example"]);
    assert!(example.contains("output = [\"part.vti\"") && example.contains("#dims = "));
    let schema: Value = serde_json::from_str(&done(&["job", "schema"])).expect("JSON");
    let validator = jsonschema::validator_for(&schema).expect("a schema");
    let folder = Folder::new();
    done(&["mesh", SPOT, "--cells", "8", "-o", "a.npy", "--dump-job", &folder.path("job.json")]);
    assert!(validator.is_valid(&folder.json("job.json")));
    assert!(!validator.is_valid(&serde_json::json!({"geometries": [{"file": "a"}], "cels": 3})));
    assert!(!validator.is_valid(&serde_json::json!({"cells": 3})));
}

#[test]
fn groups_of_an_obj_are_split_and_picked() {
    let folder = Folder::new();
    let cube = |name: &str, at: u32, first: u32| {
        let corner = |index: u32| format!("v {} {} {}\n", at + index % 2, index / 2 % 2, index / 4);
        let corners: String = (0..8).map(corner).collect();
        let sides = [[1, 3, 4, 2], [5, 6, 8, 7], [1, 2, 6, 5], [3, 7, 8, 4], [1, 5, 7, 3], [2, 4, 8, 6]];
        let side = |of: [u32; 4]| format!("f {}\n", of.map(|index| (index + first).to_string()).join(" "));
        format!("{corners}o {name}\n{}", sides.map(side).concat())
    };
    let obj = folder.path("two.obj");
    std::fs::write(&obj, cube("left", 0, 0) + &cube("right", 2, 8)).expect("written");
    let flags = |arguments: &[&str]| {
        let report = json(
            &[&["mesh", "--domain", "0,0,0,3,1,1", "--dims", "6,2,2", "--backend", "cpu", "--json"], arguments]
                .concat(),
        );
        let flags = report["flags"].as_array().expect("a list").clone();
        flags
            .iter()
            .map(|flag| (flag["name"].as_str().expect("a name").to_string(), flag["cells"].as_u64()))
            .collect::<Vec<_>>()
    };
    assert_eq!(flags(&[&obj]), [("two".to_string(), Some(16))]);
    assert_eq!(flags(&[&obj, "--split"]), [("left".to_string(), Some(8)), ("right".to_string(), Some(8))]);
    assert_eq!(flags(&[&format!("{obj}:solid=right")]), [("two:right".to_string(), Some(8))]);
}

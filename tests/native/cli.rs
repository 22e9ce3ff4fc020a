//! The command line as a user meets it: files, JSON, exit codes, and nothing left behind.

use hexcast::gpu::{AdapterKind, adapter};
use serde_json::Value;
use sha2::{Digest, Sha256};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use tempfile::TempDir;

use super::tolerances::far_off;

pub(super) const SPOT: &str = "tests/fixtures/spot.stl";

pub(super) fn hexcast(arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_hexcast"));
    command.current_dir(env!("CARGO_MANIFEST_DIR")).args(arguments).output().expect("hexcast starts")
}

/// Runs hexcast, which must succeed, and returns its standard output.
#[track_caller]
pub(super) fn done(arguments: &[&str]) -> String {
    let output = hexcast(arguments);
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{arguments:?}: {:?}\n{error}", output.status);
    String::from_utf8(output.stdout).expect("UTF-8")
}

#[track_caller]
pub(super) fn json(arguments: &[&str]) -> Value {
    let text = done(arguments);
    serde_json::from_str(&text).unwrap_or_else(|error| panic!("{arguments:?}: {error}\n{text}"))
}

/// A folder and the names in it as arguments.
pub(super) struct Folder(TempDir);

impl Folder {
    pub(super) fn new() -> Folder {
        Folder(tempfile::tempdir().expect("a folder"))
    }

    pub(super) fn path(&self, name: &str) -> String {
        self.0.path().join(name).to_str().expect("UTF-8").to_string()
    }

    pub(super) fn bytes(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    pub(super) fn json(&self, name: &str) -> Value {
        serde_json::from_slice(&self.bytes(name)).expect("JSON")
    }

    pub(super) fn names(&self) -> Vec<String> {
        let entries = std::fs::read_dir(self.0.path()).expect("the folder is there");
        let mut names: Vec<String> =
            entries.map(|entry| entry.expect("an entry").file_name().into_string().expect("UTF-8")).collect();
        names.sort();
        names
    }
}

fn sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}

#[test]
fn a_fixture_is_meshed_to_every_format() {
    let folder = Folder::new();
    let names = ["a.raw", "a.npy", "a.vti", "a.hxc"];
    let outputs: Vec<String> = names.iter().map(|name| folder.path(name)).collect();
    let mut arguments = vec!["mesh", SPOT, "--cells", "24", "--backend", "cpu", "--json", "--hash", "sha256"];
    outputs.iter().for_each(|output| arguments.extend(["-o", output]));
    let report = json(&arguments);
    assert_eq!(folder.names(), ["a.hxc", "a.npy", "a.raw", "a.raw.json", "a.vti"]);

    let dims: Vec<u64> = report["dims"].as_array().unwrap().iter().map(|n| n.as_u64().unwrap()).collect();
    let n_cells: u64 = dims.iter().product();
    assert_eq!((dims[2], report["cells"].as_u64()), (24, Some(n_cells)));
    let raw = folder.bytes("a.raw");
    assert_eq!(raw.len() as u64, n_cells);
    assert_eq!(folder.bytes("a.npy").len() as u64, n_cells + 128);
    assert_eq!(folder.bytes("a.npy")[128..], raw);
    assert_eq!(folder.bytes("a.vti")[..5], *b"<?xml");
    assert_eq!(folder.bytes("a.hxc")[..4], *b"\x89HXC");

    let sidecar = folder.json("a.raw.json");
    assert_eq!(sidecar["sha256"], sha256(&raw));
    assert_eq!(report["flags_sha256"], sidecar["sha256"]);
    assert_eq!(report["flags_hash"], sidecar["flags_hash"]);
    assert_eq!([&sidecar["dims"], &sidecar["origin"]], [&report["dims"], &report["origin"]]);
    let cells = raw.iter().filter(|flag| **flag == 1).count();
    assert_eq!(report["flags"][0]["cells"], cells);
}

#[test]
fn the_report_has_the_keys_that_others_rely_on() {
    let folder = Folder::new();
    let file = folder.path("r.json");
    let printed =
        json(&["mesh", SPOT, "--cells", "16", "--backend", "cpu", "--unit", "mm", "--json", "--report", &file]);
    assert_eq!(folder.json("r.json"), printed);
    for key in ["dims", "origin", "spacing", "odd_rays", "flags", "flags_sha256", "seconds", "adapter", "backend"] {
        assert!(printed.get(key).is_some(), "{key}");
    }
    for key in ["flag", "name", "cells", "volume", "mesh_volume"] {
        assert!(printed["flags"][0].get(key).is_some(), "flags.{key}");
    }
    for key in ["total", "read", "lines", "snap", "columns"] {
        assert!(printed["seconds"][key].as_f64().unwrap() >= 0.0, "seconds.{key}");
    }
    assert_eq!((&printed["backend"], &printed["adapter"]), (&"cpu".into(), &Value::Null));
    assert_eq!((&printed["unit"], &printed["odd_rays"]), (&"mm".into(), &0.into()));
    assert_eq!(printed["inputs"][0]["blake3"], blake3::hash(&std::fs::read(SPOT).unwrap()).to_string());
    #[cfg(target_os = "linux")]
    assert!(printed["peak_bytes"]["host"].as_u64().unwrap() > 1 << 20);
    let volume = &printed["flags"][0];
    let ratio = volume["volume"].as_f64().unwrap() / volume["mesh_volume"].as_f64().unwrap();
    assert!((0.9..1.1).contains(&ratio), "{ratio}");
}

#[test]
fn flags_in_memory_and_hashes_are_made_where_asked_for() {
    let common = ["mesh", SPOT, "--cells", "16", "--backend", "cpu", "--json"];
    let plain = json(&common);
    let asked = json(&[&common[..], &["--flags-in-memory", "--hash", "sha256"]].concat());
    assert!(
        plain["seconds"]["flags"].is_null() && plain["flags_sha256"].is_null() && plain["seconds"]["hash"].is_null()
    );
    assert!(asked["seconds"]["flags"].is_number() && asked["seconds"]["hash"].is_number());
    assert_eq!(asked["flags_sha256"].as_str().map(str::len), Some(64));
    assert!(plain["flags_hash"].as_str().is_some_and(|hash| hash.starts_with("hx1-")));
    assert_eq!(asked["flags_hash"], plain["flags_hash"]);
    let sum: f64 =
        ["read", "lines", "snap", "columns", "flags"].iter().map(|s| asked["seconds"][s].as_f64().unwrap()).sum();
    assert!((asked["seconds"]["total"].as_f64().unwrap() - sum).abs() < 1e-9);
    for report in [&plain, &asked] {
        let [cells, total, rate] = [&report["cells"], &report["seconds"]["total"], &report["cells_per_second"]]
            .map(|number| number.as_f64().unwrap());
        assert!((rate * total / cells - 1.0).abs() < 1e-9, "{cells} cells in {total} s: {rate} a second");
    }
}

#[test]
fn cpu_and_gpu_any_axis_and_number_of_threads_give_the_same_flags() {
    let hash =
        |options: &[&str]| json(&[&["mesh", SPOT, "--cells", "40", "--json"], options].concat())["flags_hash"].clone();
    let cpu = hash(&["--backend", "cpu"]);
    assert!(cpu.is_string());
    assert_eq!(hash(&["--backend", "gpu"]), cpu);
    assert_eq!(hash(&["--backend", "cpu", "--axis", "x", "--threads", "1"]), cpu);
    assert_eq!(hash(&["--backend", "auto", "--rule", "nonzero"]), cpu);
}

#[test]
fn the_summary_says_what_was_done() {
    let folder = Folder::new();
    let output = folder.path("a.vti");
    let text = done(&["mesh", SPOT, "--cells", "16", "--backend", "cpu", "--unit", "mm", "-o", &output]);
    for part in ["CPU", "5,856 facets", " mm", "rays", "flag        1 \"spot\"", "cells/s", "hash hx1-", "a.vti"] {
        assert!(text.contains(part), "{part}:\n{text}");
    }
    assert!((10..=20).contains(&text.lines().count()), "{text}");
    assert_eq!(done(&["mesh", SPOT, "--cells", "16", "--backend", "cpu", "-q"]), "");
    let walls = done(&["mesh", &format!("{SPOT}:shell=true"), "--cells", "16", "--backend", "cpu", "--fill", "centre"]);
    assert!(walls.contains("filled      \"spot\", a shell of separating fill: "), "{walls}");
    assert!(!walls.contains('%'), "a wall has not the volume that its surface bounds: {walls}");
}

/// 576 edges are open by the bits of their corners, and no warning comes: `info` alone says so.
#[test]
fn open_edges_that_no_ray_finds_are_shown_by_info_only() {
    const OPEN: &str = "tests/fixtures/featuretype.stl";
    assert_eq!(json(&["info", "--json", OPEN])[0]["open_edges"], 576);
    let mesh = ["mesh", OPEN, "--cells", "16", "--backend", "cpu", "--padding-cells", "1"];
    let report = json(&[&mesh[..], &["--json"]].concat());
    assert_eq!((&report["odd_rays"], &report["warnings"]), (&0.into(), &Value::Array(vec![])));
    let quiet = hexcast(&[&mesh[..], &["-q"]].concat());
    assert_eq!((quiet.status.code(), String::from_utf8_lossy(&quiet.stderr)), (Some(0), "".into()));
}

/// A square across all rays along x: every one enters the body and none leaves it.
#[test]
fn an_open_surface_that_rays_enter_is_never_silent() {
    let folder = Folder::new();
    let facets = ["0 0 0 0 1 0 0 1 1", "0 0 0 0 1 1 0 0 1"].map(|corners| {
        let numbers: Vec<&str> = corners.split(' ').collect();
        let vertices: Vec<String> = numbers.chunks(3).map(|corner| format!("vertex {}\n", corner.join(" "))).collect();
        format!("facet normal 0 0 0\nouter loop\n{}endloop\nendfacet\n", vertices.concat())
    });
    std::fs::write(folder.path("lid.stl"), format!("solid lid\n{}endsolid\n", facets.concat())).unwrap();
    let lid = folder.path("lid.stl");
    let mesh = ["mesh", &lid, "--domain=-1,0,0,1,1,1", "--dims", "8,8,8", "--axis", "x", "--backend", "cpu"];
    let report = json(&[&mesh[..], &["--json"]].concat());
    assert_eq!(report["open"][0]["odd_rays"], serde_json::json!([64, 0, 0]));
    assert_eq!(report["open"][0]["doubtful_cells"], 512);
    let quiet = hexcast(&[&mesh[..], &["-q"]].concat());
    let warning = String::from_utf8_lossy(&quiet.stderr);
    assert!(warning.starts_with("warning: geometry \"lid\" is not closed: open edges 4, loops 1"), "{warning}");

    let report = json(&[&mesh[..], &["--json", "--open", "parity"]].concat());
    assert_eq!(report["odd_rays"], 64);
    let quiet = hexcast(&[&mesh[..], &["-q", "--open", "parity"]].concat());
    assert!(String::from_utf8_lossy(&quiet.stderr).starts_with("warning: 64 of 64 rays do not leave"));

    let refused = hexcast(&[&mesh[..], &["--open", "error"]].concat());
    assert_eq!(refused.status.code(), Some(3));
    assert!(String::from_utf8_lossy(&refused.stderr).contains("error[surface-open]: geometry \"lid\" is not closed"));
}

#[test]
fn a_job_file_is_the_same_as_its_command_line() {
    let folder = Folder::new();
    std::fs::copy(SPOT, folder.path("cow.stl")).unwrap();
    let toml = "unit = \"m\"\ndims = [9, 20, 21]\ndomain = [-1, -1, -1, 1, 1, 1.5]\nbackend = \"cpu\"\n\
                [[geometries]]\nfile = \"cow.stl\"\nflag = 7\nname = \"cow\"\n\
                [[geometries]]\nfile = \"cow.stl\"\npriority = 2\nname = \"calf\"\nscale = 0.5\n";
    std::fs::write(folder.path("job.toml"), toml).unwrap();
    let (stl, job, a, b) =
        (folder.path("cow.stl"), folder.path("job.toml"), folder.path("a.hxc"), folder.path("b.hxc"));
    let cow = format!("{stl}:flag=7,name=cow");
    let calf = format!("{stl}:priority=2,name=calf,scale=0.5");
    let domain = ["--domain", "-1,-1,-1,1,1,1.5", "--dims", "9,20,21", "--unit", "m", "--backend", "cpu"];
    let direct = json(&[&["mesh", &cow, &calf, "-o", &a, "--json"], &domain[..]].concat());
    let from_job = json(&["mesh", "--job", &job, "-o", &b, "--json"]);
    assert_eq!(folder.bytes("a.hxc"), folder.bytes("b.hxc"));
    assert_eq!(direct["flags"], from_job["flags"]);
    assert_eq!((&direct["flags"][0]["flag"], &direct["flags"][1]["flag"]), (&2.into(), &7.into()));

    // options override the file
    let other = json(&["mesh", "--job", &job, "--cells", "12", "--unit", "km", "--padding-cells", "1", "--json"]);
    assert_eq!((&other["unit"], &other["dims"][2]), (&"km".into(), &14.into()));
}

#[test]
fn the_report_of_a_job_with_max_cell_size_has_residuals() {
    let folder = Folder::new();
    let stl = Path::new(env!("CARGO_MANIFEST_DIR")).join(SPOT);
    let job = serde_json::json!({"geometries": [{"file": stl}], "max_cell_size": 0.1, "backend": "cpu"});
    std::fs::write(folder.path("job.json"), job.to_string()).unwrap();
    let report = json(&["mesh", "--job", &folder.path("job.json"), "--json"]);
    assert!(report["spacing"][0].as_f64().unwrap() <= 0.1);
    assert_eq!(report["end_points"][0].as_array().unwrap().len(), 2);
}

#[test]
fn converting_gives_the_bytes_of_writing() {
    let folder = Folder::new();
    let names = ["a.raw", "a.npy", "a.vti", "a.hxc"];
    for options in [&[][..], &["--compress=none"], &["--compress=6"]] {
        let outputs: Vec<String> = names.iter().map(|name| folder.path(name)).collect();
        let mut arguments = [&["mesh", SPOT, "--cells", "20", "--backend", "cpu", "-q"], options].concat();
        outputs.iter().for_each(|output| arguments.extend(["-o", output]));
        done(&arguments);
        for name in names {
            let compresses =
                name.ends_with("vti") || name.ends_with("hxc") || options.first() == Some(&"--compress=none");
            let applicable = if compresses { options } else { &[] };
            let converted = folder.path(&name.replace("a.", "b."));
            done(&[&["convert", &folder.path("a.hxc"), &converted], applicable].concat());
            assert_eq!(std::fs::read(&converted).unwrap(), folder.bytes(name), "{name} {options:?}");
        }
        assert_eq!(folder.bytes("b.raw.json"), folder.bytes("a.raw.json"));
    }
    let bits = folder.path("bits.raw");
    done(&["convert", &folder.path("a.hxc"), &bits, "--bits"]);
    assert_eq!(folder.json("bits.raw.json")["dtype"], "bit");
    assert_eq!(folder.json("bits.raw.json")["n_bytes"], folder.bytes("bits.raw").len());
}

#[test]
fn info_says_whether_a_surface_is_closed() {
    let files = [SPOT, "tests/fixtures/featuretype.stl", "tests/fixtures/ascii_two_solids_mixed_case.stl"];
    let list = json(&[&["info", "--json"], &files[..]].concat());
    let [cow, part, cubes] = [&list[0], &list[1], &list[2]];
    assert_eq!((&cow["facets"], &cow["watertight"], &cow["shells"]), (&5856.into(), &true.into(), &1.into()));
    assert!((cow["signed_volume"].as_f64().unwrap() - 0.718258789).abs() < 1e-8);
    assert_eq!((&part["open_edges"], &part["watertight"]), (&576.into(), &false.into()));
    assert_eq!(part["worst_open_edges"].as_array().unwrap().len(), 10);
    assert_eq!(cubes["solids"][1], serde_json::json!({"name": "TranslatedCubeExportedFromCAD", "facets": 12}));
    let text = done(&[&["info"], &files[..]].concat());
    for part in ["closed      yes", "576 open", "open edge", "5,856", "\"CubeExportedFromCAD\": 12 facets"] {
        assert!(text.contains(part), "{part}:\n{text}");
    }
}

#[test]
fn an_estimate_is_near_the_mesh_on_cpu_and_gpu() {
    let folder = Folder::new();
    let (npy, vti, hxc) = (folder.path("a.npy"), folder.path("a.vti"), folder.path("a.hxc"));
    let common = [SPOT, "--cells", "64", "--padding-length", "0.2"];
    let estimate = json(&[&["estimate", "--json"], &common[..]].concat());
    let report =
        json(&[&["mesh", "--json", "--backend", "cpu", "-o", &npy, "-o", &vti, "-o", &hxc], &common[..]].concat());
    for key in ["dims", "origin", "spacing", "cells", "rays", "ray_axis"] {
        assert_eq!(estimate[key], report[key], "{key}");
    }
    let on_gpu = json(&[&["mesh", "--json", "--backend", "gpu"], &common[..]].concat());
    let files = &estimate["file_bytes"];
    assert_eq!(files["npy"], folder.bytes("a.npy").len());
    let pairs = [
        ("crossings", &estimate["crossings"], report["crossings"].as_u64().unwrap()),
        ("device", &estimate["device_bytes"], on_gpu["peak_bytes"]["device"].as_u64().unwrap()),
        ("vti_zlib", &files["vti_zlib"], folder.bytes("a.vti").len() as u64),
        ("hxc_zlib", &files["hxc_zlib"], folder.bytes("a.hxc").len() as u64),
    ];
    for (name, estimated, real) in pairs {
        assert_eq!(far_off(name, estimated.as_u64().unwrap(), real), None);
    }
    assert!(done(&[&["estimate"], &common[..]].concat()).contains("crossings   about"));
}

/// Mesa's layer asks Wayland for a device, and Wayland complains where no session runs.
#[test]
fn nothing_complains_where_no_session_runs() {
    let mut command = Command::new(env!("CARGO_BIN_EXE_hexcast"));
    command.env_remove("XDG_RUNTIME_DIR").env_remove("NODEVICE_SELECT");
    let output = command.arg("adapters").output().expect("hexcast starts");
    assert!(output.status.success(), "{output:?}");
    assert_eq!(String::from_utf8_lossy(&output.stderr), "");
}

#[test]
fn gpu_adapters_are_listed() {
    let adapters = json(&["adapters", "--json"]);
    let adapters = adapters.as_array().unwrap();
    assert!(!adapters.is_empty(), "install a Vulkan driver such as lavapipe, or leave this test out with --skip gpu");
    for adapter in adapters {
        assert!(["name", "driver", "kind"].iter().all(|key| adapter[key].is_string()), "{adapter}");
    }
}

#[test]
fn a_report_of_the_machine_says_versions_threads_memory_and_gpus() {
    let report = done(&["adapters", "--report"]);
    let fact = |name: &str| {
        report.lines().find_map(|line| line.strip_prefix(name)).unwrap_or_else(|| panic!("{name}: {report}"))
    };
    assert!(fact("hexcast ").trim_start().starts_with(env!("CARGO_PKG_VERSION")), "{report}");
    let n_threads = std::thread::available_parallelism().unwrap().to_string();
    assert!(fact("threads ").trim_start().starts_with(&n_threads), "{report}");
    let adapters = json(&["adapters", "--json"]);
    let gpus = adapters.as_array().unwrap();
    assert_eq!(report.lines().filter(|line| line.starts_with("gpu ")).count(), gpus.len().max(1), "{report}");
    assert!(gpus.iter().all(|gpu| report.contains(gpu["driver"].as_str().unwrap())), "{report}");
    if cfg!(target_os = "linux") {
        assert!(["kernel ", "processor ", "memory "].iter().all(|name| fact(name).trim().len() > 3), "{report}");
    }
    // nothing that a report should not say
    let private = ["HOME", "USER", "HOSTNAME"].map(|name| std::env::var(name).unwrap_or_default());
    let said = |word: &&String| word.len() > 4 && report.contains(word.as_str());
    assert_eq!(private.iter().find(said), None, "{report}");
    assert!(report.lines().all(|line| line.len() < 200), "{report}");
}

#[test]
fn every_command_has_a_page_for_man() {
    let help = done(&["--help"]);
    let commands = help.split("Commands:").nth(1).unwrap().split("Options:").next().unwrap();
    let names: Vec<&str> = commands
        .lines()
        .filter(|line| line.starts_with("  ") && !line.starts_with("   "))
        .filter_map(|line| line.split_whitespace().next())
        .collect();
    assert!(names.len() > 15 && names.contains(&"mesh") && names.contains(&"man"), "{names:?}");
    // roff writes a hyphen as \-
    let page = |name: &str| done(&["man", name]).replace("\\-", "-");
    for name in names {
        let page = page(name);
        assert!(page.contains(".TH") && page.contains(&format!("hexcast {name}")), "{name}: {page}");
    }
    // an option has its name on one line, and its sentence on the next
    let mesh = page("mesh");
    let lines: Vec<&str> = mesh.lines().collect();
    let options: Vec<_> = lines.windows(3).filter(|of| of[0] == ".TP" && of[1].contains("--")).collect();
    assert!(options.len() > 70, "{}", options.len());
    assert_eq!(options.iter().find(|of| of[2].len() < 10), None);
    for word in ["--cells", "--max-memory", "--output", "--split", ".zarr.zip", "hexcast mesh part.stl --cells 256"] {
        assert!(mesh.contains(word), "{word}: {mesh}");
    }
    assert!(done(&["man"]).contains("Exit codes"));
    let refused = hexcast(&["man", "nothing"]);
    assert_eq!(refused.status.code(), Some(2));
    assert!(
        String::from_utf8_lossy(&refused.stderr).contains("there is no command \"nothing\": commands are info, "),
        "{refused:?}"
    );
}

#[test]
fn completions_and_help_are_printed() {
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let script = done(&["completions", shell]);
        assert!(script.contains("hexcast") && script.contains("max-memory"), "{shell}");
    }
    assert!(done(&["--help"]).contains("Exit codes:"));
    for command in ["mesh", "info", "estimate", "adapters", "convert", "completions", "man"] {
        assert!(done(&[command, "--help"]).contains("Example"), "{command}");
    }
}

#[test]
fn the_short_help_of_mesh_has_ten_options_and_the_long_one_all_under_their_headings() {
    let options = |help: &str| {
        let words = help.lines().flat_map(|line| line.split_whitespace().take(2));
        let longs = words.filter_map(|word| word.strip_prefix("--")).map(|word| word.trim_end_matches(',').to_string());
        longs.filter(|long| long != "help").collect::<BTreeSet<_>>()
    };
    let (short, long) = (done(&["mesh", "-h"]), done(&["mesh", "--help"]));
    let first = ["backend", "cell-size", "cells", "domain", "graded", "job", "open", "output", "report", "unit"];
    assert_eq!(options(&short), first.map(String::from).into(), "{short}");
    assert!(options(&long).is_superset(&options(&short)) && options(&long).len() > 60, "{long}");
    for heading in ["Cells and domain", "Method", "Memory", "Output", "Measured", "Pictures", "Report"] {
        assert!(long.contains(&format!("\n{heading}:\n")), "{heading}\n{long}");
    }
    for ending in [".vti ", ".zarr.zip ", ".foam ", "geometry.xml ", ".binvox ", ".hxc "] {
        assert!(long.contains(&format!("\n    {ending}")), "{ending}\n{long}");
    }
}

#[test]
fn every_failure_has_its_exit_code() {
    let folder = Folder::new();
    let cut = folder.path("cut.stl");
    let stl = std::fs::read(SPOT).unwrap();
    std::fs::write(&cut, &stl[..stl.len() - 700]).unwrap();
    std::fs::write(folder.path("bad.toml"), "cells = \"many\"").unwrap();
    std::fs::write(folder.path("bad.hxc"), "no columns").unwrap();
    let (vti, raw, txt) = (folder.path("a.vti"), folder.path("a.raw"), folder.path("a.txt"));
    let (below_file, bad_job, bad_hxc) = (format!("{cut}/a.vti"), folder.path("bad.toml"), folder.path("bad.hxc"));
    let (nowhere, copy) = (folder.path("no/such/folder/a.vti"), folder.path("copy.hxc"));
    let cases: &[(&[&str], i32, &str)] = &[
        (&["mesh"], 2, "error"),
        (&["mesh", SPOT, "--cells", "9", "--dims", "9,9,9"], 2, "cannot be used with"),
        (&["mesh", SPOT, "--dims", "9,9"], 2, "3 numbers"),
        (&["mesh", SPOT, "--job", "job.toml"], 2, "cannot be used with"),
        (&["mesh", SPOT, "--compress=11", "-o", &vti], 2, "1 to 9 or none"),
        (&["mesh", &cut, "-o", &vti], 3, "error[stl-truncated]"),
        (&["info", &cut], 3, "error[stl-truncated]"),
        (&["convert", &bad_hxc, &vti], 3, "error[columns-corrupt]"),
        (&["mesh", SPOT, "-o", &txt], 2, "error[output-name]"),
        (&["mesh", SPOT, "--cells", "0"], 4, "error[job-value]"),
        (&["mesh", SPOT, SPOT, "--bits", "-o", &raw], 4, "error[job-conflict]"),
        (&["mesh", SPOT, "--bits", "-o", &vti], 4, "error[job-conflict]"),
        (&["mesh", SPOT, "--compress", "-o", &raw], 4, "error[job-conflict]"),
        (&["mesh", SPOT, "-o", &vti, "-o", &vti], 4, "is written twice"),
        (&["mesh", &cut, "--report", &cut], 4, "is an input too"),
        (&["mesh", "--job", &bad_job], 4, "cells"),
        (&["mesh", SPOT, "--cells", "3000000", "--backend", "cpu"], 5, "error[too-many-cells]"),
        (&["mesh", SPOT, "--adapter", "no such adapter"], 6, "error[no-adapter]"),
        (&["mesh", "no-such-file.stl", "-o", &vti], 7, "no-such-file.stl"),
        (&["mesh", SPOT, "-o", &nowhere], 7, "cannot be written"),
        (&["mesh", SPOT, "-o", &below_file], 7, "cannot be written"),
        (&["convert", "no-such-file.hxc", &copy], 7, "no-such-file.hxc"),
    ];
    for (arguments, code, part) in cases {
        let output = hexcast(arguments);
        let error = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(*code), "{arguments:?}: {error}");
        assert!(error.contains(part), "{arguments:?}: {error}");
        assert!(output.stdout.is_empty(), "{arguments:?}");
    }
    assert_eq!(folder.names(), ["bad.hxc", "bad.toml", "cut.stl"]);
}

#[test]
fn errors_say_what_to_do() {
    let folder = Folder::new();
    let (here, vti, txt) = (folder.path(""), folder.path("a.vti"), folder.path("a.txt"));
    let (nowhere, zarr) = (folder.path("nowhere/a.vti"), folder.path("nowhere/a.zarr"));
    let no_solid = format!("{SPOT}:solid=lid");
    std::fs::write(folder.path("a.vti.partial"), "notes").unwrap();
    let cases: &[(&[&str], i32, &str)] = &[
        (&["estimate", SPOT, "--dims", "1000000,1000000,1000000"], 5, "1000000 cells along x: at most 262142 fit"),
        (&["estimate", SPOT, "--cells", "4294967295"], 5, "at most 262142 fit"),
        (&["mesh", SPOT, "--cell-size", "1e-30"], 5, "cells of size 1e-30 along x"),
        (&["mesh", SPOT, "--cell-size", "1e300"], 4, "cells of 1e300 along x, from -0.47"),
        (&["mesh", SPOT, "--cell-size", "1e39"], 4, "coordinates up to 1e38"),
        (
            &["mesh", SPOT, "--padding-length", "1e300", "--cells", "4"],
            4,
            "cells of 5e299 along x, from -1e300 to 1e300",
        ),
        (&["mesh", SPOT, "--domain=0,0,0,1e300,1e300,1e300", "--cells", "4"], 4, "cells of 2.5e299 along x"),
        (&["mesh", &format!("{SPOT}:scale=1e120")], 4, "coordinates up to 1e38"),
        (&["mesh", &format!("{SPOT}:scale=1e-120")], 4, "cells can have 1e-38 and more"),
        (&["mesh", SPOT, "--graded", "1e300"], 4, "cells of at least 1e297 along x"),
        (&["mesh", SPOT, "--graded", "1e-300"], 5, "e299 cells along x: at most 262142 fit"),
        (&["mesh", SPOT, "--domain=-1e308,0,0,1e308,1,1"], 4, "the domain reaches from -1e308 to 1e308 along x"),
        // the message, whatever the program takes: that depends on how it is built
        (&["mesh", SPOT, "--backend", "cpu", "--max-memory", "10MB"], 5, "10.00 MB are allowed"),
        (&["mesh", SPOT, "--threads", "65535"], 2, "1 to 1024 is needed"),
        (&["mesh", &no_solid], 4, "its 1 have no names"),
        (&["mesh", "--job", &here], 7, "is a folder"),
        (&["mesh", "--job", SPOT], 4, "is not UTF-8 text"),
        (&["mesh", "--job", "no-such.toml"], 7, "there is no such file"),
        (&["convert", &here, &vti], 7, "is a folder"),
        (&["convert", "no-such.hxc", &vti], 7, "there is no such file"),
        (&["mesh", SPOT, "-o", &txt], 2, ".zarr"),
        (&["mesh", SPOT, "-o", &nowhere], 7, "there is no folder"),
        (&["mesh", SPOT, "-o", &zarr], 7, "there is no folder"),
        (&["mesh", SPOT, "--spill", &nowhere], 7, "no temporary file can be made"),
        (
            &["mesh", SPOT, "--cells", "9", "--backend", "cpu", "--resume", "-o", &vti],
            4,
            "the file exists but is not a hexcast file",
        ),
    ];
    for (arguments, code, part) in cases {
        let output = hexcast(arguments);
        let error = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(*code), "{arguments:?}: {error}");
        assert!(error.contains(part), "{arguments:?}: {error}");
        // clap has its own way of saying what to do
        assert!(*code == 2 || error.contains("\nhint: "), "{arguments:?}: {error}");
    }
    assert_eq!(folder.names(), ["a.vti.partial"]);
    assert_eq!(folder.bytes("a.vti.partial"), b"notes");
}

#[test]
fn an_output_that_is_there_is_replaced_only_at_the_end() {
    let folder = Folder::new();
    std::fs::write(folder.path("a.vti"), "precious").unwrap();
    let output = folder.path("a.vti");
    let failed = hexcast(&["mesh", "tests/fixtures/bin_empty.stl", "-o", &output]);
    assert_eq!((failed.status.code(), folder.bytes("a.vti")), (Some(3), b"precious".to_vec()));
    done(&["mesh", SPOT, "--cells", "8", "--backend", "cpu", "-q", "-o", &output]);
    assert_eq!((folder.bytes("a.vti")[..5].to_vec(), folder.names()), (b"<?xml".to_vec(), vec!["a.vti".to_string()]));
}

/// Ctrl-C while a file far larger than any disk is written.
#[cfg(unix)]
#[test]
fn ctrl_c_leaves_no_file() {
    use std::time::{Duration, Instant};
    let folder = Folder::new();
    let output = folder.path("huge.vti");
    let mut child = Command::new(env!("CARGO_BIN_EXE_hexcast"))
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .args(["mesh", SPOT, "--backend", "cpu", "--dims", "2000,2000,100000", "--axis", "z"])
        .args(["-o", &output])
        .stderr(Stdio::piped())
        .stdout(Stdio::null())
        .spawn()
        .expect("hexcast starts");
    let start = Instant::now();
    while folder.names().is_empty() {
        assert!(start.elapsed() < Duration::from_secs(60), "no temporary file appeared");
        std::thread::sleep(Duration::from_millis(10));
    }
    std::thread::sleep(Duration::from_millis(300));
    assert!(folder.names().iter().all(|name| name.starts_with(".hexcast-")), "{:?}", folder.names());
    let killed = Command::new("kill").args(["-INT", &child.id().to_string()]).status().expect("kill runs");
    assert!(killed.success());
    let status = child.wait().expect("hexcast ends");
    assert_eq!((status.code(), folder.names()), (Some(130), Vec::<String>::new()));
}

#[cfg(unix)]
#[test]
fn files_are_as_readable_as_any_other_and_inputs_may_be_pipes() {
    use std::os::unix::fs::PermissionsExt;
    let folder = Folder::new();
    let output = folder.path("a.raw");
    let mut cat = Command::new("cat").arg(SPOT).stdout(Stdio::piped()).spawn().expect("cat starts");
    let status = Command::new(env!("CARGO_BIN_EXE_hexcast"))
        .args(["mesh", "/dev/stdin", "--cells", "8", "--backend", "cpu", "-q", "-o", &output])
        .stdin(cat.stdout.take().expect("a pipe"))
        .status()
        .expect("hexcast starts");
    cat.wait().expect("cat ends");
    assert!(status.success());
    let mode = |path: PathBuf| std::fs::metadata(path).expect("a file").permissions().mode();
    std::fs::write(folder.path("plain"), "").unwrap();
    assert_eq!(mode(output.into()), mode(folder.path("plain").into()));
}

/// More rays than one round of the CPU, in 150 MB of columns and more.
pub(super) const MANY_RAYS: [&str; 9] =
    ["mesh", SPOT, "--dims", "8,5000,5000", "--axis", "x", "--backend", "cpu", "--json"];

/// The same on the GPU.
const MANY_RAYS_GPU: [&str; 9] = ["mesh", SPOT, "--dims", "8,5000,5000", "--axis", "x", "--backend", "gpu", "--json"];

#[test]
fn memory_of_cpu_and_gpu_stays_under_the_limit_and_what_does_not_fit_is_refused() {
    let folder = Folder::new();
    let refused = hexcast(&[&MANY_RAYS[..], &["--max-memory", "100MB"]].concat());
    let error = String::from_utf8_lossy(&refused.stderr);
    assert_eq!(refused.status.code(), Some(5), "{error}");
    assert!(error.contains("error[memory]") && error.contains("100.00 MB are allowed"), "{error}");
    assert!(error.contains("--spill DIR"), "{error}");

    let spill = ["--max-memory", "100MB", "--spill", &folder.path(""), "--hash", "sha256"];
    let spilled = json(&[&MANY_RAYS[..], &spill].concat());
    assert!(spilled["peak_bytes"]["spilled"].as_u64().unwrap() > 0);
    #[cfg(target_os = "linux")]
    {
        let host = spilled["peak_bytes"]["host"].as_u64().unwrap();
        assert!(host < 100_000_000, "{host} bytes");
    }
    assert!(folder.names().is_empty(), "{:?}", folder.names());
    let whole = json(&[&MANY_RAYS[..], &["--hash", "sha256"]].concat());
    assert_eq!(spilled["flags_sha256"], whole["flags_sha256"]);

    // the driver and its buffers count where the processor is the GPU; drivers of others take some 100 MB of the host's memory
    let is_software = pollster::block_on(adapter(None)).expect("a GPU").kind == AdapterKind::Software;
    let most = if is_software { 256 } else { 1000 };
    let [small, enough] = [64, most].map(|max| {
        let max = format!("{max}MB");
        let folder = folder.path("");
        hexcast(&[&MANY_RAYS_GPU[..], &["--max-memory", &max, "--spill", &folder, "--hash", "sha256"]].concat())
    });
    let error = String::from_utf8_lossy(&small.stderr);
    assert_eq!(small.status.code(), Some(5), "{error}");
    assert!(error.contains("program and driver") && error.contains("64.00 MB are allowed"), "{error}");
    let report: Value = serde_json::from_slice(&enough.stdout).expect("a report");
    assert_eq!(report["flags_sha256"], whole["flags_sha256"]);
    #[cfg(target_os = "linux")]
    {
        let host = report["peak_bytes"]["host"].as_u64().unwrap();
        assert!(host < most * 1_000_000, "{host} bytes");
    }

    // before meshing: with more cells than any machine has memory
    let flags = [
        "mesh",
        SPOT,
        "--dims",
        "100000,100000,100000",
        "--backend",
        "cpu",
        "--flags-in-memory",
        "--max-cells",
        "1e15",
    ];
    let refused = hexcast(&flags);
    let error = String::from_utf8_lossy(&refused.stderr);
    assert!(refused.status.code() == Some(5) && error.contains("leave out --flags-in-memory"), "{error}");
}

/// Ctrl-C while meshing with --resume, and the same command again.
#[cfg(unix)]
#[test]
fn an_interrupted_run_resumes() {
    use std::time::{Duration, Instant};
    let folder = Folder::new();
    let (output, plain) = (folder.path("a.npy"), folder.path("plain.npy"));
    let arguments = [&MANY_RAYS[..], &["--resume", "-o", &output]].concat();
    let child = Command::new(env!("CARGO_BIN_EXE_hexcast"))
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .args(&arguments)
        .stderr(Stdio::piped())
        .stdout(Stdio::null())
        .spawn()
        .expect("hexcast starts");
    let start = Instant::now();
    let partial = folder.path("a.npy.partial");
    while std::fs::metadata(&partial).map_or(0, |metadata| metadata.len()) < 100_000 {
        assert!(start.elapsed() < Duration::from_secs(60), "nothing was kept");
        std::thread::sleep(Duration::from_millis(2));
    }
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().expect("kill runs").success());
    let ended = child.wait_with_output().expect("hexcast ends");
    let said = String::from_utf8_lossy(&ended.stderr);
    assert_eq!(ended.status.code(), Some(130), "{said}");
    assert!(said.contains("the same command continues from there"), "{said}");
    assert_eq!(folder.names(), ["a.npy.partial"]);

    let other = hexcast(&["mesh", SPOT, "--cells", "8", "--backend", "cpu", "--resume", "-o", &output]);
    assert_eq!((other.status.code(), folder.names()), (Some(4), vec!["a.npy.partial".to_string()]));

    let info = hexcast(&["info", &partial]);
    let said = String::from_utf8_lossy(&info.stderr);
    assert!(info.status.code() == Some(3) && said.contains("was never finished"), "{said}");

    let report = json(&arguments);
    let (kept, rays) = (report["rays_kept"].as_u64().unwrap(), report["rays"].as_u64().unwrap());
    assert!(kept > 0 && kept <= rays, "{kept} of {rays}");
    assert_eq!(folder.names(), ["a.npy"]);
    json(&[&MANY_RAYS[..], &["-o", &plain]].concat());
    assert!(folder.bytes("a.npy") == folder.bytes("plain.npy"));
}

#[test]
fn a_zarr_folder_is_written_whole_or_not_at_all() {
    let folder = Folder::new();
    let (zarr, hxc, copy) = (folder.path("a.zarr"), folder.path("a.hxc"), folder.path("b.zarr"));
    let mesh = ["mesh", SPOT, "--cells", "100", "--backend", "cpu", "-q", "-o", &zarr];
    done(&[&mesh[..], &["-o", &hxc]].concat());
    done(&["convert", &hxc, &copy, "-q"]);
    assert_eq!(folder.names(), ["a.hxc", "a.zarr", "b.zarr"]);
    let array = folder.json("a.zarr/flag/zarr.json");
    assert_eq!((&array["zarr_format"], &array["codecs"][0]["name"]), (&3.into(), &"sharding_indexed".into()));
    assert_eq!(array["dimension_names"], serde_json::json!(["z", "y", "x"]));
    assert_eq!(array["attributes"]["flags"][0]["name"], "spot");
    assert_eq!(folder.bytes("a.zarr/flag/c/0/0/0"), folder.bytes("b.zarr/flag/c/0/0/0"));
    // once more over the old one, and not over a folder of another kind
    done(&mesh);
    assert_eq!(folder.names(), ["a.hxc", "a.zarr", "b.zarr"]);
    std::fs::create_dir(folder.path("mine.zarr")).unwrap();
    std::fs::write(folder.path("mine.zarr/precious"), "").unwrap();
    let refused = hexcast(&["mesh", SPOT, "--cells", "8", "-q", "-o", &folder.path("mine.zarr")]);
    assert_eq!((refused.status.code(), folder.bytes("mine.zarr/precious")), (Some(7), vec![]));
    let failed = hexcast(&["mesh", "tests/fixtures/bin_empty.stl", "-o", &folder.path("c.zarr")]);
    assert_eq!((failed.status.code(), folder.names().len()), (Some(3), 4));
}

#[test]
fn what_is_read_of_a_file_otherwise_than_it_stands_there_is_a_warning_of_the_mesh() {
    let folder = Folder::new();
    let facet = "facet normal 0 0 1\nouter loop\n";
    let corners = |at: [[u8; 3]; 3]| at.map(|[x, y, z]| format!("vertex {x} {y} {z}\n")).concat();
    let facets = [
        [[0, 0, 0], [0, 1, 0], [1, 0, 0]],
        [[0, 0, 0], [1, 0, 0], [0, 0, 1]],
        [[0, 0, 0], [0, 0, 1], [0, 1, 0]],
        [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
    ];
    let facets = facets.map(|of| format!("{facet}{}endloop\nendfacet\n", corners(of))).concat();
    let file = folder.path("tip.stl");
    std::fs::write(&file, format!("solid tip\n{facets}endsolid tip\nsolid lid\nendsolid lid\n")).unwrap();
    let said = "solid \"lid\" without facets left out";
    let report = json(&["mesh", &file, &file, "--cells", "8", "--backend", "cpu", "--json"]);
    let n = report["warnings"].to_string().matches("without facets left out").count();
    assert_eq!(n, 1, "{}", report["warnings"]);
    for more in [&["--quiet"][..], &["--json"], &[], &["--quiet", "--strict"]] {
        let output = hexcast(&[&["mesh", &file, "--cells", "8", "--backend", "cpu"], more].concat());
        let text = String::from_utf8_lossy(&output.stderr);
        assert_eq!(text.matches(said).count(), 1, "{more:?}: {text}");
        assert_eq!(output.status.code(), Some(if more.contains(&"--strict") { 8 } else { 0 }));
    }
}

//! The command as its users run it: files, exit codes, the report.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;
use sha2::{Digest, Sha256};

fn fixture(name: &str) -> String {
    format!("{}/tests/fixtures/{name}", env!("CARGO_MANIFEST_DIR"))
}

fn hexcast(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_hexcast")).args(arguments).output().expect("the command starts")
}

/// Runs a command that must succeed and returns its standard output.
fn done(arguments: &[&str]) -> String {
    let output = hexcast(arguments);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{arguments:?}: {:?}\n{errors}", output.status);
    String::from_utf8(output.stdout).expect("UTF-8")
}

fn json(arguments: &[&str]) -> Value {
    serde_json::from_str(&done(arguments)).expect("standard output is JSON and nothing else")
}

/// Runs a command that must fail and checks its exit code and the code of its error.
fn fails(arguments: &[&str], exit: i32, code: &str) {
    let output = hexcast(arguments);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(exit), "{arguments:?}: {errors}");
    assert!(errors.contains(&format!("error[{code}]")), "{arguments:?}: {errors}");
}

fn sha256(file: &Path) -> String {
    Sha256::digest(std::fs::read(file).expect("the file is there")).iter().map(|byte| format!("{byte:02x}")).collect()
}

/// A folder with paths in it as strings.
struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Folder {
        Folder(tempfile::tempdir().expect("a temporary folder"))
    }

    fn path(&self, name: &str) -> String {
        self.0.path().join(name).to_string_lossy().into_owned()
    }

    fn names(&self) -> Vec<String> {
        let entries = std::fs::read_dir(self.0.path()).expect("the folder is there");
        let mut names: Vec<String> =
            entries.map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }
}

#[test]
fn a_model_goes_to_every_format_with_a_report_that_fits() {
    let folder = Folder::new();
    let [vti, npy, raw, hxc] = ["m.vti", "m.npy", "m.raw", "m.hxc"].map(|name| folder.path(name));
    let spot = fixture("spot.stl");
    let report = json(&[
        "mesh",
        &spot,
        "--cells",
        "40",
        "--backend",
        "cpu",
        "--unit",
        "mm",
        "--json",
        "-o",
        &vti,
        "-o",
        &npy,
        "-o",
        &raw,
        "-o",
        &hxc,
    ]);
    assert_eq!(report["dims"], serde_json::json!([22, 40, 40]));
    assert_eq!((&report["backend"], &report["adapter"], &report["odd_rays"]), (&"cpu".into(), &Value::Null, &0.into()));
    let flag = &report["flags"][0];
    assert_eq!((&flag["flag"], &flag["name"]), (&1.into(), &"spot".into()));
    let (volume, surface) = (flag["volume"].as_f64().unwrap(), flag["mesh_volume"].as_f64().unwrap());
    assert!((volume / surface - 1.0).abs() < 0.02, "{volume} beside {surface}");
    assert!(report["seconds"]["total"].as_f64().unwrap() > 0.0);
    assert_eq!(report["origin"].as_array().unwrap().len() + report["spacing"].as_array().unwrap().len(), 6);
    assert_eq!(report["flags_sha256"].as_str().unwrap(), sha256(Path::new(&raw)));
    assert_eq!(std::fs::metadata(&raw).unwrap().len(), 22 * 40 * 40);
    let sidecar: Value = serde_json::from_str(&std::fs::read_to_string(folder.path("m.raw.json")).unwrap()).unwrap();
    assert_eq!(sidecar["sha256"], report["flags_sha256"]);
    assert_eq!(folder.names(), ["m.hxc", "m.npy", "m.raw", "m.raw.json", "m.vti"]);
    let npy = std::fs::read(&npy).unwrap();
    assert_eq!(npy[npy.len() - 22 * 40 * 40..], std::fs::read(&raw).unwrap());
}

#[test]
fn the_gpu_writes_the_same_bytes() {
    let folder = Folder::new();
    let hash = |backend: &str| {
        let raw = folder.path(&format!("{backend}.raw"));
        done(&["mesh", &fixture("spot.stl"), "--cells", "50", "--backend", backend, "-q", "-o", &raw]);
        sha256(Path::new(&raw))
    };
    // on a machine without a GPU driver auto is the CPU; the kernel tests are the ones that insist on a GPU
    assert_eq!(hash("cpu"), hash("auto"));
}

#[test]
fn a_column_file_converts_to_what_would_have_been_written() {
    let folder = Folder::new();
    let hxc = folder.path("m.hxc");
    let spot = fixture("spot.stl:flag=9,name=cow");
    for name in ["m.raw", "m.npy", "m.vti"] {
        let direct = folder.path(name);
        done(&["mesh", &spot, "--cells", "30", "--backend", "cpu", "-q", "-o", &direct, "-o", &hxc]);
        let converted = folder.path(&format!("converted-{name}"));
        done(&["convert", &hxc, &converted]);
        assert_eq!(sha256(Path::new(&direct)), sha256(Path::new(&converted)), "{name}");
    }
    fails(&["convert", &fixture("spot.stl"), &folder.path("x.vti")], 3, "columns-corrupt");
}

#[test]
fn a_job_file_equals_the_same_arguments() {
    let folder = Folder::new();
    std::fs::copy(fixture("spot.stl"), folder.path("cow.stl")).unwrap();
    let job = folder.path("job.toml");
    let text = "dims = [20, 24, 28]\npadding = { cells = 2 }\nrule = 'nonzero'\n[[geometries]]\nfile = 'cow.stl'\nflag = 4\nrotate = [0, 0, 90]\n";
    std::fs::write(&job, text).unwrap();
    let of_file = json(&["mesh", "--job", &job, "--backend", "cpu", "--json"]);
    let cow = format!("{}:flag=4,rotate=0/0/90", folder.path("cow.stl"));
    let arguments =
        ["mesh", &cow, "--dims", "20,24,28", "--padding-cells", "2", "--rule", "nonzero", "--backend", "cpu", "--json"];
    let of_arguments = json(&arguments);
    for key in ["flags_sha256", "dims", "origin", "spacing", "rule"] {
        assert_eq!(of_file[key], of_arguments[key], "{key}");
    }
    let overridden = json(&["mesh", "--job", &job, "--backend", "cpu", "--cells", "10", "--json"]);
    assert_ne!(overridden["dims"], of_file["dims"]);
}

#[test]
fn what_is_wrong_decides_the_exit_code() {
    let folder = Folder::new();
    let spot = fixture("spot.stl");
    fails(&["mesh", &folder.path("none.stl")], 7, "io");
    fails(&["mesh", &fixture("bin_count_too_big.stl")], 3, "stl-truncated");
    fails(&["mesh", &spot, "--cells", "0"], 4, "job-value");
    fails(&["mesh", &spot, "--cells", "5", "--dims", "1,1,1"], 4, "job-conflict");
    fails(&["mesh"], 4, "job-empty");
    fails(&["mesh", &spot, "--cells", "300000", "--backend", "cpu"], 5, "too-many-cells");
    fails(&["mesh", &spot, "--backend", "gpu", "--adapter", "no such card"], 6, "no-adapter");
    fails(&["mesh", &spot, "-o", "/no/such/folder/m.vti"], 7, "io");
    assert_eq!(hexcast(&["mesh", &spot, "--cells", "many"]).status.code(), Some(2));
    let unknown = hexcast(&["mesh", &spot, "-o", &folder.path("m.xyz")]);
    assert!(String::from_utf8_lossy(&unknown.stderr).contains(".vti"), "the error lists the formats");
    assert_eq!(folder.names(), Vec::<String>::new());
}

#[test]
fn an_input_is_never_overwritten() {
    let folder = Folder::new();
    let input = folder.path("m.hxc");
    done(&["mesh", &fixture("spot.stl"), "--cells", "10", "--backend", "cpu", "-q", "-o", &input]);
    fails(&["convert", &input, &input], 4, "job-conflict");
}

#[test]
fn info_tells_closed_from_open() {
    let facts = json(&["info", &fixture("spot.stl"), &fixture("featuretype.stl"), "--json"]);
    assert_eq!((&facts[0]["watertight"], &facts[0]["facets"]), (&true.into(), &5856.into()));
    assert_eq!((&facts[1]["watertight"], &facts[1]["open_edges"]), (&false.into(), &576.into()));
    assert!(done(&["info", &fixture("featuretype.stl")]).contains("576 open"));
}

#[test]
fn estimates_are_near_what_the_mesh_takes() {
    let spot = fixture("spot.stl");
    let estimate = json(&["estimate", &spot, "--cells", "100", "--json"]);
    let report = json(&["mesh", &spot, "--cells", "100", "--backend", "cpu", "--json", "--hash", "never"]);
    assert_eq!(
        (&estimate["dims"], &estimate["cells"], &estimate["rays"]),
        (&report["dims"], &report["cells"], &report["rays"])
    );
    let ratio = estimate["crossings"].as_f64().unwrap() / report["crossings"].as_f64().unwrap();
    assert!((0.8..1.25).contains(&ratio), "{ratio}");
}

#[test]
fn warnings_name_geometries_without_cells_and_open_surfaces() {
    let far = fixture("spot.stl:name=far,translate=100/0/0");
    let output = hexcast(&[
        "mesh",
        &fixture("spot.stl"),
        &far,
        "--cells",
        "20",
        "--domain",
        "-1,-1,-1,1,1,1",
        "--backend",
        "cpu",
    ]);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && errors.contains("geometry \"far\" (flag 2) got no cell"), "{errors}");
}

#[cfg(unix)]
#[test]
fn an_interrupt_leaves_no_file() {
    let folder = Folder::new();
    let (out, input): (PathBuf, String) = (folder.0.path().join("m.raw"), fixture("spot.stl"));
    let mut command = Command::new(env!("CARGO_BIN_EXE_hexcast"));
    let arguments = ["mesh", &input, "--cells", "3000", "--backend", "cpu", "-q", "-o"];
    let mut child = command.args(arguments).arg(&out).spawn().expect("the command starts");
    // the temporary file shows that the writing of 1.5e10 cells has begun
    while !folder.names().iter().any(|name| name.starts_with(".hexcast-")) {
        assert!(child.try_wait().unwrap().is_none(), "it ended before it wrote");
        std::thread::sleep(std::time::Duration::from_millis(10));
    }
    std::thread::sleep(std::time::Duration::from_millis(200));
    Command::new("kill").args(["-INT", &child.id().to_string()]).status().expect("kill");
    assert_eq!(child.wait().unwrap().code(), Some(130));
    assert_eq!(folder.names(), Vec::<String>::new());
}

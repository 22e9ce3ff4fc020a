//! What strangers and a failing system do to the command line: odd names and files, folders that vanish, disks that fill, runs
//! that are killed.

use super::cli::{Folder, SPOT, done, hexcast};

/// Standard error of a run that must end with an exit code.
#[track_caller]
fn fails(arguments: &[&str], code: i32) -> String {
    let output = hexcast(arguments);
    let error = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(code), "{arguments:?}: {error}");
    error
}

#[test]
fn a_strict_run_with_warnings_writes_its_outputs_and_fails() {
    let folder = Folder::new();
    let output = folder.path("a.raw");
    let far = ["mesh", SPOT, "--domain", "5,5,5,6,6,6", "--cells", "4", "--backend", "cpu", "-q", "-o", &output];
    done(&far);
    std::fs::remove_file(&output).unwrap();
    let error = fails(&[&far[..], &["--strict"]].concat(), 8);
    assert!(error.contains("warning: geometry \"spot\" (flag 1) got no cell"), "{error}");
    assert!(error.contains("1 warning, and --strict is given"), "{error}");
    assert_eq!(folder.names(), ["a.raw", "a.raw.json"]);

    // what is odd about a file is a warning, too
    let cut = ["mesh", "tests/fixtures/ascii_missing_endsolid.stl", "--cells", "4", "--backend", "cpu", "-q"];
    assert_eq!(String::from_utf8_lossy(&hexcast(&cut).stderr), "");
    let error = fails(&[&cut[..], &["--strict"]].concat(), 8);
    assert!(error.contains("ascii_missing_endsolid.stl: line 29: the file ends without"), "{error}");

    done(&["mesh", SPOT, "--cells", "8", "--backend", "cpu", "-q", "--strict"]);
    assert!(done(&["--help"]).contains("8  warnings, and --strict"));
}

//! The golden files against the CPU definition; and the one place that writes them.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::path::PathBuf;

use super::backends::{Backend, mesh};
use super::cases::{Case, cases, moved_by};
use super::golden::{FILES, assert_complete, assert_golden, text};

fn folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/golden")
}

/// What may be done about the files, by the variables `HEXCAST_BLESS` and `CI`.
fn may_bless(bless: Option<&str>, ci: Option<&str>) -> Result<bool, &'static str> {
    match (bless, ci) {
        (Some("1"), None | Some("" | "false")) => Ok(true),
        (Some("1"), Some(_)) => Err("HEXCAST_BLESS=1 where CI is set: golden files are written by people"),
        _ => Ok(false),
    }
}

fn bless(cases: &[Case]) {
    let mut list = String::from("//! Written by `HEXCAST_BLESS=1 cargo test --test native golden_cpu`.\n\n");
    list.push_str("/// Name and text of every golden file.\npub(crate) const FILES: &[(&str, &str)] = &[\n");
    for (name, _) in FILES {
        // a case that is gone takes its file with it; one that never had a file is no fault
        let _ = std::fs::remove_file(folder().join(format!("{name}.txt")));
    }
    for case in cases {
        let along = [0, 1, 2].map(|axis| mesh(Backend::Cpu, case, axis));
        std::fs::write(folder().join(format!("{}.txt", case.name)), text(case, &along)).expect("tests/golden is there");
        let _ = writeln!(list, "    (\"{0}\", include_str!(\"{0}.txt\")),", case.name);
    }
    list.push_str("];\n");
    std::fs::write(folder().join("files.rs"), list).expect("tests/golden is there");
}

#[test]
fn the_cpu_gives_the_golden_files() {
    let variable = |name| std::env::var(name).ok();
    let cases = cases();
    if may_bless(variable("HEXCAST_BLESS").as_deref(), variable("CI").as_deref()).unwrap() {
        return bless(&cases);
    }
    assert_complete(&cases);
    assert_nothing_else_lies_there();
    for case in &cases {
        assert_golden(case, &[0, 1, 2].map(|axis| mesh(Backend::Cpu, case, axis)));
    }
}

fn assert_nothing_else_lies_there() {
    let entries = std::fs::read_dir(folder()).expect("tests/golden is there");
    let found: BTreeSet<String> =
        entries.map(|entry| entry.expect("readable").file_name().into_string().expect("plain")).collect();
    let listed = FILES.iter().map(|(name, _)| format!("{name}.txt"));
    assert_eq!(
        found,
        listed.chain(["files.rs".to_string()]).collect(),
        "files without a case, or cases without a file"
    );
}

#[test]
fn blessing_is_refused_in_ci() {
    assert_eq!(may_bless(Some("1"), None), Ok(true));
    assert_eq!(may_bless(None, Some("true")), Ok(false));
    assert!(may_bless(Some("1"), Some("true")).is_err());
}

#[test]
#[should_panic(expected = "differs from its golden file")]
fn a_mesh_with_another_cell_is_not_golden() {
    let mut case = cases().into_iter().find(|case| case.name == "cube-on-centres").expect("in the table");
    case.lines = moved_by(&case.lines, 1.0);
    assert_golden(&case, &[0, 1, 2].map(|axis| mesh(Backend::Cpu, &case, axis)));
}

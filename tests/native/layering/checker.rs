//! The check of `hexcast verify`: a second program, so that agreement means something.

use std::collections::BTreeSet;

use super::{paths, sources};

/// What the check may use of the library: what is asked for, the reader of what is checked, errors and cancel.
const LIBRARY: &[&str] = &["Error", "Result", "control", "job", "mesh::Mesh"];
/// What the command around it may use of the other commands.
const COMMANDS: &[&str] = &["super::arguments", "super::reading", "super::terminal"];
/// Most lines of code, imports among them, without comments and blank lines.
const MOST_LINES: usize = 925;

#[test]
fn the_check_shares_no_code_with_the_mesher_and_is_short() {
    let sources = sources();
    let is_own = |name: &str| name.starts_with("bin/hexcast/verify/");
    let own: Vec<&str> = sources.iter().filter(|source| is_own(&source.name)).map(|source| &source.name[..]).collect();
    assert!(own.len() >= 4, "{own:?}");
    let mut n_lines = 0;
    for source in sources.iter().filter(|source| is_own(&source.name) || source.name == "bin/hexcast/verify.rs") {
        let name = &source.name;
        for path in paths(&source.code, "hexcast") {
            let path = path.trim_start_matches("hexcast::");
            let is_allowed = LIBRARY.iter().any(|known| path == *known || path.starts_with(&format!("{known}::")));
            assert!(is_allowed, "src/{name} uses hexcast::{path}");
        }
        let modules: BTreeSet<String> =
            own.iter().map(|name| format!("super::{}", &name["bin/hexcast/verify/".len()..name.len() - 3])).collect();
        for path in paths(&source.code, "super") {
            let start = path.splitn(3, "::").take(2).collect::<Vec<_>>().join("::");
            let is_allowed = if is_own(name) { modules.contains(&start) } else { COMMANDS.contains(&&start[..]) };
            assert!(is_allowed, "src/{name} uses {path}");
        }
        let used = paths(&source.code, "crate");
        assert!(used.is_empty(), "src/{name} uses {used:?}");
        n_lines += if is_own(name) { source.code.lines().filter(|line| !line.trim().is_empty()).count() } else { 0 };
    }
    assert!(n_lines <= MOST_LINES, "the check has {n_lines} lines of code");
}
